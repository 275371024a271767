//! Silhouette: the parts of a picture in which something visible can show, and its smallest depth there.

use glam::DVec3;
use vr_core::{ParameterError, Placement, View};

use crate::leap::VisibleBlocks;
use crate::near_depths::NearDepths;
use crate::projection::{Footprint, MARGIN, Projection};

/// Outermost visible blocks of a volume: a ray from outside to any visible block meets one of these first.
///
/// That is the idea of projecting a convex hull of what is visible to find where rays begin and end (Avila, Sobierajski & Kaufman 1992,
/// "Towards a comprehensive volume visualization system", polygon assisted ray casting), with blocks in the place of its polygons.
#[derive(Clone, Debug)]
pub(crate) struct Hull {
    /// Cells along the edge of a block.
    edge: usize,
    blocks: Vec<[u16; 3]>,
    /// The largest index of the volume.
    extent: [f64; 3],
}

/// Largest number of blocks that are projected for a view; more are joined to larger ones.
const MOST: usize = 8192;

impl Hull {
    /// Returns the silhouette of the visible blocks of a volume with the given voxels along x, y, z.
    pub(crate) fn new(dims: [usize; 3], mut visible: VisibleBlocks) -> Self {
        let extent = dims.map(|n| (n - 1) as f64);
        loop {
            let blocks = outermost(&visible);
            if blocks.len() <= MOST {
                return Self { edge: visible.grid().edge, blocks, extent };
            }
            visible = visible.coarser(dims);
        }
    }

    /// Returns the smallest depths, tile by tile, at which a view may show the blocks.
    ///
    /// # Errors
    /// Same as for [`vr_core::Camera::frame`].
    pub(crate) fn near_depths(&self, view: &View, placement: &Placement) -> Result<NearDepths, ParameterError> {
        let projection = Projection::new(view, placement)?;
        // A ray that begins inside may see what none of these blocks stands before; it leaves by one of them all the same.
        let half = 0.5 * DVec3::from_array(self.extent);
        let outside = projection.footprint(&projection.stencil(half + MARGIN), half).is_none_or(|all| all.depth > 0.0);
        let edge = self.edge as f64;
        let stencil = projection.stencil(DVec3::splat(0.5 * edge + MARGIN));
        let mut near = NearDepths::nothing(view.size);
        let mut tiles = near.whole();
        for block in &self.blocks {
            let centre = DVec3::from_array(block.map(|b| (f64::from(b) + 0.5) * edge));
            if let Some(seen) = projection.footprint(&stencil, centre) {
                tiles.put(&Footprint { depth: if outside { seen.depth } else { 0.0 }, ..seen });
            }
        }
        Ok(near)
    }
}

/// Returns the visible blocks that touch a clear one or the end of the grid.
fn outermost(visible: &VisibleBlocks) -> Vec<[u16; 3]> {
    let grid = visible.grid();
    let near_clear = visible.inverted().dilated();
    let mut blocks = Vec::new();
    visible.for_each_beyond(&VisibleBlocks::clear(grid), |i| {
        let [nx, ny, _] = grid.blocks;
        let at = [i % nx, i / nx % ny, i / (nx * ny)];
        let at_end = (0..3).any(|a| at[a] == 0 || at[a] + 1 == grid.blocks[a]);
        if at_end || near_clear.at(at) {
            blocks.push(at.map(|b| b as u16));
        }
    });
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use vr_core::image_order::ImageSample;
    use vr_core::{Camera, Rays};

    /// Every point of every visible block is behind the nearest depth of its pixel.
    #[test]
    fn nothing_visible_is_left_out_or_nearer() {
        let dims = [70, 41, 52];
        let axes = DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, 0.7, 0.1), DVec3::new(0.3, 0.0, 1.5));
        let placement = Placement::new(DVec3::new(5.0, -7.0, 3.0), axes).unwrap();
        let seen = |block: [usize; 3]| (block[0] > 5 && block[1] < 3) || block == [0, 4, 6];
        let hull = Hull::new(dims, VisibleBlocks::from_fn(dims, 8, seen));
        let (low, high) = {
            let corner = placement.to_world(DVec3::from_array(dims.map(|n| (n - 1) as f64)));
            (placement.origin().min(corner), placement.origin().max(corner))
        };
        let inside = Camera {
            eye: placement.to_world(DVec3::new(60.0, 12.0, 30.0)),
            ..Camera::framing((low, high), 20.0, 9.0, Some(70.0))
        };
        for camera in [
            Camera::framing((low, high), 33.0, 21.0, None),
            Camera::framing((low, high), 120.0, -40.0, Some(30.0)),
            inside,
        ] {
            let view = View::new(camera, [90, 71]);
            let near = hull.near_depths(&view, &placement).unwrap();
            // What lies beyond the picture is not told of, though its tile may be.
            assert_eq!(near.at_spot(&ImageSample { pixel: 0, x: 90.5, y: 3.5 }), 0.0);
            let rays = Rays::new(&view).unwrap();
            let (mut empty, mut late) = (0, 0);
            for pixel in 0..90 * 71 {
                let spot = ImageSample { pixel, x: (pixel % 90) as f64 + 0.5, y: (pixel / 90) as f64 + 0.5 };
                let ray = rays.at(spot.x, spot.y);
                let nearest = near.at_spot(&spot);
                empty += usize::from(nearest == f64::INFINITY);
                late += usize::from(nearest > 0.0 && nearest < f64::INFINITY);
                let cosine = ray.direction.dot(view.camera.frame().unwrap().z_axis);
                for k in 0..800 {
                    let s = f64::from(k) * 0.25;
                    let index = placement.to_index(ray.origin + ray.direction * s);
                    let within = (0..3).all(|a| index[a] >= 0.0 && index[a] <= (dims[a] - 1) as f64);
                    let block = [0, 1, 2].map(|a| (index[a] / 8.0) as usize);
                    if within && seen(block) {
                        assert!(s * cosine >= nearest, "{pixel}: {} {nearest}", s * cosine);
                    }
                }
            }
            // From inside a block, that block is everywhere, and near.
            assert_eq!(empty > 500, camera != inside, "{empty}");
            assert_eq!(late > 0, camera != inside, "{late}");
        }
    }

    #[test]
    fn many_blocks_are_joined() {
        let dims = [513; 3];
        let hull = Hull::new(dims, VisibleBlocks::from_fn(dims, 8, |_| true));
        assert_eq!((hull.edge, hull.blocks.len()), (16, 32usize.pow(3) - 30usize.pow(3)));
    }
}
