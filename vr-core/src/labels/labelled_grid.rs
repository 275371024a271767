//! A grid and its labels, as a field.

use std::sync::Arc;

use glam::DVec3;

use super::boundary::{BoundaryCell, OpenSides};
use super::error::LabelError;
use super::label_map::{LabelMap, corners};
use super::line::LabelledLine;
use super::style::LabelStyle;
use crate::error::ParameterError;
use crate::field::{Field, FieldLine};
use crate::filter::Filter;
use crate::grid_volume::GridVolume;
use crate::ray::Ray;
use crate::shading::GradientMethod;
use crate::transfer::{ControlPoint, TransferFunction};
use crate::view::Clip;

/// A grid whose places are drawn in the style of their label.
///
/// The field's value is a code: in the band of the style `k`, an interval of its own, lies the grid's value plus k times the width of a band;
/// a solid style has one value, the middle of its band, and a hidden one is vacuum. Band 0 is the grid as it is. A transfer function for the
/// grid becomes one for the codes by [`LabelledGrid::transfer`]. Codes must be neither interpolated nor compared with each other, so
/// operators that pick a value ([`Compositing::Maximum`](crate::Compositing::Maximum), …) go with them only where all there is to see is the
/// grid as it is: a mask.
///
/// Normals are those of the grid's own gradient where the grid is seen, and of the smoothed boundary of the region in solid styles (zero,
/// so that nothing is shaded, more than two voxels inside), in the grid's range of values per world unit.
///
/// # Examples
/// ```
/// use std::sync::Arc;
///
/// use glam::DVec3;
/// use vr_core::labels::{LabelMap, LabelStyle, LabelledGrid};
/// use vr_core::{AnyGrid, Calibration, ControlPoint, Field, Filter, GridVolume, OpacityRule, Placement};
/// use vr_core::{Scene, TransferFunction, UniformGrid, Volume};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let placement = Placement::from_spacing([1.0; 3])?;
/// let values = UniformGrid::new([3; 3], (0..27u8).collect::<Vec<_>>(), placement, Calibration::default())?;
/// let labels = UniformGrid::new([3; 3], [vec![0u8; 18], vec![5; 9]].concat(), placement, Calibration::default())?;
/// let volume = Arc::new(GridVolume::new(values.into(), Filter::Trilinear));
/// let map = Arc::new(LabelMap::new(&AnyGrid::from(labels))?);
///
/// // Label 5 is a red solid; the rest is the volume, through its own transfer function.
/// let red = LabelStyle::Solid { color: [1.0, 0.0, 0.0], opacity: 0.8 };
/// let labelled = LabelledGrid::new(volume, map, |label| if label == 5 { red } else { LabelStyle::VOLUME })?;
/// let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.0), ControlPoint::new(26.0, [1.0; 3], 0.1)];
/// let transfer = labelled.transfer(&TransferFunction::new(points, OpacityRule::Power, 1.0)?)?;
///
/// let here = labelled.value(DVec3::new(1.0, 1.0, 1.9)).expect("in the volume");
/// assert_eq!(transfer.at(here).color, [1.0, 0.0, 0.0]);
/// let there = labelled.value(DVec3::new(1.0, 1.0, 1.0)).expect("in the volume");
/// assert_eq!(there, 13.0, "the volume's own value");
/// let scene = Scene::new(Volume::Field(Arc::new(labelled)), transfer);
/// assert!(scene.validate().is_ok());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct LabelledGrid {
    pub(super) volume: Arc<GridVolume>,
    pub(super) labels: Arc<LabelMap>,
    /// The style of each band, all different; the first is the volume as it is.
    styles: Vec<LabelStyle>,
    /// Code of each rank.
    codes: Vec<LabelCode>,
    /// Lower end of band 0, and the width of each.
    low: f64,
    width: f64,
    /// Factor on the gradient of a region, which goes from 0 to 1.
    contrast: f64,
    pub(super) gradient: GradientMethod,
    /// True if voxel and label of an index are at the same place.
    pub(super) shared: bool,
    open: OpenSides,
}

