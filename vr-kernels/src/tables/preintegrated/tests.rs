//! Tables against integrals by many small steps, and against closed forms.

use super::PreIntegrated;
use super::medium::properties;
use vr_core::Calibration;
use vr_core::transfer::{ControlPoint, OpacityRule, TransferFunction};

type Table = PreIntegrated<f64>;

fn transfer(points: &[(f64, f64)], rule: OpacityRule, emits: bool) -> TransferFunction {
    let point = |&(value, opacity): &(f64, f64)| ControlPoint {
        emission: emits.then_some([0.01 * value, 1.0, 0.0]),
        ..ControlPoint::new(value, [0.2, 0.01 * value, 1.0 - 0.01 * value], opacity)
    };
    TransferFunction::new(points.iter().map(point).collect(), rule, 0.7).unwrap()
}

/// A transfer function of ramps, a jump, and a place where α touches 1.
fn wild(rule: OpacityRule, emits: bool) -> TransferFunction {
    transfer(&[(10.0, 0.0), (35.0, 0.9), (35.0, 0.1), (60.0, 1.0), (70.0, 0.02), (93.0, 0.5)], rule, emits)
}

/// The mean of (q, κ) over the values, by many small steps.
fn mean(t: &TransferFunction, calibration: Calibration, a: f64, b: f64) -> [f64; 4] {
    let n = 40_000;
    let mut sum = [0.0; 4];
    for i in 0..n {
        let value = calibration.value(a + (b - a) * (f64::from(i) + 0.5) / f64::from(n));
        let all = properties(t, t.segment_at(value), value);
        sum = std::array::from_fn(|c| sum[c] + all[c] / f64::from(n));
    }
    sum
}

#[test]
fn means_are_exact_but_for_the_table() {
    for rule in [OpacityRule::Power, OpacityRule::Extinction] {
        for emits in [false, true] {
            for calibration in [Calibration::default(), Calibration { slope: -0.5, intercept: 80.0 }] {
                let t = wild(rule, emits);
                let table = Table::new(&t, calibration, (-200.0, 200.0), 1024);
                assert!(table.is_aligned());
                let stored = |value: f64| calibration.stored(value);
                let pairs = [
                    (5.0, 150.0),
                    (20.0, 21.0),
                    (34.9, 35.1),
                    (59.0, 61.0),
                    (93.5, 200.0),
                    (12.0, 92.0),
                    (69.99, 70.0),
                ];
                for (a, b) in pairs {
                    let (a, b) = (stored(a), stored(b));
                    let (got, want) = (table.mean(a, b), mean(&t, calibration, a, b));
                    let back = table.mean(b, a);
                    for c in 0..4 {
                        // κ is linear in an interval of a tenth of a unit; the logarithm at 60, and the sum that it is held against,
                        // have 10⁻⁴. The bound stands for the square of an interval, times the curvature of κ.
                        let bound = 2e-4 * (1.0 + want[c]);
                        assert!((got[c] - want[c]).abs() <= bound, "{rule:?} {emits} {a} {b}: {got:?} {want:?}");
                        assert!((got[c] - back[c]).abs() <= 1e-9 * (1.0 + want[c]), "either way round");
                    }
                }
            }
        }
    }
}

#[test]
fn values_and_small_differences() {
    let t = wild(OpacityRule::Power, false);
    for entries in [1024, 4096] {
        let table = PreIntegrated::<f32>::new(&t, Calibration::default(), (0.0, 100.0), entries);
        for i in 0..2000 {
            let v = 0.05 * i as f32;
            if (v - 60.0).abs() < 1.0 {
                continue;
            }
            let exact = t.extinction_at(f64::from(v));
            // Straddling the end of an interval, or not: nothing cancels.
            for d in [0.0, 1e-5, 1e-3, 0.1] {
                let got = f64::from(table.mean(v, v + d)[3]);
                let steep = (t.extinction_at(f64::from(v + d)) - exact).abs() + 1e-3;
                let jumps = v <= 35.0 && v + d >= 35.0;
                assert!(jumps || (got - exact).abs() < steep, "{v} {d}: {got} {exact}");
            }
        }
        // At a jump the later point holds.
        assert!((f64::from(table.mean(35.0, 35.0)[3]) - t.extinction_at(35.0)).abs() < 1e-3);
        assert!((f64::from(table.mean(34.99, 34.99)[3]) - t.extinction_at(34.99)).abs() < 1e-2);
    }
}

