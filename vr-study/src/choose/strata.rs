//! Stratified sample of a picture's pixels, in which those that may be wrong are not rare.
//!
//! The mean of squared errors over a picture may be made by few pixels: single bright voxels that a coarse setting misses, silhouettes of thin
//! shells. An even sample of some thousand pixels may hold none of them. Here pixels are ranked by two pictures, without the reference: by the
//! distance of the picture from a finer one, and by the distance of neighbouring pixels from each other. The foremost 1/1024 of them, up to 1/128,
//! 1/16, 1/4, and the rest are strata, of each of which as many pixels are solved.

use vr_core::parallel::collect;
use vr_core::{Control, Frame, Model, RenderError, Scene, View};
use vr_physics::metrics::subgrid;

use super::CONFIDENCE;
use super::rmse::{RmseEstimate, mean_and_variance, squares};
use crate::reference::{ReferenceCache, SUBGRID};

/// Ends of the strata, as shares of all pixels, the most suspicious first.
const ENDS: [f64; 5] = [1.0 / 1024.0, 1.0 / 128.0, 1.0 / 16.0, 0.25, 1.0];
/// Number of strata.
pub(super) const STRATA: usize = ENDS.len();
/// Number of pixels of each stratum that are solved, beside those of the even subgrid.
const SAMPLES: usize = 1024;

/// Bounds the RMSE of a frame by reference pixels of strata that a finer frame of the same view suggests.
///
/// In each stratum the mean of squares is bounded by the empirical Bernstein bound (Maurer & Pontil 2009, "Empirical Bernstein bounds and sample
/// variance penalization", theorem 4; it holds for draws without replacement, too: Bardenet & Maillard 2015), all of them together with
/// [`CONFIDENCE`]. Its range of squares is the largest that was met in any stratum: pixels further off than all that were pointed at are taken
/// not to exist, which is an assumption, and the only one.
///
/// # Errors
/// A view that makes no sense, or cancellation.
pub(super) fn bound(
    frame: &Frame,
    finer: &Frame,
    (scene, view): (&Scene, &View),
    cache: &ReferenceCache,
    control: &Control,
) -> Result<RmseEstimate, RenderError> {
    let width = frame.size()[0] as usize;
    let stratum_of = strata(&suspicion(frame, Some(finer)));
    let even = subgrid(SUBGRID, view.size).into_iter().map(|[x, y]| y as usize * width + x as usize);
    let chosen = sample(&stratum_of, even, SAMPLES);
    let places = chosen.iter().map(|&i| [(i % width) as u32, (i / width) as u32]).collect();
    let reference = cache.solve((scene, view), &Model::Canonical, places, control)?;

    let squares = squares(&reference, frame);
    let range = squares.iter().copied().fold(0.0, f64::max);
    let (mut mean, mut upper) = (0.0, 0.0);
    for (size, own) in by_stratum(&stratum_of, &chosen, &squares) {
        let share = size as f64 / stratum_of.len() as f64;
        let [m, u] = bernstein(&own, size, range, (1.0 - CONFIDENCE) / STRATA as f64);
        mean += share * m;
        upper += share * u;
    }
    let proven = chosen.len() == stratum_of.len();
    Ok(RmseEstimate { proven, ..RmseEstimate::of_reference([mean, upper], &reference) })
}

/// Returns the number of pixels of each stratum, and the numbers of those of its pixels that were chosen.
pub(super) fn by_stratum(stratum_of: &[u8], chosen: &[usize], numbers: &[f64]) -> [(usize, Vec<f64>); STRATA] {
    let mut strata = std::array::from_fn(|_| (0, Vec::new()));
    stratum_of.iter().for_each(|&stratum| strata[usize::from(stratum)].0 += 1);
    for (&i, &number) in chosen.iter().zip(numbers) {
        strata[usize::from(stratum_of[i])].1.push(number);
    }
    strata
}

/// Returns the mean of a sample of `size` numbers in [0, `range`], and a bound that the mean of all of them exceeds with the probability `delta` at most.
fn bernstein(sample: &[f64], size: usize, range: f64, delta: f64) -> [f64; 2] {
    if sample.is_empty() {
        return if size == 0 { [0.0; 2] } else { [range; 2] };
    }
    let n = sample.len() as f64;
    let [mean, variance] = mean_and_variance(sample);
    if sample.len() == size {
        return [mean; 2];
    }
    if sample.len() == 1 {
        return [mean, range];
    }
    let log = libm::log(2.0 / delta);
    let upper = mean + (2.0 * variance * log / n).sqrt() + 7.0 * range * log / (3.0 * (n - 1.0));
    [mean, upper.min(range)]
}

