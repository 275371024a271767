//! A survey of a volume, and the look that follows from it.

use std::sync::Arc;

use glam::DVec3;
use vr_core::optics::opacity_of_depth;
use vr_core::parallel::collect;
use vr_core::{Clip, ColorValue, Compositing, ControlPoint, Field, Filter, Shading, TransferFunction, Volume};

use crate::exposure;
use crate::kind::{Kind, Values, kind_of, scale_of_colors};
use crate::lattice::Lattice;
use crate::number::short;
use crate::opacity::{Histogram, Shares, of_magnitude, of_place};
use crate::palette;
use crate::polyline::simplified;
use crate::scale::{BINS, Scale};

/// Facts about a volume besides its values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hints {
    /// True if the file places the volume in a patient: it is a scan then, whatever its numbers are stored as.
    pub patient: bool,
    /// True if the file is a microscope's map of a density: what lies below zero is noise.
    pub map: bool,
    /// The operator that the look is for.
    pub compositing: Compositing,
}

impl Hints {
    /// True if the volume was measured.
    pub(crate) fn is_scan(&self) -> bool {
        self.patient || self.map
    }
}

/// A first look at a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The kind of data that was found.
    pub kind: Kind,
    /// Control points for a unit distance of [`Volume::mean_spacing`].
    pub points: Vec<ControlPoint>,
    /// Shading by a headlight, where there are surfaces.
    pub shading: Option<Shading>,
    /// The filter, where the default is wrong.
    pub filter: Option<Filter>,
    /// One line on the method and what it found.
    pub reason: String,
}

/// Samples of a volume, from which everything else follows.
pub struct Survey {
    pub(crate) lattice: Lattice,
    pub(crate) values: Values,
    pub(crate) integer: bool,
    pub(crate) can_shade: bool,
    /// Source of the values, where voxels have colours.
    colors: Option<ColorValue>,
    /// True if places have colours, which are shown as they are.
    has_colors: bool,
    spacing: f64,
}

/// Largest opacity of a unit distance: surfaces end at once, and stay finite.
const MAX_OPACITY: f64 = 0.95;

impl Survey {
    /// Returns the survey of a volume: of a million voxels of a grid at most, and of a coarse lattice of anything else. A grid or points keep
    /// theirs, so that it is made once.
    pub fn of(volume: &Volume) -> Arc<Self> {
        let make = || Self::new(volume);
        match volume.derived() {
            Some(derived) => derived.get(volume.colors().map(|colors| colors.value_source()), make),
            None => Arc::new(make()),
        }
    }

    fn new(volume: &Volume) -> Self {
        let lattice = Lattice::new(volume);
        let values = Values::new(&lattice);
        let can_shade = match volume {
            Volume::Grid(_) | Volume::Color(_) => true,
            Volume::Points(_) => false,
            Volume::Cells(mesh) => mesh.has_gradient(),
            Volume::Rectilinear(grid) => grid.has_gradient(),
            Volume::Amr(grid) => grid.has_gradient(),
            Volume::Field(field) => field.has_gradient(),
        };
        Self {
            values,
            integer: volume.grid().is_some_and(|grid| grid.voxel_type().is_integer()),
            can_shade,
            colors: volume.colors().map(|colors| colors.value_source()),
            has_colors: volume.has_colors(),
            spacing: volume.mean_spacing(),
            lattice,
        }
    }

    /// The look for a volume under an operator.
    pub fn look(&self, hints: &Hints) -> Look {
        let (kind, scale) = match self.colors {
            Some(_) => (Kind::Color, scale_of_colors(&self.values)),
            None => kind_of(&self.lattice, &self.values, self.integer, hints.is_scan()),
        };
        let mut look = match kind {
            kind if !hints.compositing.integrates_light() => self.of_picked_values(kind, scale, hints.compositing),
            Kind::Labels(values) => self.of_labels(values),
            kind => self.of_values(kind, scale),
        };
        if self.has_colors {
            look.points.iter_mut().for_each(|point| point.color = [1.0; 3]);
        }
        look
    }

    /// The value is shown, not an opacity: grey over the values, or the one colour of a surface.
    fn of_picked_values(&self, kind: Kind, scale: Scale, compositing: Compositing) -> Look {
        let (low, high) = (scale.value(0.0), scale.value(1.0));
        let points = match (compositing, scale) {
            _ if kind == Kind::Color => vec![ControlPoint::new(low, [1.0; 3], 1.0)],
            (Compositing::First { .. }, _) => vec![ControlPoint::new(low, palette::tissue(0.5), 1.0)],
            (_, Scale::Linear { .. }) => {
                vec![ControlPoint::new(low, [0.0; 3], 1.0), ControlPoint::new(high, [1.0; 3], 1.0)]
            }
            // As straight as a logarithm can be drawn.
            (_, Scale::Logarithmic { .. }) => {
                let at = |k: usize| k as f64 / 32.0;
                (0..=32).map(|k| ControlPoint::new(scale.value(at(k)), [at(k); 3], 1.0)).collect()
            }
        };
        let shading = matches!(compositing, Compositing::First { .. }) && self.can_shade;
        let reason = match self.colors {
            Some(source) => format!("look: {} where {} is picked", kind.name(), source.name()),
            None => format!("look: {}, the value itself from {} to {}", kind.name(), short(low), short(high)),
        };
        Look { kind, points, shading: shading.then(lit), filter: None, reason }
    }

