//! Random transfer functions. Their values are fractions of the range of values that the volume has.

use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{ControlPoint, OpacityRule, TransferFunction, Volume};

/// A transfer function apart from the volume that it is for.
#[derive(Clone, Debug)]
pub(super) struct Recipe {
    /// Sorted fractions of the range of values, colours, opacities, emissions.
    points: Vec<(f64, [f64; 3], f64, [f64; 3])>,
    kind: Kind,
    rule: OpacityRule,
    /// Unit distance, in mean spacings.
    unit_distance: f64,
}

/// The kind of light that is given.
#[derive(Clone, Copy, Debug)]
enum Kind {
    DensityEmitter,
    EmissionAlone,
    AbsorptionAlone,
    EmissionAndAbsorption,
}

impl Recipe {
    pub fn of_volume(&self, volume: &Volume) -> TransferFunction {
        let ((low, high), mean_spacing) = (value_range(volume), volume.mean_spacing());
        // A constant volume: points on both sides of its value, as likely as one on it.
        let (low, high) = if low == high { (low - 1.0, low + 1.0) } else { (low, high) };
        let unit_distance = self.unit_distance * mean_spacing;
        let point = |&(value, color, opacity, emission): &(f64, [f64; 3], f64, [f64; 3])| {
            let value = low + value * (high - low);
            // As bright, per mean spacing, whatever the scale of the world.
            let emission = emission.map(|e| e / unit_distance);
            match self.kind {
                Kind::DensityEmitter => ControlPoint::new(value, color, opacity),
                Kind::EmissionAlone => ControlPoint { value, color, opacity: 0.0, emission: Some(emission) },
                Kind::AbsorptionAlone => ControlPoint { value, color, opacity, emission: Some([0.0; 3]) },
                Kind::EmissionAndAbsorption => ControlPoint { value, color, opacity, emission: Some(emission) },
            }
        };
        TransferFunction::new(self.points.iter().map(point).collect(), self.rule, unit_distance)
            .expect("strategies make valid transfer functions")
    }
}

/// Range of values that parts of scenes are fractions of. The field of points falls to 0 between them.
pub(super) fn value_range(volume: &Volume) -> (f64, f64) {
    let (low, high) = volume.value_range().unwrap_or((0.0, 1.0));
    if volume.points().is_some() { (low.min(0.0), high.max(0.0)) } else { (low, high) }
}

/// Any transfer function for a volume: one to six points, jumps, opacities from 10⁻¹² to plateaus of 1, both rules, density
/// emitters, pure emission, pure absorption, and both given apart.
pub fn transfer(volume: Volume) -> impl Strategy<Value = TransferFunction> {
    recipe().prop_map(move |r| r.of_volume(&volume))
}

/// A transfer function without jumps, with opacities of at most 0.95.
pub fn tame_transfer(volume: Volume) -> impl Strategy<Value = TransferFunction> {
    tame_recipe().prop_map(move |r| r.of_volume(&volume))
}

/// A transfer function without kinks inside the volume's range of values, with opacities from 0.02 to 0.8 that differ by at least
/// 0.1 from one end to the other.
pub fn smooth_transfer(volume: Volume) -> impl Strategy<Value = TransferFunction> {
    smooth_recipe().prop_map(move |r| r.of_volume(&volume))
}

pub(super) fn recipe() -> impl Strategy<Value = Recipe> {
    let opacity = prop_oneof![2 => Just(0.0), 4 => 0.0..1.0, 2 => Just(1.0), 1 => tiny()];
    // Close values are as likely as far ones: spikes narrower than a cell's range.
    let gap = prop_oneof![1 => Just(0.0), 3 => 0.0..0.5, 1 => 0.0..0.01];
    from_parts(gap, opacity, 1..=6)
}

pub(super) fn tame_recipe() -> impl Strategy<Value = Recipe> {
    let opacity = prop_oneof![2 => Just(0.0), 5 => 0.0..0.95, 1 => tiny()];
    from_parts(0.1..0.5, opacity, 1..=5)
}

