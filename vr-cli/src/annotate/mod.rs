//! Annotations: what is written over a finished picture. They are no part of the frame that errors are measured on, nor of an EXR.

mod axis;
mod legend;
mod marker;
mod round;
mod scale_bar;
mod sheet;
mod title;

use vr_core::Frame;
use vr_io::{AnnotationsSection, PngOptions};
use vr_look::{Hints, Kind, Survey};

use crate::args::{AnnotateArgs, Annotation};
use crate::canvas::Canvas;
use crate::console::Console;
use crate::failure::Failure;
use crate::scene_setup::Setup;
use crate::text;

use legend::Legend;
use marker::Marker;
use scale_bar::ScaleBar;
use sheet::Sheet;

/// Annotations of a picture, ready to be drawn.
pub struct Annotations {
    title: Option<String>,
    marker: Option<Marker>,
    scale: Option<ScaleBar>,
    legend: Option<Legend>,
}

impl Annotations {
    /// Makes the annotations that the scene file of a set-up asks for; `None` where it asks for none. Notes what is assumed of units, and what there is nothing
    /// to show of.
    ///
    /// # Errors
    /// A camera that cannot be.
    pub fn new(setup: &Setup, console: Console) -> Result<Option<Self>, Failure> {
        let section = &setup.file.annotations;
        if section.is_empty() {
            return Ok(None);
        }
        let (scene, view, info) = (&setup.scene, &setup.view, setup.info.as_ref());
        let is_patient = info.is_some_and(|info| info.space.is_patient());
        let marker = if section.marker {
            let marker = Marker::new(&view.camera, is_patient);
            Some(marker.map_err(|e| setup.render_failure(e.into()))?)
        } else {
            None
        };
        let scale = section.scale.then(|| {
            let named = info.and_then(|info| info.units.as_deref());
            if named.is_none() && is_patient {
                console.note("scale bar: the file names no unit; mm is assumed, as patients' spaces have it");
            } else if named.is_none() {
                console.note("scale bar: no unit of length is known; the number is in the world's own");
            }
            ScaleBar::new(view, named.or(is_patient.then_some("mm")))
        });
        let legend = if section.legend {
            let by_value = !scene.transfer.has_rows();
            let legend = by_value.then(|| Legend::new(scene, value_unit(setup))).flatten();
            if !by_value {
                console
                    .note("legend: left out, for colours follow the gradient too; vr tf FILE VOLUME -o PNG draws both");
            } else if legend.is_none() {
                console.note("legend: left out, for no value of the volume shows");
            }
            legend
        } else {
            None
        };
        Ok(Some(Self { title: section.title.clone(), marker, scale, legend }))
    }

    /// Draws over a frame as it is going to be written. Notes what the picture is too small for.
    pub fn over(&self, frame: &Frame, png: &PngOptions, console: Console) -> Frame {
        let mut canvas = Canvas::over(frame, (!png.alpha).then_some(png.background), png.encode);
        let mut sheet = Sheet::new(&mut canvas);
        let fits = [
            ("title", self.title.as_ref().is_none_or(|text| title::draw(text, &mut sheet))),
            ("orientation marker", self.marker.as_ref().is_none_or(|marker| marker.draw(&mut sheet))),
            ("scale bar", self.scale.as_ref().is_none_or(|scale| scale.draw(&mut sheet))),
            ("legend", self.legend.as_ref().is_none_or(|legend| legend.draw(&mut sheet))),
        ];
        for (what, _) in fits.iter().filter(|(_, fits)| !fits) {
            let [w, h] = frame.size();
            console.note(&format!("{what}: left out, for {w}x{h} pixels have no room for it; --size makes more"));
        }
        canvas.into_frame()
    }
}

/// Refuses flags that contradict each other, and a title that cannot be written.
///
/// # Errors
/// [`Failure::Usage`] naming the flag, and the first character that the font lacks.
pub fn check(args: &AnnotateArgs) -> Result<(), Failure> {
    if args.annotate.len() > 1 && args.annotate.contains(&Annotation::None) {
        return Err(Failure::usage("--annotate: found none among others; none goes alone"));
    }
    let title = args.title.as_deref().filter(|title| !title.is_empty());
    title.map_or(Ok(()), |title| check_title(title).map_err(|wrong| Failure::usage(format!("--title: {wrong}"))))
}

/// Lays flags over the annotations of a set-up's scene file.
///
/// # Errors
/// [`Failure::Failed`] for a title of the scene file that cannot be written.
pub fn apply(args: &AnnotateArgs, setup: &mut Setup) -> Result<(), Failure> {
    let AnnotationsSection { title, .. } = &setup.file.annotations;
    if let (None, Some(title)) = (&args.title, title) {
        let file = setup.scene_file().map_or_else(String::new, |path| format!("{}: ", path.display()));
        check_title(title).map_err(|wrong| Failure::failed(format!("{file}annotations.title: {wrong}")))?;
    }
    setup.file.annotations = args.over(&setup.file.annotations);
    Ok(())
}

/// Tells what is wrong with a title, if anything.
fn check_title(title: &str) -> Result<(), String> {
    if title.trim().is_empty() {
        return Err("found nothing but blanks; must be a text".to_owned());
    }
    match title.lines().find_map(text::missing) {
        Some(c) => Err(format!(
            "found {c:?}, which the embedded font lacks; it has Latin, Greek and Cyrillic letters and signs of mathematics"
        )),
        None => Ok(()),
    }
}

/// Returns the unit of the values of a volume: that of a CT, told by its scanner or by its values.
fn value_unit(setup: &Setup) -> Option<&'static str> {
    let info = setup.info.as_ref()?;
    let is_ct = match info.modality.as_deref() {
        Some(modality) => modality == "CT",
        None => {
            let hints = Hints { patient: info.space.is_patient(), ..Hints::default() };
            Survey::of(&setup.scene.volume).look(&hints).kind == Kind::Hounsfield
        }
    };
    is_ct.then_some("HU")
}
