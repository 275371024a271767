//! Three slices through the middle of a volume, and its histogram, as a picture.

use glam::DVec3;
use vr_core::{Frame, GridVolume, Voxel, with_grid};
use vr_look::Histogram;

use crate::canvas::Canvas;
use crate::error_scale::{GAP, INK, PAPER};

/// Pixels along the longest side of a slice.
const SIDE: u32 = 320;
/// Height of the drawn histogram in pixels.
const HISTOGRAM: u32 = 96;
/// Share of the values that is black, and of those that are white.
const CUT: f64 = 0.005;

/// World directions to the right and up in a slice.
type Plane = [DVec3; 2];

/// Axial, coronal and sagittal as radiologists hang them: seen from the feet, from the front and from the patient's left. World axes are RAS.
const OF_PATIENT: [Plane; 3] = [[DVec3::NEG_X, DVec3::Y], [DVec3::NEG_X, DVec3::Z], [DVec3::NEG_Y, DVec3::Z]];
/// Planes xy, xz and yz.
const OF_AXES: [Plane; 3] = [[DVec3::X, DVec3::Y], [DVec3::X, DVec3::Z], [DVec3::Y, DVec3::Z]];

/// Draws the slices of the nearest voxels, grey from `window`'s lower end to its upper one; half a percent of the values at either end, where no
/// window is given, is black or white.
pub fn draw(volume: &GridVolume, is_patient: bool, window: Option<[f64; 2]>, histogram: Option<&Histogram>) -> Frame {
    let (low, high) = volume.bounds();
    let size = high - low;
    let pixel = size.max_element() / f64::from(SIDE);
    let planes = if is_patient { OF_PATIENT } else { OF_AXES };
    let extent = |direction: DVec3| ((size.dot(direction.abs()) / pixel).ceil() as u32).max(1);
    let sizes = planes.map(|[right, up]| [extent(right), extent(up)]);

    // Slices side by side, and the histogram below over the whole width.
    let tallest = sizes.iter().map(|s| s[1]).max().unwrap_or(1);
    let width = sizes.iter().map(|s| s[0] + GAP).sum::<u32>() + GAP;
    let mut canvas = Canvas::new([width, tallest + HISTOGRAM + 3 * GAP], PAPER);
    let [black, white] = window.unwrap_or_else(|| with_grid!(volume.values(), g => percentiles(g.samples(), volume)));
    let mut left = GAP;
    for ([right, up], [w, h]) in planes.into_iter().zip(sizes) {
        let corner = 0.5 * (low + high) - 0.5 * pixel * (f64::from(w) * right - f64::from(h) * up);
        for y in 0..h {
            for x in 0..w {
                let at = corner + pixel * ((f64::from(x) + 0.5) * right - (f64::from(y) + 0.5) * up);
                let grey = nearest(volume, at).map_or(0.0, |v| ((v - black) / (white - black)).clamp(0.0, 1.0));
                let linear = vr_core::transfer::srgb_to_linear(grey) as f32;
                canvas.put([left + x, GAP + y], [linear; 3]);
            }
        }
        left += w + GAP;
    }
    if let Some(histogram) = histogram {
        draw_histogram(&mut canvas, histogram, [GAP, tallest + 2 * GAP], width - 2 * GAP);
    }
    canvas.into_frame()
}

/// Columns as high as the logarithm of their counts.
fn draw_histogram(canvas: &mut Canvas, histogram: &Histogram, [left, top]: [u32; 2], width: u32) {
    let height = |count: u64| (1.0 + count as f64).ln();
    let largest = histogram.counts.iter().copied().map(height).fold(f64::MIN_POSITIVE, f64::max);
    let bins = histogram.counts.len() as u32;
    for x in 0..width {
        let count = histogram.counts[(u64::from(x) * u64::from(bins) / u64::from(width)) as usize];
        let tall = (height(count) / largest * f64::from(HISTOGRAM)).round() as u32;
        canvas.fill([left + x, top + HISTOGRAM - tall], [1, tall], INK);
    }
}

/// Returns the value of the voxel that is nearest to a world position, if there is one.
fn nearest(volume: &GridVolume, at: DVec3) -> Option<f64> {
    let index = (volume.placement().to_index(at) + 0.5).floor();
    let [nx, ny, nz] = volume.dims();
    let end = DVec3::new(nx as f64, ny as f64, nz as f64);
    if !(index.cmpge(DVec3::ZERO).all() && index.cmplt(end).all()) {
        return None;
    }
    let i = (index.z as usize * ny + index.y as usize) * nx + index.x as usize;
    let stored = with_grid!(volume.values(), g => f64::from(g.samples()[i].to_f32()));
    Some(volume.calibration().value(stored)).filter(|v| v.is_finite())
}

/// Returns the values below and above which [`CUT`] of the voxels lie, from some ten thousand of them.
fn percentiles<T: Voxel>(samples: &[T], volume: &GridVolume) -> [f64; 2] {
    let step = (samples.len() >> 16).max(1) | 1;
    let values = samples.iter().step_by(step).filter(|s| !s.is_missing());
    let mut values: Vec<f64> = values.map(|s| volume.calibration().value(f64::from(s.to_f32()))).collect();
    values.sort_unstable_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return [0.0, 1.0] };
    let at = |share: f64| values[(share * last as f64).round() as usize];
    let [low, high] = [at(CUT), at(1.0 - CUT)];
    // Rare values, if nothing else differs.
    let [low, high] = if low < high { [low, high] } else { [values[0], values[last]] };
    if low < high { [low, high] } else { [low - 0.5, low + 0.5] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume};

    fn volume(value: impl Fn(usize, usize, usize) -> u8) -> Volume {
        let mut samples = Vec::new();
        for z in 0..6 {
            for y in 0..8 {
                samples.extend((0..4).map(|x| value(x, y, z)));
            }
        }
        let placement = Placement::from_spacing([2.0, 1.0, 1.0]).unwrap();
        UniformGrid::new([4, 8, 6], samples, placement, Calibration::default()).unwrap().into()
    }

    #[test]
    fn right_and_up_are_those_of_the_planes() {
        // Bright at large x and large z.
        let bright = volume(|x, _, z| if x > 1 && z > 2 { 200 } else { 10 });
        let grid = bright.grid().unwrap();
        let picture = draw(grid, false, Some([0.0, 200.0]), Histogram::of(grid, 8).as_ref());
        let [w, h] = picture.size();
        assert!(w > 3 * GAP && h > HISTOGRAM + 3 * GAP);
        let (low, high) = grid.bounds();
        let [x, y, z] =
            ((high - low) / ((high - low).max_element() / f64::from(SIDE))).to_array().map(|n| n.ceil() as u32);
        // The second slice is xz: upper right is bright, lower left is not.
        let left = 2 * GAP + x;
        assert!(picture.pixel(left + x - 3, GAP + 3)[0] > 0.9);
        assert!(picture.pixel(left + 3, GAP + z - 3)[0] < 0.1);
        // A patient's right is at the left.
        let patient = draw(grid, true, Some([0.0, 200.0]), None);
        assert!(patient.pixel(left + 3, GAP + 3)[0] > 0.9);
        assert!(y > 0);
    }

    #[test]
    fn values_that_do_not_differ_are_grey() {
        let constant = volume(|_, _, _| 7);
        let picture = draw(constant.grid().unwrap(), false, None, None);
        let middle = picture.pixel(GAP + 40, GAP + 40)[0];
        assert!((0.1..0.9).contains(&middle), "{middle}");
    }
}
