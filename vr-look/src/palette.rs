//! Colours by kind of data, in linear light.

use vr_core::transfer::{cool_warm, inferno, srgb_to_linear, viridis};

/// A place on a scale, or a value in Hounsfield units, and a colour in sRGB.
type Stop = (f64, [f64; 3]);

/// Brown over tan and ivory to white: the further along, the denser.
const TISSUE: [Stop; 5] = [
    (0.0, [0.45, 0.20, 0.13]),
    (0.25, [0.78, 0.47, 0.33]),
    (0.5, [0.90, 0.72, 0.52]),
    (0.75, [0.96, 0.90, 0.78]),
    (1.0, [1.0, 1.0, 1.0]),
];

/// Skin and fat, muscle and organs, contrast agent, bone, metal.
const HOUNSFIELD: [Stop; 7] = [
    (-1000.0, [0.45, 0.22, 0.14]),
    (-500.0, [0.80, 0.52, 0.39]),
    (-50.0, [0.88, 0.63, 0.47]),
    (60.0, [0.78, 0.36, 0.28]),
    (200.0, [0.93, 0.75, 0.56]),
    (500.0, [0.97, 0.92, 0.80]),
    (1500.0, [1.0, 1.0, 1.0]),
];

/// Colour of tissue at a place of 0 to 1.
pub(crate) fn tissue(place: f64) -> [f64; 3] {
    along(&TISSUE, place)
}

/// Colour at a value in Hounsfield units.
pub(crate) fn hounsfield(value: f64) -> [f64; 3] {
    along(&HOUNSFIELD, value)
}

/// Colour of a field at a place of 0 to 1: viridis without its darkest quarter, which black swallows.
pub(crate) fn field(place: f64) -> [f64; 3] {
    viridis(0.25 + 0.75 * place)
}

/// Colour of a density at a place of 0 to 1: inferno without its darkest quarter.
pub(crate) fn density(place: f64) -> [f64; 3] {
    inferno(0.25 + 0.75 * place)
}

/// Colour of a value between the lowest, 0, and the highest, 1, of a scale about zero.
pub(crate) fn signed(place: f64) -> [f64; 3] {
    cool_warm(place)
}

/// Colour of the label of that rank, in linear light: hues a golden section of the circle apart, so that neighbours differ, however many there
/// are.
pub fn label_color(rank: usize) -> [f64; 3] {
    let hue = 6.0 * (0.08 + rank as f64 * 0.618_033_988_749_895).fract();
    let component = |shift: f64| {
        let place = (hue + shift) % 6.0;
        (2.0 - (place - 3.0).abs()).clamp(0.0, 1.0)
    };
    // Red is at 0 of the circle, green a third on, blue two.
    [component(3.0), component(1.0), component(5.0)].map(|c| srgb_to_linear(0.95 - 0.6 * c))
}

fn along(stops: &[Stop], at: f64) -> [f64; 3] {
    let after = stops.partition_point(|s| s.0 <= at);
    let (a, b) = (&stops[after.saturating_sub(1)], &stops[after.min(stops.len() - 1)]);
    let t = if b.0 > a.0 { ((at - a.0) / (b.0 - a.0)).clamp(0.0, 1.0) } else { 0.0 };
    [0, 1, 2].map(|k| srgb_to_linear(a.1[k] + t * (b.1[k] - a.1[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_colours_and_labels_differ() {
        for i in 0..=20 {
            let t = f64::from(i) / 20.0;
            for color in [tissue(t), field(t), density(t), signed(t), hounsfield(4000.0 * t - 1500.0)] {
                assert!(color.iter().all(|c| (0.0..=1.0).contains(c)), "{color:?}");
            }
        }
        for i in 0..30 {
            let (a, b) = (label_color(i), label_color(i + 1));
            let apart: f64 = (0..3).map(|k| (a[k] - b[k]).abs()).sum();
            assert!(apart > 0.3, "{i}: {a:?} {b:?}");
        }
        assert_eq!(tissue(2.0), [1.0; 3]);
    }
}