/// Code of a label: the field's value where the label holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LabelCode {
    /// Vacuum, of a hidden style.
    Vacuum,
    /// The grid's value plus this: the begin of the style's band.
    Offset(f64),
    /// One value, of a solid style.
    Constant(f64),
}

impl LabelledGrid {
    /// A grid under labels, each in the style that `style` gives for it.
    ///
    /// # Errors
    /// [`LabelError::Apart`] for labels that do not overlap the volume, [`LabelError::Style`] for a style out of range.
    pub fn new(
        volume: Arc<GridVolume>,
        labels: Arc<LabelMap>,
        mut style: impl FnMut(i32) -> LabelStyle,
    ) -> Result<Self, LabelError> {
        let open = open_sides(&volume, &labels)?;
        // A band holds all values of the field, and some room, so that no rounding leads into the next one. Cubic filters overshoot.
        let (min, max) = volume.value_range().unwrap_or((0.0, 1.0));
        let contrast = if max > min { max - min } else { max.abs().max(1.0) };
        let room = contrast * if volume.filter().reach() == 0 { 0.25 } else { 32.0 };
        let (low, width) = (min - room, max - min + 2.0 * room);
        // Labels of one style share its band.
        let mut styles = vec![LabelStyle::VOLUME];
        let mut codes = Vec::with_capacity(labels.labels().len());
        for &label in labels.labels() {
            let style = style(label);
            style.check(label)?;
            if style.is_hidden() {
                codes.push(LabelCode::Vacuum);
                continue;
            }
            let band = styles.iter().position(|&s| s == style).unwrap_or_else(|| {
                styles.push(style);
                styles.len() - 1
            });
            let offset = band as f64 * width;
            codes.push(if style.is_solid() {
                LabelCode::Constant(low + offset + 0.5 * width)
            } else {
                LabelCode::Offset(offset)
            });
        }
        let shared = volume.placement() == labels.placement() && volume.dims() == labels.dims();
        let gradient = GradientMethod::default();
        Ok(Self { volume, labels, styles, codes, low, width, contrast, gradient, shared, open })
    }

    /// The same with another source of the grid's gradient.
    #[must_use]
    pub fn with_gradient(self, gradient: GradientMethod) -> Self {
        Self { gradient, ..self }
    }

    /// The grid.
    pub fn volume(&self) -> &Arc<GridVolume> {
        &self.volume
    }

    /// The labels.
    pub fn labels(&self) -> &Arc<LabelMap> {
        &self.labels
    }

    /// Source of the grid's gradient.
    pub fn gradient_method(&self) -> GradientMethod {
        self.gradient
    }

    /// The codes of its labels, each once.
    pub fn codes(&self) -> Vec<LabelCode> {
        let mut codes = Vec::new();
        for code in &self.codes {
            if !codes.contains(code) {
                codes.push(*code);
            }
        }
        codes
    }

    /// Code of the label of a world position.
    pub fn code_at(&self, at: DVec3) -> LabelCode {
        self.code(self.labels.rank_near(self.labels.placement().to_index(at)))
    }

    /// Gradient per world unit, at a world position, of the smoothed region in which a code holds: that of the field where a solid style is drawn.
    pub fn region_gradient_at(&self, at: DVec3, code: LabelCode) -> DVec3 {
        self.gradient_near(self.labels.placement().to_index(at), code)
    }

    /// The same at a position among the labels.
    fn gradient_near(&self, position: DVec3, code: LabelCode) -> DVec3 {
        self.region_gradient(self.boundary(position, code).gradient(position))
    }