/// Returns the suspicion of each pixel: its distance from a finer picture, if there is one, and the largest distance of the pixels beside, above and below from it, in either.
pub(super) fn suspicion(frame: &Frame, finer: Option<&Frame>) -> Vec<f32> {
    let [w, h] = frame.size().map(|side| side as usize);
    let apart = |a: &[f32; 4], b: &[f32; 4]| {
        // NaN is as far as can be: a maximum would pass it over.
        (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, |m: f32, d| if d.is_nan() { f32::INFINITY } else { m.max(d) })
    };
    let contrast = |f: &Frame, x: usize, y: usize| {
        let at = |x: usize, y: usize| &f.pixels()[y * w + x];
        let beside = [at(x.saturating_sub(1), y), at((x + 1).min(w - 1), y)];
        let across = [at(x, y.saturating_sub(1)), at(x, (y + 1).min(h - 1))];
        beside.into_iter().chain(across).map(|other| apart(at(x, y), other)).fold(0.0, f32::max)
    };
    let score = |i: usize| {
        let (x, y) = (i % w, i / w);
        let own = contrast(frame, x, y);
        let Some(finer) = finer else { return own };
        // An error is seen in the difference itself; beside a contrast there is only room for one.
        let difference = apart(&frame.pixels()[i], &finer.pixels()[i]);
        difference.max(0.1 * own.max(contrast(finer, x, y)))
    };
    collect(w * h, score)
}

/// Returns so many pixels, the most suspicious ones; in ascending order.
pub(super) fn foremost(suspicion: &[f32], count: usize) -> Vec<usize> {
    let mut ranked: Vec<usize> = (0..suspicion.len()).collect();
    if count < ranked.len() {
        ranked.select_nth_unstable_by(count, |&a, &b| suspicion[b].total_cmp(&suspicion[a]).then(a.cmp(&b)));
        ranked.truncate(count);
        ranked.sort_unstable();
    }
    ranked
}

/// Returns the stratum of each pixel, by its rank.
pub(super) fn strata(suspicion: &[f32]) -> Vec<u8> {
    let count = suspicion.len();
    let mut ranked: Vec<usize> = (0..count).collect();
    let mut stratum_of = vec![0; count];
    // The rearmost first: each end parts only what is left before it.
    let mut end = count;
    for stratum in (1..STRATA).rev() {
        let begin = ((ENDS[stratum - 1] * count as f64) as usize).min(end);
        if begin < end {
            ranked[..end].select_nth_unstable_by(begin, |&a, &b| suspicion[b].total_cmp(&suspicion[a]).then(a.cmp(&b)));
            ranked[begin..end].iter().for_each(|&i| stratum_of[i] = stratum as u8);
        }
        end = begin;
    }
    stratum_of
}

