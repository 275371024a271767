//! Lengths of frames on a clock that counts whole steps.

/// Returns how many steps of a clock a frame lasts. Each frame ends at the step nearest to its true end, so that no error adds up.
pub(super) fn ticks(frame: usize, fps: f64, steps_per_second: f64) -> u32 {
    let end = |count: usize| (count as f64 * steps_per_second / fps).round();
    (end(frame + 1) - end(frame)) as u32
}

/// Returns seconds per frame as a fraction of two 16-bit numbers, the nearest of those with a numerator up to 1001, which 24000/1001 frames
/// per second need.
pub(super) fn delay(fps: f64) -> (u16, u16) {
    let candidates = (1..=1001u16).filter_map(|numerator| {
        let denominator = (f64::from(numerator) * fps).round();
        let possible = (1.0..=f64::from(u16::MAX)).contains(&denominator);
        possible.then_some((numerator, denominator as u16, (denominator / f64::from(numerator) - fps).abs()))
    });
    // Of those that are as near, the simplest.
    let best = candidates.reduce(|best, other| if other.2 < best.2 { other } else { best });
    best.map_or((1, 1), |(numerator, denominator, _)| (numerator, denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_error_adds_up() {
        let gif: Vec<u32> = (0..24).map(|i| ticks(i, 24.0, 100.0)).collect();
        assert_eq!((gif.iter().sum::<u32>(), gif.iter().min(), gif.iter().max()), (100, Some(&4), Some(&5)));
        assert_eq!((0..50).map(|i| ticks(i, 50.0, 100.0)).max(), Some(2));
        assert_eq!(ticks(3, 0.5, 1000.0), 2000);
    }

    #[test]
    fn delays_are_the_simplest_fractions() {
        assert_eq!(delay(24.0), (1, 24));
        assert_eq!(delay(0.5), (2, 1));
        assert_eq!(delay(12.5), (2, 25));
        assert_eq!(delay(24000.0 / 1001.0), (1001, 24000));
        assert_eq!(delay(240.0), (1, 240));
    }
}
