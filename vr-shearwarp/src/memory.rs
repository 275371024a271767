//! Memory of the encoded volume.

use vr_core::{Control, RenderError, Scene};

use crate::prepared::PreparedShearWarp;
use crate::shear_warp::ShearWarp;

/// The memory of a scene's volume as it is encoded for some axes, in bytes. Samples themselves are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncodedSize {
    /// Voxels that are stored, for each axis anew.
    pub stored: usize,
    /// Codes of voxels, and of their normals.
    pub voxels: usize,
    /// Runs, and where those of each row begin.
    pub runs: usize,
    /// The octree of ranges, which all axes share.
    pub octree: usize,
}

impl EncodedSize {
    /// Everything.
    pub fn total(&self) -> usize {
        self.voxels + self.runs + self.octree
    }

    /// Bytes to a stored voxel.
    pub fn per_voxel(&self) -> f64 {
        (self.voxels + self.runs) as f64 / self.stored.max(1) as f64
    }
}

impl ShearWarp {
    /// Encodes a scene for some principal axes (0, 1 and 2 for x, y and z), and says what that takes.
    ///
    /// # Errors
    /// Same as for [`vr_core::Renderer::prepare`].
    pub fn encoded_size(&self, scene: &Scene, axes: &[usize], control: &Control) -> Result<EncodedSize, RenderError> {
        let mut prepared = PreparedShearWarp::new(self.clone(), scene, control)?;
        for &axis in axes {
            prepared.encode(axis % 3, control)?;
        }
        Ok(prepared.encoded_size())
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{Calibration, ControlPoint, OpacityRule, Placement, TransferFunction, UniformGrid};

    use super::*;
    use crate::shear_warp::EmptySpace;

    #[test]
    fn only_what_can_be_seen_is_stored() {
        let dims = [33, 20, 17];
        let n = dims.iter().product();
        let ball = |i: usize| {
            let p = [i % 33, i / 33 % 20, i / (33 * 20)];
            let r: f64 = (0..3).map(|a| (p[a] as f64 - 8.0).powi(2)).sum();
            if r < 16.0 { 200u8 } else { 0 }
        };
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid =
            UniformGrid::new(dims, (0..n).map(ball).collect::<Vec<_>>(), placement, Calibration::default()).unwrap();
        let points = vec![ControlPoint::new(10.0, [1.0; 3], 0.0), ControlPoint::new(255.0, [1.0; 3], 0.9)];
        let scene = Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
        let control = Control::default();
        let size = |renderer: &ShearWarp, axes: &[usize]| renderer.encoded_size(&scene, axes, &control).unwrap();
        let classic = ShearWarp::classic();
        let (one, three) = (size(&classic, &[2]), size(&classic, &[0, 1, 2]));
        assert!(one.stored > 200 && one.stored < n / 5, "{one:?}");
        // A ball looks the same from everywhere.
        assert_eq!(three.stored, 3 * one.stored);
        assert!(one.per_voxel() > 1.0 && one.total() < three.total());
        // The volume as it lies serves two axes; the third has rows along y.
        let octree = ShearWarp { empty_space: EmptySpace::Octree, ..classic };
        assert_eq!((size(&octree, &[1, 2]).stored, size(&octree, &[0, 1, 2]).stored), (n, 2 * n));
        assert_eq!(size(&octree, &[]), EncodedSize { octree: size(&octree, &[]).octree, ..EncodedSize::default() });
    }
}
