//! The lattice of samples of a resampling.

use glam::DVec3;

/// Samples at products of three lists of coordinates, ascending: `parts` along each axis for every voxel, and the voxels from one corner of a
/// box to the other.
#[derive(Clone, Debug)]
pub(super) struct SampleLattice {
    /// Coordinates along each axis.
    pub places: [Vec<f64>; 3],
}

impl SampleLattice {
    /// The samples of so many voxels over a box, from its first to its last corner, each divided into `parts` along each axis.
    pub fn new((low, high): (DVec3, DVec3), dims: [usize; 3], parts: usize) -> Self {
        let places = std::array::from_fn(|a| {
            let (step, extent) = (1.0 / (dims[a] - 1) as f64, high[a] - low[a]);
            let place = |i: usize| {
                let voxel = (i / parts) as f64 + ((i % parts) as f64 + 0.5) / parts as f64 - 0.5;
                // To the last corner exactly: rounding must not lead beyond a face.
                if voxel == (dims[a] - 1) as f64 { high[a] } else { low[a] + voxel * step * extent }
            };
            (0..dims[a] * parts).map(place).collect()
        });
        Self { places }
    }

    /// Number of samples in a plane across z.
    pub fn plane(&self) -> usize {
        self.places[0].len() * self.places[1].len()
    }
}
