//! Each phase function integrates to 1, has the mean cosine that it says, and is sampled as it says.

use glam::DVec3;

use super::PhaseFunction;

fn all() -> Vec<PhaseFunction> {
    let mut all = vec![PhaseFunction::Isotropic, PhaseFunction::Rayleigh];
    for g in [0.0, 1e-9, -1e-9, 1e-4, 0.3, -0.5, 0.75, 0.99, 0.999999, -0.999999] {
        all.push(PhaseFunction::henyey_greenstein(g).unwrap());
    }
    for (g, share) in [([0.9, -0.6], 0.8), ([0.999, 0.0], 0.3), ([0.5, 0.2], 0.0), ([0.5, 0.2], 1.0)] {
        all.push(PhaseFunction::double_henyey_greenstein(g, share).unwrap());
    }
    for points in [
        &[[-1.0, 1.0], [1.0, 1.0]][..],
        &[[-1.0, 0.0], [1.0, 1e300]],
        &[[-1.0, 3.0], [-0.5, 0.0], [0.2, 0.0], [0.9, 1.0], [1.0, 40.0]],
        &[[-1.0, 1e-320], [1.0, 0.0]],
    ] {
        all.push(PhaseFunction::tabulated(points).unwrap());
    }
    all
}

/// Cosines that crowd geometrically at both ends: a sharp peak is as wide as 10⁻¹² there. They are numbers of f64, so that their differences are
/// exact.
fn cosines() -> Vec<f64> {
    const RATIO: f64 = 1.0005;
    let mut distances: Vec<f64> =
        std::iter::successors(Some(1.0), |d| Some(d / RATIO)).take_while(|&d| d > 1e-16).collect();
    distances.push(0.0);
    let mut all: Vec<f64> = distances.iter().flat_map(|d| [1.0 - d, d - 1.0]).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Cumulative distribution at the cosines, by the trapezoidal rule: wrong by the square of the ratio of steps, 10⁻⁷.
fn cumulative(phase: &PhaseFunction, cosines: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = cosines.windows(2).map(|pair| {
        sum += 0.25 * (pair[1] - pair[0]) * (phase.value(pair[0]) + phase.value(pair[1]));
        sum
    });
    std::iter::once(0.0).chain(steps).collect()
}

#[test]
fn they_integrate_to_1_and_have_the_mean_cosine_that_they_say() {
    let cosines = cosines();
    for phase in all() {
        let total = *cumulative(&phase, &cosines).last().unwrap();
        assert!((total - 1.0).abs() < 1e-6, "{phase:?}: {total}");
        let mean: f64 = cosines
            .windows(2)
            .map(|p| 0.25 * (p[1] - p[0]) * (p[0] * phase.value(p[0]) + p[1] * phase.value(p[1])))
            .sum();
        assert!((mean - phase.mean_cosine()).abs() < 1e-6, "{phase:?}: {mean}");
        let max = cosines.iter().map(|&c| phase.value(c)).fold(0.0, f64::max);
        assert!(max <= phase.max_value() * (1.0 + 1e-12), "{phase:?}: {max}");
        assert!(max >= phase.max_value() * (1.0 - 1e-12), "{phase:?}: {max}");
    }
}

/// Numbers uniform in [0, 1), by a congruential generator (Knuth's constants).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn samples_are_distributed_as_p() {
    const BINS: usize = 64;
    const SAMPLES: usize = 100_000;
    let cosines = cosines();
    let mut state = 20;
    for phase in all() {
        let cumulative = cumulative(&phase, &cosines);
        let mut counts = [0u32; BINS];
        for _ in 0..SAMPLES {
            // The direction's own cosine would round away a peak of 10⁻¹².
            let cosine = phase.sample_cosine(uniform(&mut state));
            assert!((-1.0..=1.0).contains(&cosine));
            let i = cosines.partition_point(|&c| c <= cosine).clamp(1, cosines.len() - 1);
            let t = (cosine - cosines[i - 1]) / (cosines[i] - cosines[i - 1]);
            let share = cumulative[i - 1] + t * (cumulative[i] - cumulative[i - 1]);
            counts[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
        }
        let expected = SAMPLES as f64 / BINS as f64;
        let squares: f64 = counts.iter().map(|&n| (f64::from(n) - expected).powi(2) / expected).sum();
        // Mean 63, standard deviation √126 = 11.2: four of them above.
        assert!(squares < 63.0 + 4.0 * 126f64.sqrt(), "{phase:?}: {squares} {counts:?}");
    }
}

#[test]
fn sampled_directions_are_units_around_the_old_one() {
    let mut state = 7;
    for phase in all() {
        for _ in 0..200 {
            let mut number = || uniform(&mut state);
            let old = DVec3::new(number() - 0.5, number() - 0.5, number() - 0.5).normalize();
            let uniforms = [number(), number()];
            let new = phase.sample(old, uniforms);
            assert!((new.length() - 1.0).abs() < 1e-14);
            assert!((new.dot(old) - phase.sample_cosine(uniforms[0])).abs() < 1e-14, "{phase:?}");
            // Reciprocity: the way back, both directions turned round and exchanged.
            assert_eq!(phase.value(new.dot(old)), phase.value((-old).dot(-new)));
        }
    }
}

#[test]
fn the_ends_of_the_uniform_numbers_are_straight_on_and_straight_back() {
    for phase in all() {
        let last = 1.0 - f64::EPSILON / 2.0;
        assert!(
            phase.sample_cosine(0.0) >= phase.sample_cosine(0.5)
                && phase.sample_cosine(0.5) >= phase.sample_cosine(last)
        );
        if !matches!(phase, PhaseFunction::Tabulated(_)) {
            assert!(phase.sample_cosine(0.0) > 1.0 - 1e-15, "{phase:?}");
        }
    }
    // A small g is no case of its own: the slope of the sampled cosine in g is 3/2 (1 − s²) there.
    let small = PhaseFunction::henyey_greenstein(1e-9).unwrap();
    assert!((small.sample_cosine(0.25) - 0.5 - 1.5e-9 * 0.75).abs() < 1e-15);
}

#[test]
fn wrong_numbers_are_refused_by_name() {
    for g in [1.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(PhaseFunction::henyey_greenstein(g).is_err());
        assert!(PhaseFunction::double_henyey_greenstein([0.5, g], 0.5).is_err());
    }
    for share in [-0.1, 1.1, f64::NAN] {
        assert_eq!(
            PhaseFunction::double_henyey_greenstein([0.5, 0.1], share).unwrap_err().field,
            "scattering.phase.share"
        );
    }
    let cases: [(&[[f64; 2]], &str); 10] = [
        (&[], "points"),
        (&[[-1.0, 1.0]], "points"),
        (&[[-1.0, 1.0], [0.9, 1.0]], "points"),
        (&[[-1.0, 0.0], [1.0, 0.0]], "points"),
        (&[[-1.0, 1.0], [1.0, f64::NAN]], "points[1].value"),
        (&[[-1.0, -1.0], [1.0, 1.0]], "points[0].value"),
        (&[[-1.0, 1.0], [1.0, f64::INFINITY]], "points[1].value"),
        (&[[-1.0, 1.0], [0.5, 1.0], [0.5, 2.0], [1.0, 1.0]], "points[2].cosine"),
        (&[[-1.0, 1.0], [0.5, 1.0], [0.4, 2.0], [1.0, 1.0]], "points[2].cosine"),
        (&[[-1.0, 1.0], [f64::NAN, 1.0], [1.0, 1.0]], "points[1].cosine"),
    ];
    for (points, field) in cases {
        let error = PhaseFunction::tabulated(points).unwrap_err();
        assert_eq!(error.field, format!("scattering.phase.{field}"), "{points:?}");
    }
}