/// Returns up to so many pixels of each stratum at random, and those of an even grid; in ascending order, each once.
pub(super) fn sample(stratum_of: &[u8], even: impl Iterator<Item = usize>, samples: usize) -> Vec<usize> {
    let mut chosen: Vec<usize> = even.collect();
    for h in 0..STRATA as u8 {
        // The same in every run: a picture's bound must not depend on the day.
        let mut own: Vec<(u64, usize)> =
            (0..stratum_of.len()).filter(|&i| stratum_of[i] == h).map(|i| (scrambled(i as u64), i)).collect();
        if samples < own.len() {
            own.select_nth_unstable(samples);
        }
        chosen.extend(own.into_iter().take(samples).map(|(_, i)| i));
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Returns the next pseudorandom number of SplitMix64 (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators").
fn scrambled(i: u64) -> u64 {
    let z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_out_is_looked_at_first() {
        let size = [64, 64];
        let flat = Frame::new(size, vec![[0.5; 4]; 64 * 64], None);
        let mut pixels = vec![[0.5; 4]; 64 * 64];
        pixels[777] = [0.75; 4];
        let star = Frame::new(size, pixels, None);
        // Missed by the picture or by the finer one, or seen by both.
        for (frame, finer) in [(&flat, &star), (&star, &flat), (&star, &star)] {
            let strata = strata(&suspicion(frame, Some(finer)));
            assert!(strata[777] <= 1 && strata.iter().filter(|&&s| s == 0).count() == 4);
            assert!(sample(&strata, std::iter::empty(), SAMPLES).contains(&777));
        }
    }

    #[test]
    fn bounds_hold_for_skewed_numbers() {
        // One in fifty is 1, the others 0: bounded from samples of 200 of 5,000, a bound may fail one time in twenty.
        let all: Vec<f64> = (0..5000).map(|i| if i % 50 == 0 { 1.0 } else { 0.0 }).collect();
        let mut failed = 0;
        for trial in 0..400u64 {
            let mut order: Vec<usize> = (0..all.len()).collect();
            order.sort_by_key(|&i| scrambled(i as u64 ^ (trial << 32)));
            let sample: Vec<f64> = order.iter().take(200).map(|&i| all[i]).collect();
            let [mean, upper] = bernstein(&sample, all.len(), 1.0, 0.05);
            assert!(mean <= upper);
            failed += u32::from(upper < 0.02);
        }
        assert!(failed <= 20, "{failed}");
        assert_eq!(bernstein(&[1.0, 3.0], 2, 9.0, 0.05), [2.0, 2.0]);
        assert_eq!(bernstein(&[], 0, 9.0, 0.05), [0.0, 0.0]);
    }

    /// The bound holds often enough over phantoms and scenes of single bright voxels, and all settings of the ray caster.
    /// `cargo test --release -p vr-study --lib bounds_hold_on -- --ignored --nocapture` prints the table.
    #[test]
    #[ignore = "some minutes"]
    fn bounds_hold_on_many_pictures() {
        let control = Control::default();
        let size = [192, 160];
        let mut subjects = crate::subject::phantom_subjects(32, size).unwrap();
        for (k, stars) in [3usize, 30, 300].into_iter().enumerate() {
            subjects.push(starry(stars, k as u64, size));
        }
        let raycast: Vec<Box<dyn vr_core::StudiedRenderer>> = vec![Box::new(vr_raycast::RayCaster::default())];
        let candidates = crate::candidate::candidates(&raycast).unwrap();
        let (mut all, mut failed) = (0, 0);
        for subject in &subjects {
            let view = (&subject.scene, &subject.view);
            let pixels = subgrid(u32::MAX, size);
            let reference =
                crate::reference::ReferencePixels::solve(view, &Model::Canonical, pixels, &control).unwrap();
            let frames = candidates.iter().filter_map(|c| {
                let drawn =
                    c.configured.prepare(&subject.scene, &control).and_then(|mut p| p.render(&subject.view, &control));
                Some((c.name(), drawn.ok()?.frame))
            });
            let frames: Vec<(String, Frame)> = frames.collect();
            let rmse = |f: &Frame| reference.judge(f).rmse;
            let finest = frames.iter().min_by(|a, b| rmse(&a.1).total_cmp(&rmse(&b.1))).unwrap();
            for (name, frame) in &frames {
                let finer = if *name == finest.0 { frame } else { &finest.1 };
                let estimate = bound(frame, finer, view, &ReferenceCache::none(), &control).unwrap();
                let whole = rmse(frame);
                all += 1;
                failed += u32::from(whole > estimate.upper);
                println!(
                    "{:<16} {name:<32} {whole:.2e} {:.2e} {:.2e} of {}",
                    subject.name, estimate.rmse, estimate.upper, estimate.pixels
                );
            }
        }
        println!("{failed} of {all} bounds failed");
        assert!(all >= 40 && 20 * failed <= all, "{failed} of {all}");
    }

    /// Returns a scene of single bright voxels in the dark.
    fn starry(stars: usize, seed: u64, size: [u32; 2]) -> crate::subject::Subject {
        use vr_core::{Camera, ControlPoint, OpacityRule, Scene, TransferFunction, UniformGrid, View};
        let mut voxels = vec![0u8; 40 * 40 * 40];
        for k in 0..stars as u64 {
            let place = scrambled(k ^ (seed << 20)) as usize % voxels.len();
            voxels[place] = 255;
        }
        let placement = vr_core::Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([40; 3], voxels, placement, vr_core::Calibration::default()).unwrap();
        let points =
            vec![ControlPoint::new(200.0, [1.0, 0.9, 0.6], 0.0), ControlPoint::new(255.0, [1.0, 0.9, 0.6], 0.95)];
        let scene = Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
        let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), size);
        crate::subject::Subject {
            name: format!("{stars} stars"),
            title: String::new(),
            scene,
            view,
            phantom: None,
            origin: Default::default(),
        }
    }
}
