//! Random voxels that are hard to draw: noise, constant blocks, thin sheets.

use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{AnyGrid, Calibration, Placement, UniformGrid, Volume};

/// Largest number of voxels along an axis.
const MAX_VOXELS: usize = 8;

/// Look of the values, which are from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// A number of its own for each voxel.
    Noise,
    /// Blocks of a few voxels that have one value of five.
    Blocks,
    /// A sheet one voxel thick, in one direction or another, in next to nothing.
    Sheets,
    /// A wave, with a thousandth of noise.
    Wave,
}

impl Field {
    const ALL: [Self; 4] = [Self::Noise, Self::Blocks, Self::Sheets, Self::Wave];

    /// Value of a voxel, of numbers from 0 to 1 that are noise.
    fn value(self, at: [usize; 3], noise: &[f64]) -> f64 {
        let [x, y, z] = at.map(|i| i as f64);
        let own = noise[at[0] + MAX_VOXELS * (at[1] + MAX_VOXELS * at[2])];
        match self {
            Self::Noise => own,
            Self::Blocks => {
                let [bx, by, bz] = at.map(|i| i / (2 + (3.0 * noise[0]) as usize));
                noise[(7 * bx + 3 * by + 5 * bz) % 5]
            }
            Self::Sheets => {
                let normal = [noise[1], noise[2], noise[3]].map(|n| if n < 0.4 { 0.0 } else { n });
                let place = normal[0] * x + normal[1] * y + normal[2] * z - 6.0 * noise[4];
                if place.abs() < 0.5 { 1.0 } else { 0.05 * own }
            }
            Self::Wave => {
                let phase = 6.3 * noise[0] + noise[1] * x + 1.5 * noise[2] * y + noise[3] * z;
                0.5 + 0.499 * phase.sin() + 1e-3 * (own - 0.5)
            }
        }
        .clamp(0.0, 1.0)
    }
}

/// Grids of 2 to 8 voxels along each axis, as bytes or as floats, with edges from 0.2 to 3, and the look of each.
pub fn volumes() -> impl Strategy<Value = (Field, Volume)> {
    let side = || 2..=MAX_VOXELS;
    let noise = vec(0.0..1.0, MAX_VOXELS * MAX_VOXELS * MAX_VOXELS);
    let edge = || 0.2..3.0;
    (
        prop::sample::select(Field::ALL.to_vec()),
        [side(), side(), side()],
        noise,
        any::<bool>(),
        [edge(), edge(), edge()],
    )
        .prop_map(|(field, dims, noise, bytes, spacing)| {
            let count = dims.iter().product();
            let value = |i: usize| field.value([i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])], &noise);
            let placement = Placement::from_spacing(spacing).expect("edges that are long enough");
            let grid: AnyGrid = if bytes {
                let calibration = Calibration { slope: 1.0 / 255.0, intercept: 0.0 };
                let values: Vec<_> = (0..count).map(|i| (255.0 * value(i)).round() as u8).collect();
                UniformGrid::<u8>::new(dims, values, placement, calibration).expect("two voxels a side").into()
            } else {
                let values: Vec<_> = (0..count).map(|i| value(i) as f32).collect();
                UniformGrid::<f32>::new(dims, values, placement, Calibration::default())
                    .expect("two voxels a side")
                    .into()
            };
            (field, grid.into())
        })
}