    /// Transfer function of the codes, from one for the grid's own values.
    ///
    /// # Errors
    /// A [`ParameterError`] for a solid style beside emission that is given on its own: it has a colour, and no emission; for rows by gradient,
    /// for codes have none.
    pub fn transfer(&self, volume: &TransferFunction) -> Result<TransferFunction, ParameterError> {
        if volume.has_rows() {
            let allowed =
                "must be by value alone beside labels: a gradient across the boundary of two labels means nothing";
            return Err(ParameterError::new("transfer.rows", volume.rows().len(), allowed));
        }
        let high = self.low + self.width;
        let within = |p: &&ControlPoint| p.value > self.low && p.value < high;
        // The ends of a band, with what the function is there.
        let point = |value: f64, at: crate::transfer::Optical| ControlPoint {
            emission: volume.has_emission().then_some(at.emission),
            ..ControlPoint::new(value, at.color, at.opacity)
        };
        let ends = [point(self.low, volume.at(self.low)), point(high, volume.at_below(high))];
        let mut points: Vec<ControlPoint> = volume.points().iter().filter(|p| p.value < high).copied().collect();
        points.push(ends[1]);
        for (band, style) in self.styles.iter().enumerate().skip(1) {
            let shift = band as f64 * self.width;
            let moved = |p: &ControlPoint| ControlPoint { value: p.value + shift, ..*p };
            let restyled = |tint: Option<[f64; 3]>, factor: f64| {
                move |p: &ControlPoint| ControlPoint {
                    opacity: p.opacity * factor,
                    color: tint.unwrap_or(p.color),
                    emission: p.emission.map(|e| {
                        let brightest = e[0].max(e[1]).max(e[2]);
                        tint.map_or(e, |tint| tint.map(|t| t * brightest)).map(|e| e * factor)
                    }),
                    ..moved(p)
                }
            };
            let all = ends[..1].iter().chain(volume.points().iter().filter(within)).chain(&ends[1..]);
            match *style {
                LabelStyle::Hidden => {}
                LabelStyle::Volume { opacity } => points.extend(all.map(restyled(None, opacity))),
                LabelStyle::Tinted { color, opacity } => points.extend(all.map(restyled(Some(color), opacity))),
                LabelStyle::Solid { .. } if volume.has_emission() => {
                    let allowed = "a solid label cannot stand beside points with emission of their own: draw it as the volume, or tinted";
                    return Err(ParameterError::new("labels", style, allowed));
                }
                LabelStyle::Solid { color, opacity } => {
                    points.extend(ends.iter().map(|p| ControlPoint::new(moved(p).value, color, opacity)));
                }
            }
        }
        TransferFunction::new(points, volume.rule(), volume.unit_distance())
    }

    /// True if a label is drawn in a solid style.
    pub(super) fn has_solids(&self) -> bool {
        self.codes.iter().any(|code| matches!(code, LabelCode::Constant(_)))
    }

    /// Code of a rank.
    #[inline]
    pub(super) fn code(&self, rank: u16) -> LabelCode {
        self.codes[usize::from(rank)]
    }

    /// Index-space position among the labels of a world position that is at `index` in the grid.
    fn among_labels(&self, at: DVec3, index: DVec3) -> DVec3 {
        if self.shared { index } else { self.labels.placement().to_index(at) }
    }

    /// Index-space position in the grid; `None` outside its box.
    fn index(&self, at: DVec3) -> Option<DVec3> {
        let index = self.volume.placement().to_index(at);
        let last = DVec3::from_array(self.volume.dims().map(|n| (n - 1) as f64));
        // What rounding carries past a face of the box is still in it.
        let clamped = index.clamp(DVec3::ZERO, last);
        ((index - clamped).abs().max_element() <= 1e-9 * last.max_element()).then_some(clamped)
    }

    /// The smoothed region of a code around a position among the labels.
    pub(super) fn boundary(&self, position: DVec3, code: LabelCode) -> BoundaryCell {
        BoundaryCell::around(&self.labels, position, &self.open, |rank| self.code(rank) == code)
    }

    /// World gradient of a region's gradient per index step of the labels.
    pub(super) fn region_gradient(&self, per_index: DVec3) -> DVec3 {
        self.labels.placement().gradient_to_world(per_index) * self.contrast
    }
}

