//! Shares of samples, and where slices lie.

use vr_core::{Camera, Placement, Projection, View};

use super::*;
use crate::factorization::IndexView;
use crate::passes::{TexelLattice, passes};

const BOX: [DVec3; 2] = [DVec3::ZERO, DVec3::new(9.0, 12.0, 7.0)];

/// Slices of many views of a box, some of them cut by half spaces.
fn all_slices(spacing: f64) -> Vec<Slices> {
    let mut all = Vec::new();
    let middle = DVec3::new(4.5, 6.0, 3.5);
    let half_space = |normal: DVec3, off: f64| HalfSpace { normal, offset: normal.dot(middle) + off };
    let oblique = half_space(DVec3::new(0.3, -0.7, 0.5), -0.4);
    let parallel = half_space(DVec3::new(0.0, 0.0, -2.0), 0.3);
    let cuts = [vec![], vec![oblique], vec![oblique, half_space(-oblique.normal, -2.1)], vec![parallel]];
    for projection in [Projection::Orthographic { height: 20.0 }, Projection::Perspective { fov: 50.0 }] {
        for d in [DVec3::new(0.3, 0.4, 1.0), DVec3::new(1.0, 0.1, -0.7), DVec3::new(0.0, -1.0, 0.0)] {
            for distance in [30.0, 2.0] {
                let eye = middle + d.normalize() * distance;
                let camera = Camera { eye, target: middle, up: DVec3::new(0.9, 0.1, 0.5), projection };
                let view = View::new(camera, [40, 40]);
                let index = IndexView::new(&view, &Placement::from_spacing([1.0; 3]).unwrap()).unwrap();
                for planes in &cuts {
                    let region = Region { low: BOX[0], high: BOX[1], planes: planes.clone() };
                    for pass in passes(&index, BOX, BOX[1], TexelLattice { texel: 1.0, nearest: false }).unwrap() {
                        let layers = BOX[1][pass.factorization.axes[2]] as usize + 1;
                        for off_layers in [false, true] {
                            let sampling = Sampling { nearest: false, off_layers };
                            all.push(Slices::new(pass.factorization, &region, layers, spacing, sampling));
                        }
                    }
                }
            }
        }
    }
    all
}

#[test]
fn shares_add_up_to_the_chord() {
    for spacing in [1.0, 0.5, 0.3, 0.7] {
        for slices in all_slices(spacing) {
            let [w, h] = slices.factorization.size;
            let (mut front, mut back) = (Vec::new(), Vec::new());
            for y in 0..h {
                let rows: Vec<Row> = (0..slices.slices.len()).map(|i| slices.row(i, y)).collect();
                slices.chords(y, w, &mut front, &mut back);
                for x in 0..w {
                    let chord = slices.chord(x as f64, y as f64);
                    // A ray that misses has any ends, the first above the last.
                    let ends = [(front[x], chord[0]), (back[x], chord[1])];
                    let same = ends.iter().all(|(a, b)| (a - b).abs() < 1e-6);
                    assert!(same || (chord[0] >= chord[1] && front[x] >= back[x]), "{ends:?}");
                    let hits: Vec<_> = slices
                        .slices
                        .iter()
                        .zip(&rows)
                        .filter(|(_, row)| (row.valid[0]..row.valid[1]).contains(&x))
                        .collect();
                    if hits.is_empty() {
                        // A corner between two slices.
                        assert!(chord[1] - chord[0] <= slices.spacing + 1e-6, "{chord:?}");
                        continue;
                    }
                    let sum: f64 = hits.iter().map(|(s, _)| slices.share(s.depth, chord) * slices.spacing).sum();
                    assert!((sum - (chord[1] - chord[0])).abs() < 1e-5, "{sum} of {chord:?}");
                    for (s, row) in hits {
                        let whole = (row.whole[0]..row.whole[1]).contains(&x);
                        assert!(!whole || (slices.share(s.depth, chord) - 1.0).abs() < 1e-9);
                    }
                }
            }
        }
    }
}

#[test]
fn layers_and_fractions_are_where_the_slice_is() {
    for spacing in [1.0, 0.25, 0.6] {
        for slices in all_slices(spacing) {
            let layers = BOX[1][slices.factorization.axes[2]] as usize + 1;
            for s in &slices.slices {
                let w = s.depth * slices.factorization.sign;
                assert!((s.layer as f64 + f64::from(s.fraction) - w).abs() < 1e-6);
                assert!(s.layer + usize::from(spacing < 1.0) < layers);
            }
            assert!(slices.slices.windows(2).all(|p| p[0].depth < p[1].depth));
        }
    }
}
