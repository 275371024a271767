//! Interpolation of values at scattered pixels for every pixel.

use crate::metrics::subgrid;

/// Reach of a value, in parts. The pixel of a part itself is nowhere farther than √2, so that every pixel has a value.
const REACH: f64 = 1.5;

/// Spreads values at the pixels of [`subgrid`]`(n, size)` to every pixel.
///
/// A pixel gets the mean of the values within 1.5 parts of it, weighted by ((R − d)/(R d))² where R is that reach and d the distance in parts
/// (Franke and Nielson, "Smooth interpolation of large sets of scattered data", 1980). So the given values stay what they are, and
/// no other leaves the range of its neighbours.
///
/// # Panics
/// Panics if there is not one value for each pixel of the subgrid.
pub fn spread<const N: usize>(n: u32, size: [u32; 2], values: &[[f64; N]]) -> Vec<[f64; N]> {
    let sites = subgrid(n, size);
    assert_eq!(sites.len(), values.len(), "a value for each pixel of the subgrid");
    let parts = size.map(|side| n.min(side));
    let parts_per_pixel = [0, 1].map(|a| f64::from(parts[a]) / f64::from(size[a]));
    let mut spread = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for y in 0..size[1] {
        for x in 0..size[0] {
            let pixel = [x, y];
            let near = [0, 1].map(|a| {
                // Parts begin at rounded pixels: one more on either side is enough for that.
                let part = f64::from(pixel[a]) * parts_per_pixel[a];
                let first = (part - REACH - 1.0).max(0.0) as u32;
                first..parts[a].min((part + REACH + 2.0) as u32)
            });
            let (mut total, mut sums) = (0.0, [0.0; N]);
            let [columns, rows] = near;
            let candidates = rows.flat_map(|row| columns.clone().map(move |column| row * parts[0] + column));
            for site in candidates.map(|k| k as usize) {
                if sites[site] == pixel {
                    (total, sums) = (1.0, values[site]);
                    break;
                }
                let [dx, dy] = [0, 1].map(|a| (f64::from(sites[site][a]) - f64::from(pixel[a])) * parts_per_pixel[a]);
                let distance = dx.hypot(dy);
                if distance < REACH {
                    let weight = ((REACH - distance) / (REACH * distance)).powi(2);
                    total += weight;
                    for (sum, value) in sums.iter_mut().zip(values[site]) {
                        *sum += weight * value;
                    }
                }
            }
            spread.push(sums.map(|sum| sum / total));
        }
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn given_values_stay_and_others_lie_between_them() {
        for (n, size) in [(64, [512, 512]), (8, [100, 37]), (5, [3, 40]), (64, [20, 10]), (2, [9, 9]), (64, [65, 127])]
        {
            let sites = subgrid(n, size);
            let values: Vec<[f64; 2]> = (0..sites.len()).map(|k| [(k as f64).sin(), 7.0]).collect();
            let spread = spread(n, size, &values);
            for (&[x, y], value) in sites.iter().zip(&values) {
                assert_eq!(&spread[(y * size[0] + x) as usize], value);
            }
            for [wave, constant] in spread {
                assert!((-1.0..=1.0).contains(&wave) && (constant - 7.0).abs() < 1e-9, "{wave} {constant}");
            }
        }
    }

    #[test]
    fn a_ramp_stays_a_ramp_nearly() {
        let size = [256, 256];
        let values: Vec<[f64; 1]> = subgrid(32, size).into_iter().map(|[x, _]| [f64::from(x)]).collect();
        for (i, [value]) in spread(32, size, &values).into_iter().enumerate() {
            // A part is eight pixels wide.
            assert!((value - (i % 256) as f64).abs() < 8.0, "{value} at {}", i % 256);
        }
    }
}