pub(super) fn smooth_recipe() -> impl Strategy<Value = Recipe> {
    (0.02..0.4, 0.1..0.4, any::<bool>(), [color(), color()], [color(), color()], kind(), rule(), 0.5..2.0).prop_map(
        |(low, more, falls, colors, emissions, kind, rule, unit_distance)| {
            let (first, last) = if falls { (low + more, low) } else { (low, low + more) };
            let points = vec![(-0.01, colors[0], first, emissions[0]), (1.01, colors[1], last, emissions[1])];
            Recipe { points, kind, rule, unit_distance }
        },
    )
}

/// Jumps, one to three: to opaque, to nearly so, to anything; from fog or from nothing; with the same colour on both sides, or
/// with black or another one.
pub(super) fn jumping_recipe() -> impl Strategy<Value = Recipe> {
    let before = prop_oneof![1 => Just(0.0), 2 => 0.0..0.5];
    let after = prop_oneof![2 => Just(1.0), 2 => Just(0.999), 3 => 0.0..1.0];
    let colors = prop_oneof![
        1 => color().prop_map(|c| (c, c)),
        1 => color().prop_map(|c| ([0.0; 3], c)),
        2 => (color(), color()),
    ];
    let jump = (0.1..0.35, before, after, colors, color());
    (vec(jump, 1..=3), 0.05..0.4, kind(), rule(), 0.5..4.0).prop_map(|(jumps, first, kind, rule, unit_distance)| {
        let mut value = first;
        let mut points = Vec::new();
        for (gap, before, after, (below, above), emission) in jumps {
            points.push((value, below, before, emission.map(|e| 0.3 * e)));
            points.push((value, above, after, emission));
            value += gap;
        }
        Recipe { points, kind, rule, unit_distance }
    })
}

/// One or two triangles, 0.003 to 0.05 of the range of values wide: shells much thinner than a cell.
pub(super) fn spiked_recipe() -> impl Strategy<Value = Recipe> {
    let width = (-2.5..-1.3).prop_map(|e| libm::pow(10.0, e));
    let peak = prop_oneof![1 => Just(1.0), 2 => Just(0.999), 3 => 0.2..1.0];
    let fog = prop_oneof![2 => Just(0.0), 1 => 0.0..0.1];
    let spike = (0.1..0.4, width, peak, color(), color());
    (vec(spike, 1..=2), fog, color(), -0.05..0.4, kind(), rule(), 0.3..2.0).prop_map(
        |(spikes, fog, fog_color, first, kind, rule, unit_distance)| {
            let mut value = first;
            let mut points = Vec::new();
            for (gap, width, peak, color, emission) in spikes {
                value += gap;
                points.push((value - 0.5 * width, fog_color, fog, [0.0; 3]));
                points.push((value, color, peak, emission));
                points.push((value + 0.5 * width, fog_color, fog, [0.0; 3]));
            }
            Recipe { points, kind, rule, unit_distance }
        },
    )
}

/// A ramp up to a plateau of 1, the colour changing on it.
pub(super) fn opaque_recipe() -> impl Strategy<Value = Recipe> {
    ([color(), color(), color()], 0.0..0.5, 0.02..0.4, 0.0..0.3, rule(), 0.5..2.0).prop_map(
        |([before, entry, inside], first, ramp, fog, rule, unit_distance)| Recipe {
            points: vec![
                (first, before, fog, [0.0; 3]),
                (first + ramp, entry, 1.0, [0.0; 3]),
                (1.1, inside, 1.0, [0.0; 3]),
            ],
            kind: Kind::DensityEmitter,
            rule,
            unit_distance,
        },
    )
}