    /// Solid regions of a colour each; the background is clear.
    fn of_labels(&self, values: Vec<f64>) -> Look {
        const TARGET: f64 = 0.9;
        let background = self.label_around(&values);
        let share = |i: usize| {
            let value = self.lattice.values[i];
            if value.is_nan() || value == background { 0.0 } else { 1.0 }
        };
        let factor = exposure::solve(&self.lattice, self.spacing, TARGET, share).unwrap_or(1.0);
        // A region is a voxel thick at least.
        let opacity = opacity_of_depth(factor).clamp(0.3, MAX_OPACITY);
        let mut points = Vec::new();
        let mut rank = 0;
        for (i, &value) in values.iter().enumerate() {
            let (color, opacity) = if value == background {
                ([0.0; 3], 0.0)
            } else {
                rank += 1;
                // A mask alone is a shape, not a region among others.
                let color = if values.len() == 2 { palette::tissue(0.55) } else { palette::label_color(rank - 1) };
                (color, opacity)
            };
            // Each holds half-way to its neighbours, where the next one begins.
            let half_way = |j: usize| 0.5 * (values[j] + value);
            let low = i.checked_sub(1).map_or(value, half_way);
            let high = if i + 1 < values.len() { half_way(i + 1) } else { value };
            points.push(ControlPoint::new(low, color, opacity));
            points.push(ControlPoint::new(high, color, opacity));
        }
        let regions = rank;
        let kind = Kind::Labels(values);
        let reason =
            format!("look: {} of {regions} regions, a colour each; {} is clear", kind.name(), short(background));
        Look { kind, points, shading: self.can_shade.then(lit), filter: Some(Filter::Nearest), reason }
    }

    /// The label that most of the faces of the box have; 0 where that is a label.
    fn label_around(&self, values: &[f64]) -> f64 {
        if values.contains(&0.0) {
            return 0.0;
        }
        let [nx, ny, nz] = self.lattice.dims;
        let mut counts = vec![0usize; values.len()];
        for (i, value) in self.lattice.values.iter().enumerate().filter(|(_, v)| !v.is_nan()) {
            let at = [(i % nx, nx), (i / nx % ny, ny), (i / (nx * ny), nz)];
            if at.iter().any(|&(k, n)| k == 0 || k + 1 == n) {
                counts[values.partition_point(|v| v < value).min(values.len() - 1)] += 1;
            }
        }
        let most = (0..values.len()).max_by_key(|&i| counts[i]).unwrap_or(0);
        values[most]
    }

    /// Boundaries, or all that is much, of a measured or computed quantity.
    fn of_values(&self, kind: Kind, scale: Scale) -> Look {
        let histogram = Histogram::new(&self.lattice, scale);
        let shares = match kind {
            Kind::Signed => of_magnitude(),
            Kind::HeavyTail => histogram.of_tail(),
            Kind::Color if self.colors == Some(ColorValue::Opacity) => of_place(),
            _ => histogram.of_boundaries(),
        };
        // Surfaces reflect, fog does not.
        const SHARP: f64 = 0.01;
        let surfaces = kind != Kind::HeavyTail && histogram.sharpness(&shares.of_bins, scale) > SHARP;
        let target = match self.colors {
            // Pictures are of solid things, unless they say themselves what is clear.
            Some(source) if source != ColorValue::Opacity => 0.9,
            _ if surfaces => 0.75,
            _ => 0.6,
        };
        let share = |i: usize| {
            let value = self.lattice.values[i];
            if value.is_nan() { 0.0 } else { shares.of_bins[scale.bin(value)] }
        };
        let factor = exposure::solve(&self.lattice, self.spacing, target, share).unwrap_or(1.0);
        let points = control_points(&kind, scale, &shares, factor);
        let shown = match kind {
            Kind::Signed => "by magnitude".to_owned(),
            Kind::HeavyTail => format!("on a logarithmic scale from {}", short(scale.value(shares.begin))),
            Kind::Color => {
                let source = self.colors.map_or("the value", ColorValue::name);
                format!("by {source} from {}", short(scale.value(shares.begin)))
            }
            _ => {
                let begin = short(scale.value(shares.begin));
                format!("by value and mean gradient (Kindlmann & Durkin 1998) from {begin}")
            }
        };
        let light = if surfaces && self.can_shade { ", shaded" } else { "" };
        let reason = format!("look: {}, opacity {shown}, {target} in the mean{light}", kind.name());
        Look { kind, points, shading: (surfaces && self.can_shade).then(lit), filter: None, reason }
    }