#[test]
fn clear_values_are_zero_to_the_last_bit() {
    let t = transfer(&[(10.0, 0.0), (20.0, 0.0), (30.0, 0.5), (40.0, 0.0)], OpacityRule::Power, false);
    let table = PreIntegrated::<f32>::new(&t, Calibration::default(), (0.0, 255.0), 1024);
    assert!(!table.shows(-5.0, 19.9) && !table.shows(40.5, 1e6) && table.shows(19.0, 21.0));
    for (a, b) in [(-5.0, 19.9), (15.0, 15.001), (19.0, -1e4), (41.0, 1e5)] {
        assert_eq!(table.segment(a, b, 10.0), [0.0; 4], "{a} {b}");
    }
    assert!(table.segment(0.0, 50.0, 1.0)[3] > 0.0, "a peak between two clear values is not missed");
    assert_eq!(table.segment(f32::NAN, 30.0, 1.0), [0.0; 4]);
    assert_eq!(table.segment3(25.0, f32::NAN, 30.0, 1.0), [0.0; 4]);
}

#[test]
fn constant_fields_and_single_points() {
    let t = transfer(&[(0.0, 0.1), (100.0, 0.9)], OpacityRule::Power, false);
    let table = Table::new(&t, Calibration::default(), (42.0, 42.0), 1024);
    let (got, want) = (table.segment(42.0, 42.0, 1.3), t.step(42.0, 1.3));
    assert!((0..4).all(|c| (got[c] - want[c]).abs() < 1e-15), "{got:?} {want:?}");
    // A jump, and nothing else.
    let t = transfer(&[(50.0, 0.2), (50.0, 0.6)], OpacityRule::Power, false);
    let table = Table::new(&t, Calibration::default(), (0.0, 100.0), 1024);
    let kappa = [0.2, 0.6].map(|a| t.extinction(a));
    assert_eq!(table.mean(49.9, 49.9)[3], kappa[0]);
    assert_eq!(table.mean(50.0, 50.0)[3], kappa[1]);
    assert!((table.mean(40.0, 60.0)[3] - 0.5 * (kappa[0] + kappa[1])).abs() < 1e-8);
    // Its stored number falls as the value rises: the earlier point holds above it, and the later one still on it. So in a field that
    // begins where the points end.
    let falling = Calibration { slope: -2.0, intercept: 10.0 };
    let jump = falling.stored(50.0);
    for last in [50.0, 90.0] {
        let points = [(50.0, 0.2), (50.0, 0.6), (last, 0.6)];
        let t = transfer(&points, OpacityRule::Power, false);
        for range in [(-30.0, 30.0), (-20.5, -19.5), (-20.0, -10.0)] {
            let table = Table::new(&t, falling, range, 1024);
            for above in [1e-9, 1e-3, 0.4, 10.0] {
                assert_eq!(table.mean(jump + above, jump + above)[3], kappa[0], "{range:?} {above}");
            }
            assert!((table.mean(jump, jump)[3] - kappa[1]).abs() < 1e-9, "{range:?}");
        }
    }
    // Where α touches 1, a constant field is opaque, and one that only passes by is not.
    let t = wild(OpacityRule::Power, false);
    let table = Table::new(&t, Calibration::default(), (60.0, 60.0), 1024);
    assert_eq!(table.segment(60.0, 60.0, 1e-6)[3], 1.0);
    for points in [[(10.0, 0.0), (60.0, 1.0), (70.0, 0.0)], [(10.0, 0.0), (60.0, 1.0), (60.0, 1.0)]] {
        let t = transfer(&points, OpacityRule::Power, false);
        for calibration in [Calibration::default(), Calibration { slope: -0.3, intercept: 70.0 }] {
            let table = PreIntegrated::<f32>::new(&t, calibration, (0.0, 255.0), 1024);
            let stored = |value: f64| calibration.stored(value) as f32;
            // Up to 60 and no further: the mean of −ln(1 − α) over a ramp from ½ to 1, which is 1 + ln 2, per 0.7.
            let alpha = -libm::expm1f(-1.693_147 / 0.7);
            assert!((table.segment(stored(35.0), stored(60.0), 1.0)[3] - alpha).abs() < 1e-3, "{calibration:?}");
            assert!((table.segment(stored(60.0), stored(35.0), 1.0)[3] - alpha).abs() < 1e-3, "{calibration:?}");
            // Nor does a parabola get there that its samples do not.
            assert!(table.segment3(stored(20.0), stored(55.0), stored(60.0), 0.01)[3] < 0.1);
        }
    }
}

#[test]
fn the_later_point_holds_on_a_jump_far_from_zero() {
    for slope in [1.0, -1.0, 0.3, -0.3] {
        let calibration = Calibration { slope, intercept: 5.0 };
        for jump in (1..200).map(|i| 171 * i) {
            let at = calibration.value(f64::from(jump));
            // On its own, and at the end of a ramp that is narrow against the number.
            for ramp in [0.0, 0.7 * slope.abs()] {
                let points = [(at - ramp, 0.3), (at, 0.2), (at, 0.6), (at + ramp, 0.6)];
                let points = points.map(|(value, opacity)| ControlPoint::new(value, [1.0; 3], opacity)).to_vec();
                let t = TransferFunction::new(points, OpacityRule::Power, 0.7).unwrap();
                let stored = jump as f32;
                let table = PreIntegrated::<f32>::new(&t, calibration, (stored - 1.0, stored + 1.0), 1024);
                let kappa = f64::from(table.mean(stored, stored)[3]);
                assert!((kappa - t.extinction(0.6)).abs() < 0.1, "{slope} {jump} {ramp}: {kappa}");
            }
        }
    }
}