/// Each of so many labels, at equal distances over the range of values, has a colour and an opacity of its own; jumps half-way.
pub(super) fn label_recipe(labels: usize) -> impl Strategy<Value = Recipe> {
    let opacity = prop_oneof![2 => Just(0.0), 1 => Just(1.0), 3 => 0.0..1.0];
    let look = vec((color(), opacity, color()), labels + 1);
    (look, rule(), 0.5..2.0).prop_map(move |(looks, rule, unit_distance)| {
        let edge = |i: usize| (i as f64 - 0.5) / labels as f64;
        let points = looks.iter().enumerate();
        let points = points.flat_map(|(i, &(c, a, e))| [(edge(i), c, a, e), (edge(i + 1), c, a, e)]).collect();
        Recipe { points, kind: Kind::DensityEmitter, rule, unit_distance }
    })
}

/// Each of so many labels, at equal distances over the range of values, is the tip of a triangle that reaches no other label.
pub(super) fn peak_recipe(labels: usize) -> impl Strategy<Value = Recipe> {
    let opacity = prop_oneof![1 => Just(0.0), 2 => Just(1.0), 1 => Just(0.999), 1 => 0.0..1.0];
    let look = vec((color(), opacity, 0.05..0.5), labels + 1);
    (look, color(), rule(), 0.5..2.0).prop_map(move |(looks, foot, rule, unit_distance)| {
        let place = |i: usize, side: f64| (i as f64 + side) / labels as f64;
        let triangle = |(i, (tip, opacity, width)): (usize, ([f64; 3], f64, f64))| {
            let none = |side: f64| (place(i, side), foot, 0.0, [0.0; 3]);
            [none(-width), (place(i, 0.0), tip, opacity, [0.0; 3]), none(width)]
        };
        let points = looks.into_iter().enumerate().flat_map(triangle).collect();
        Recipe { points, kind: Kind::DensityEmitter, rule, unit_distance }
    })
}

/// A transfer function that gives emission on its own, with jumps or without.
pub(super) fn emitting_recipe() -> impl Strategy<Value = Recipe> {
    let recipe = prop_oneof![2 => tame_recipe(), 1 => jumping_recipe()];
    let kind = prop_oneof![1 => Just(Kind::EmissionAlone), 2 => Just(Kind::EmissionAndAbsorption)];
    (recipe, kind).prop_map(|(recipe, kind)| Recipe { kind, ..recipe })
}

/// Light that is κ·c: all that shading acts on.
pub(super) fn reflecting_recipe() -> impl Strategy<Value = Recipe> {
    tame_recipe().prop_map(|recipe| Recipe { kind: Kind::DensityEmitter, ..recipe })
}

fn from_parts(
    gap: impl Strategy<Value = f64>,
    opacity: impl Strategy<Value = f64>,
    points: std::ops::RangeInclusive<usize>,
) -> impl Strategy<Value = Recipe> {
    let point = (gap, color(), opacity, color());
    (vec(point, points), -0.2..0.8, kind(), rule(), 0.1..10.0).prop_map(|(points, first, kind, rule, unit_distance)| {
        let mut value = first;
        let place = |(i, (gap, color, opacity, emission))| {
            value += if i == 0 { 0.0 } else { gap };
            (value, color, opacity, emission)
        };
        Recipe { points: points.into_iter().enumerate().map(place).collect(), kind, rule, unit_distance }
    })
}

fn color() -> impl Strategy<Value = [f64; 3]> {
    let component = || prop_oneof![1 => Just(0.0), 1 => Just(1.0), 3 => 0.0..1.0];
    [component(), component(), component()]
}

fn tiny() -> impl Strategy<Value = f64> {
    (-12.0..-2.0).prop_map(|e| libm::pow(10.0, e))
}

fn kind() -> impl Strategy<Value = Kind> {
    prop_oneof![
        5 => Just(Kind::DensityEmitter),
        1 => Just(Kind::EmissionAlone),
        1 => Just(Kind::AbsorptionAlone),
        2 => Just(Kind::EmissionAndAbsorption),
    ]
}

fn rule() -> impl Strategy<Value = OpacityRule> {
    prop_oneof![2 => Just(OpacityRule::Power), 1 => Just(OpacityRule::Extinction)]
}