/// Sides on which the volume goes on beyond the labels.
fn open_sides(volume: &GridVolume, labels: &LabelMap) -> Result<OpenSides, LabelError> {
    let hull = |all: [DVec3; 8]| {
        all.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)))
    };
    let apart = |a: (DVec3, DVec3), b: (DVec3, DVec3)| a.0.cmpgt(b.1).any() || b.0.cmpgt(a.1).any();
    // Each in the index space of the other.
    let box_of = |dims: [usize; 3], margin: f64| {
        (DVec3::splat(-margin), DVec3::from_array(dims.map(|n| n as f64 - 1.0 + margin)))
    };
    let (volume_corners, label_corners) =
        (corners(volume.placement(), volume.dims(), 0.0), corners(labels.placement(), labels.dims(), 0.5));
    let volume_here = hull(volume_corners.map(|c| labels.placement().to_index(c)));
    let labels_there = hull(label_corners.map(|c| volume.placement().to_index(c)));
    let (label_box, volume_box) = (box_of(labels.dims(), 0.5), box_of(volume.dims(), 0.0));
    if apart(volume_here, label_box) || apart(labels_there, volume_box) {
        let corners = |(low, high): (DVec3, DVec3)| Box::new([low.to_array(), high.to_array()]);
        return Err(LabelError::Apart { labels: corners(hull(label_corners)), volume: corners(hull(volume_corners)) });
    }
    let tiny = 1e-6;
    Ok(std::array::from_fn(|a| [volume_here.0[a] < label_box.0[a] - tiny, volume_here.1[a] > label_box.1[a] + tiny]))
}

impl Field for LabelledGrid {
    fn kind(&self) -> &'static str {
        "labelled grid"
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.volume.bounds()
    }

    fn spacing(&self) -> f64 {
        self.volume.placement().spacing().element_sum() / 3.0
    }

    fn value_range(&self) -> Option<(f64, f64)> {
        Some((self.low, self.low + self.styles.len() as f64 * self.width))
    }

    fn value(&self, at: DVec3) -> Option<f64> {
        let index = self.index(at)?;
        match self.code(self.labels.rank_near(self.among_labels(at, index))) {
            LabelCode::Vacuum => None,
            LabelCode::Constant(value) => Some(value),
            LabelCode::Offset(offset) => {
                let stored = self.volume.stored_at(index.to_array());
                (!stored.is_nan()).then(|| self.volume.calibration().value(stored) + offset)
            }
        }
    }

    fn as_labelled_grid(&self) -> Option<&LabelledGrid> {
        Some(self)
    }

    fn values_are_codes(&self) -> bool {
        self.codes.iter().any(|&code| code != LabelCode::Vacuum && code != LabelCode::Offset(0.0))
    }

    fn has_gradient(&self) -> bool {
        true
    }

    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        let index = self.index(at)?;
        let position = self.among_labels(at, index);
        let code = self.code(self.labels.rank_near(position));
        match code {
            LabelCode::Vacuum => None,
            LabelCode::Constant(_) => Some(self.gradient_near(position, code)),
            LabelCode::Offset(_) => {
                let place = index.to_array();
                let per_index = match self.gradient {
                    GradientMethod::Analytic => self.volume.stored_and_gradient_at(place).1,
                    GradientMethod::CentralDifferences => self.volume.central_differences_at(place),
                };
                Some(
                    self.volume.placement().gradient_to_world(DVec3::from(per_index) * self.volume.calibration().slope),
                )
            }
        }
    }

    fn jumps(&self, ray: &Ray, [from, to]: [f64; 2], out: &mut Vec<f64>) {
        LabelledLine::jumps(self, ray, [from, to], out);
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        Some(Box::new(LabelledLine::new(self, ray, clip, far, gradients)?))
    }

    fn prepare_derived(&self) {
        self.volume.prepare_derived();
    }
}

impl LabelledGrid {
    /// True if the grid's own field may jump inside its box.
    pub(super) fn grid_jumps(&self) -> bool {
        self.volume.filter() == Filter::Nearest || self.volume.vacuum_cells().is_some()
    }
}
