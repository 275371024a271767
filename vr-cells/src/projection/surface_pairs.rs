//! Cells that are seen one behind the other through vacuum: across hollows of a mesh, and between its parts.
//!
//! The faces of the surface are drawn on the screen; behind each place at which a ray leaves the mesh, the next at which it enters tells a pair (the extended
//! order of Silva, Mitchell & Williams 1998, exact for the samples of a picture). Convex meshes have none.

use vr_core::cells::FACES;
use vr_core::{Control, RenderError};

use crate::entries::SurfaceFace;
use crate::tile_lists::TileLists;

use super::line::samples_in;
use super::screen_mesh::ScreenMesh;
use super::tiling::Tiling;
use super::visibility::Pairs;

/// Pairs of cells on the screen.
pub(super) struct SurfacePairs {
    pub(super) pairs: Pairs,
    /// Tiles in which rays enter and leave the mesh a different number of times: faces behind the eye are missing.
    pub(super) unsure: Vec<bool>,
}

/// Function of a face, true if rays leave by it, a sample in it, and the shares of its corners there.
type Visit<'a> = &'a mut dyn FnMut(&SurfaceFace, bool, u32, [f64; 3]);

/// A place at which a ray enters or leaves the mesh.
#[derive(Clone, Copy)]
struct Passage {
    sample: u32,
    leaves: bool,
    /// Grows with the distance.
    depth: f64,
    cell: u32,
}

impl SurfacePairs {
    /// The pairs of a mesh with this surface.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(super) fn new(
        mesh: &ScreenMesh<'_>,
        faces: &[SurfaceFace],
        tiling: &Tiling,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let corners = |face: &SurfaceFace| {
            let cell = mesh.mesh.cells()[face.cell as usize];
            FACES[usize::from(face.across)].map(|i| mesh.vertices[cell[i] as usize])
        };
        let ranges = faces.iter().enumerate().filter_map(|(i, face)| {
            let at = corners(face).map(|c| c.at);
            let bound = |pick: fn(f64, f64) -> f64| [0, 1].map(|a| pick(at[0][a], pick(at[1][a], at[2][a])));
            let is_whole = at.iter().all(|p| !p[0].is_nan());
            let range = if is_whole { tiling.touched([bound(f64::min), bound(f64::max)]) } else { None };
            Some((i as u32, range?))
        });
        let Some(lists) = TileLists::new(tiling.tiles, ranges, MAX_ENTRIES) else {
            return Ok(Self { pairs: Vec::new(), unsure: vec![true; tiling.count() as usize] });
        };
        let in_tile = |tile: u32| -> (Pairs, bool) {
            let (first, pixels) = tiling.pixels_of(tile);
            let origin = first.map(|p| f64::from(p * tiling.per_pixel));
            let size = pixels.map(|p| p * tiling.per_pixel);
            let side = size[0];
            // Each face, the samples in it, and the shares of its corners there.
            let each = |visit: Visit<'_>| {
                for &number in lists.of(tile as usize) {
                    let face = &faces[number as usize];
                    let facing = mesh.facing(face.cell as usize);
                    let across = usize::from(face.across);
                    if facing.is_front(across) || facing.is_back(across) {
                        let at = corners(face).map(|c| [c.at[0] - origin[0], c.at[1] - origin[1]]);
                        let leaves = facing.is_back(across);
                        samples_in(at, size, &mut |[x, y], shares| visit(face, leaves, y * side + x, shares));
                    }
                }
            };
            let mut counts = vec![[0u32; 2]; (size[0] * size[1]) as usize];
            each(&mut |_, leaves, sample, _| counts[sample as usize][usize::from(leaves)] += 1);
            let is_unsure = counts.iter().any(|c| c[0] != c[1]);
            let mut pairs = Pairs::new();
            if counts.iter().any(|c| c[0] > 1) {
                let mut passages = Vec::new();
                each(&mut |face, leaves, sample, shares| {
                    if counts[sample as usize][0] > 1 {
                        let depths = corners(face).map(|c| if mesh.perspective { -c.depth } else { c.depth });
                        let depth = (0..3).map(|i| shares[i] * depths[i]).sum();
                        passages.push(Passage { sample, leaves, depth, cell: face.cell });
                    }
                });
                passages.sort_unstable_by(|a, b| {
                    (a.sample, a.leaves).cmp(&(b.sample, b.leaves)).then(a.depth.total_cmp(&b.depth))
                });
                for ray in passages.chunk_by(|a, b| a.sample == b.sample) {
                    let (enter, leave) = ray.split_at(ray.partition_point(|p| !p.leaves));
                    for (leave, enter) in leave.iter().zip(enter.iter().skip(1)) {
                        if leave.cell != enter.cell {
                            pairs.push([leave.cell, enter.cell]);
                        }
                    }
                }
                pairs.sort_unstable();
                pairs.dedup();
            }
            (pairs, is_unsure)
        };
        // Without a report of progress, which is that of the tiles to come.
        let found = control.run(|| {
            vr_core::parallel::collect(tiling.count() as usize, |tile| {
                if control.is_cancelled() { Default::default() } else { in_tile(tile as u32) }
            })
        });
        control.check()?;
        let unsure = found.iter().map(|f| f.1).collect();
        let mut pairs: Pairs = found.into_iter().flat_map(|f| f.0).collect();
        pairs.sort_unstable();
        pairs.dedup();
        Ok(Self { pairs, unsure })
    }
}

/// Entries of the lists of faces at most.
const MAX_ENTRIES: usize = 1 << 27;
