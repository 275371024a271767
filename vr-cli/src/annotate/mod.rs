//! Annotations: what is written over a finished picture. They are no part of the frame that errors are measured on, nor of an EXR.

mod axis;
mod legend;
mod marker;
mod round;
mod scale_bar;
mod sheet;
mod title;

use vr_core::Frame;
use vr_io::PngOptions;
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
    /// Makes the annotations that flags ask for; `None` where they ask for none. Notes what is assumed of units, and what there is nothing to show of.
    ///
    /// # Errors
    /// A camera that cannot be.
    pub fn new(args: &AnnotateArgs, setup: &Setup, console: Console) -> Result<Option<Self>, Failure> {
        if args.is_empty() {
            return Ok(None);
        }
        let wants = |what: Annotation| args.annotate.contains(&what) || args.annotate.contains(&Annotation::All);
        let (scene, view, info) = (&setup.scene, &setup.view, setup.info.as_ref());
        let is_patient = info.is_some_and(|info| info.space.is_patient());
        let marker = if wants(Annotation::Marker) {
            let marker = Marker::new(&view.camera, is_patient);
            Some(marker.map_err(|e| setup.render_failure(e.into()))?)
        } else {
            None
        };
        let scale = wants(Annotation::Scale).then(|| {
            let named = info.and_then(|info| info.units.as_deref());
            if named.is_none() && is_patient {
                console.note("scale bar: the file names no unit; mm is assumed, as patients' spaces have it");
            } else if named.is_none() {
                console.note("scale bar: no unit of length is known; the number is in the world's own");
            }
            ScaleBar::new(view, named.or(is_patient.then_some("mm")))
        });
        let legend = if wants(Annotation::Legend) {
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
        Ok(Some(Self { title: args.title.clone(), marker, scale, legend }))
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

/// Refuses a title that cannot be written.
///
/// # Errors
/// [`Failure::Usage`] naming the first character that the font lacks.
pub fn check(args: &AnnotateArgs) -> Result<(), Failure> {
    let Some(title) = &args.title else { return Ok(()) };
    if title.trim().is_empty() {
        return Err(Failure::usage("--title: found nothing but blanks; must be a text"));
    }
    match title.lines().find_map(text::missing) {
        Some(c) => Err(Failure::usage(format!(
            "--title: found {c:?}, which the embedded font lacks; it has Latin, Greek and Cyrillic letters and signs of mathematics"
        ))),
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
            Survey::new(&setup.scene.volume).look(&hints).kind == Kind::Hounsfield
        }
    };
    is_ct.then_some("HU")
}