    /// World positions that enclose all that a transfer function makes visible: what adds less than four steps of 8 bits is not, and neither are
    /// single voxels, nor what is clipped. All of the volume where nothing is.
    pub fn visible(&self, transfer: &TransferFunction, compositing: Compositing, clip: &Clip) -> Vec<DVec3> {
        const FAINT: f64 = 4.0 / 255.0;
        let [nx, ny, nz] = self.lattice.dims;
        let cell = libm::cbrt(self.lattice.axes.determinant().abs());
        let shows_value = |value: f64| {
            let light = if compositing.integrates_light() {
                let [r, g, b, a] = transfer.step(value, cell);
                r.max(g).max(b).max(a)
            } else {
                let [r, g, b, _] = transfer.at(value).pixel();
                r.max(g).max(b)
            };
            light > FAINT
        };
        // By steps of the range: where both ends and the middle of one agree, so do the values between; elsewhere each is asked for.
        const STEPS: usize = 1024;
        let finite = || self.lattice.values.iter().copied().filter(|v| !v.is_nan());
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let width = (high - low).max(f64::MIN_POSITIVE) / STEPS as f64;
        let step = |k: usize| {
            let [first, middle, last] = [0.0, 0.5, 1.0].map(|t| shows_value(low + (k as f64 + t) * width));
            (first == middle && middle == last).then_some(first)
        };
        let steps: Vec<Option<bool>> = (0..STEPS).map(step).collect();
        let per_width = 1.0 / width;
        // NaN and what is below are 0 by the cast.
        let step_of = |value: f64| (((value - low) * per_width) as usize).min(STEPS - 1);
        let shown = |&v: &f64| !v.is_nan() && steps[step_of(v)].unwrap_or_else(|| shows_value(v));
        let slice = |z: usize| self.lattice.values[z * nx * ny..][..nx * ny].iter().map(shown).collect::<Vec<bool>>();
        let shows = collect(nz, slice).concat();
        let at = |x: usize, y: usize, z: usize| shows[(z * ny + y) * nx + x];
        // Noise is alone; of what is not, two of the neighbours show, too.
        let among = |x: usize, y: usize, z: usize| {
            let pairs = [(x, nx), (y, ny), (z, nz)];
            let lines: usize = pairs.iter().filter(|(_, n)| *n > 1).count();
            let mut count = 0;
            for (axis, &(k, n)) in pairs.iter().enumerate() {
                for neighbour in [k.checked_sub(1), (k + 1 < n).then_some(k + 1)].into_iter().flatten() {
                    let mut p = [x, y, z];
                    p[axis] = neighbour;
                    count += usize::from(at(p[0], p[1], p[2]));
                }
            }
            count >= lines.min(2)
        };
        // The ends of each row enclose the rest of it. A voxel reaches half-way to its neighbours.
        let mut points = Vec::new();
        for z in 0..nz {
            for y in 0..ny {
                let row = &shows[(z * ny + y) * nx..][..nx];
                let among = |x: &usize| row[*x] && among(*x, y, z) && keeps(clip, self.lattice.position([*x, y, z]));
                let ends = [(0..nx).find(among), (0..nx).rev().find(among)];
                points.extend(ends.into_iter().flatten().map(|x| self.lattice.position([x, y, z])));
            }
        }
        if points.len() < 2 { self.lattice.corners().to_vec() } else { points }
    }
}

/// True if a place is kept.
fn keeps(clip: &Clip, at: DVec3) -> bool {
    let boxed = clip.crop.is_none_or(|(low, high)| at.cmpge(low).all() && at.cmple(high).all());
    boxed && clip.planes.iter().all(|plane| plane.normal.dot(at) >= plane.offset)
}

/// Shading of a first look: a headlight, brighter than the default, for colours are dark brown at the least.
fn lit() -> Shading {
    Shading { ambient: 0.35, diffuse: 0.75, specular: 0.25, power: 24.0, ..Shading::default() }
}

/// The control points of shares under a factor, as few as do.
fn control_points(kind: &Kind, scale: Scale, shares: &Shares, factor: f64) -> Vec<ControlPoint> {
    let opacity = |bin: usize| opacity_of_depth(factor * shares.of_bins[bin]).min(MAX_OPACITY);
    let color = |place: f64| {
        let up = ((place - shares.begin) / (1.0 - shares.begin)).clamp(0.0, 1.0);
        match kind {
            Kind::Hounsfield => palette::hounsfield(scale.value(place)),
            Kind::Signed => palette::signed(place),
            Kind::HeavyTail => palette::density(up),
            Kind::Field => palette::field(up),
            Kind::Color => [1.0; 3],
            _ => palette::tissue(up),
        }
    };
    let largest = (0..BINS).map(opacity).fold(f64::MIN_POSITIVE, f64::max);
    // A percent of the largest opacity, and of white.
    let bins = simplified(BINS, 0.01, &|bin| {
        let [r, g, b] = color(Scale::middle(bin));
        [scale.value(Scale::middle(bin)), opacity(bin) / largest, r, g, b]
    });
    let point =
        |bin: usize| ControlPoint::new(scale.value(Scale::middle(bin)), color(Scale::middle(bin)), opacity(bin));
    bins.into_iter().map(point).collect()
}