#[test]
fn walls_end_a_segment_where_they_begin() {
    let p = ControlPoint::new;
    let points = vec![
        p(0.0, [0.0; 3], 0.5),
        p(10.0, [0.0; 3], 0.5),
        p(10.0, [1.0, 0.5, 0.0], 1.0),
        p(20.0, [0.0, 0.5, 1.0], 1.0),
    ];
    let t = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    let table = Table::new(&t, Calibration::default(), (-50.0, 50.0), 1024);
    assert!(table.has_walls());
    let assert_close = |got: [f64; 4], want: [f64; 4]| {
        assert!((0..4).all(|c| (got[c] - want[c]).abs() < 1e-6), "{got:?}, expected {want:?}");
    };
    // One unit of opacity ½ before it; from behind, its colour at that end.
    assert_close(table.segment(5.0, 15.0, 2.0), [0.5, 0.25, 0.0, 1.0]);
    assert_close(table.segment(15.0, 5.0, 2.0), [0.5, 0.5, 0.5, 1.0]);
    assert_close(table.segment(12.5, 12.5, 1e-9), [0.75, 0.5, 0.25, 1.0]);
    assert_close(table.segment(30.0, 40.0, 1e-9), [0.0, 0.5, 1.0, 1.0]);
    assert_close(table.segment(10.0, 10.0, 1e-9), [1.0, 0.5, 0.0, 1.0]);
    // A wall that is met at the very end is not entered.
    assert_close(table.segment(0.0, 9.999_999, 1.0), [0.0, 0.0, 0.0, 0.5]);
    assert_close(table.segment3(9.0, 9.9, 10.8, 1.8), {
        let before = 1.0 - 0.5f64.powf(1.0);
        [1.0 - before, 0.5 * (1.0 - before), 0.0, 1.0]
    });
}

#[test]
fn a_value_that_stays_where_opacity_touches_one_is_a_wall() {
    let point = |value, opacity| ControlPoint::new(value, [0.25, 0.5, 1.0], opacity);
    let t = TransferFunction::new(vec![point(1.0, 0.0), point(2.0, 1.0), point(3.0, 0.0)], OpacityRule::Power, 1.0);
    let table = PreIntegrated::<f32>::new(&t.unwrap(), Calibration::default(), (0.0, 4.0), 64);
    assert!(table.has_walls());
    assert_eq!(table.segment(2.0, 2.0, 1e-9), [0.25, 0.5, 1.0, 1.0]);
    assert_eq!(table.segment3(2.0, 2.0, 2.0, 1e-9), [0.25, 0.5, 1.0, 1.0]);
    // Over the whole tent the mean of −ln(1 − α) is 1.
    assert!((table.segment(1.0, 3.0, 0.1)[3] - 0.095_162_6).abs() < 1e-6);
    let near = 2.0f32.next_up();
    assert!(table.segment(near, near, 1e-3)[3] < 0.02 && table.segment(2.0, near, 1e-3)[3] < 0.02);
}

#[test]
fn light_changes_with_depth() {
    // κ constant, colour from 0 to 1 with the value: ∫ c dα in closed form, 1/τ − e^(−τ)(1 + 1/τ).
    let points = vec![ControlPoint::new(0.0, [0.0; 3], 0.5), ControlPoint::new(1.0, [1.0; 3], 0.5)];
    let t = TransferFunction::new(points, OpacityRule::Extinction, 0.5).unwrap();
    let table = Table::new(&t, Calibration::default(), (0.0, 1.0), 1024);
    for tau in [1e-6, 0.01, 0.1, 1.0, 4.0] {
        let exact = (1.0 - libm::exp(-tau) * (1.0 + tau)) / tau;
        let exact = if tau < 1e-3 { 0.5 * tau } else { exact };
        let got = table.segment(0.0, 1.0, tau)[0];
        // The quotient that stands for the projection is good to 1.5 % of a correction that is at most a quarter.
        assert!((got - exact).abs() <= 4e-3 * tau.min(1.0).powi(3) + 1e-9, "{tau}: {got} {exact}");
    }
}

#[test]
fn a_constant_field_is_nowhere_but_at_its_value() {
    // A ramp that begins just above the value, a hundredth of a stored unit wide, and a slope that turns values around.
    let points = [(-32_929_982.425, 0.0), (-32_929_982.41, 0.05)].map(|(v, a)| ControlPoint::new(v, [1.0; 3], a));
    let ramp = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
    let calibration = Calibration { slope: -1000.0, intercept: 17.3 };
    let table = PreIntegrated::<f32>::new(&ramp, calibration, (32930.0, 32930.0), 64);
    assert_eq!(table.segment(32930.0, 32930.0, 3.0), [0.0; 4]);
}
