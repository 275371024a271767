//! Lists of the points whose supports reach into the cells of a lattice.

use glam::DVec3;
use vr_core::{Placement, PointMixing, PointSet};
use vr_kernels::vector::LANES;

/// Support as seen from a cell that it reaches into.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearPoint {
    /// Position from the lower corner of the cell, in units of the points' mean spacing: so that f32 holds it as exactly as anything near the cell.
    pub(super) offset: [f32; 3],
    /// One over the square of the radius, in these units.
    pub(super) per_square: f32,
    /// Largest contribution, by the kernel's table: w·v/R³.
    pub(super) amplitude: f32,
}

/// Weight of a support in means, and what the point carries into them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// Largest weight, by the kernel's table: w/R³.
    pub(super) weight: f32,
    /// Value of the point.
    pub(super) value: f32,
    /// Colour of the point; white where it has none.
    pub(super) color: [f32; 3],
}

/// Lists of the points whose supports reach into the cells of lattices: of small supports into small cells, and of large ones into larger cells.
///
/// In small cells alone, a set whose outermost supports hold whole regions of them would list those points in each one.
#[derive(Debug)]
pub(super) struct PointCells {
    pub(super) levels: Vec<PointLevel>,
    /// Edges of a cell of the field's lattice in units of the spacing.
    pub(super) edges: [f32; 3],
    /// World length of the unit.
    pub(super) spacing: f64,
}

/// Lists of the points whose supports are about as large as the cells of a lattice.
#[derive(Debug)]
pub(super) struct PointLevel {
    /// Cells of the field's lattice along the edge of one here: 2 to the power of this.
    pub(super) shift: u32,
    /// Cells along x, y, z.
    pub(super) cells: [usize; 3],
    /// Begin of the list of each cell, and the end of the last.
    first: Vec<u32>,
    points: Vec<NearPoint>,
    /// Part of each point in means; empty where a set has none.
    carried: Vec<Carried>,
    /// Offsets of the points, axis by axis, and squares of their radii, in units of the spacing: for looking at sixteen of them at once. So many more at the end;
    /// empty where a set has no means.
    pub(super) supports: [Vec<f32>; 4],
}

/// Shift of the smallest cells, twice as long as those of the field's lattice, whose edges are about half the mean radius: lists of smaller cells hold fewer
/// points that do not reach a place, and each point is in more of them.
const SMALLEST: u32 = 1;
/// Radius of the largest supports in a level, in edges of its cells. Sets whose radii are alike have one level.
const LARGEST_RADIUS: f64 = 2.0;
/// Largest numbers of cells of a level, and of entries of all lists (320 MB, and as much again with what means are made of).
const MAX_CELLS: usize = 1 << 26;
const MAX_ENTRIES: usize = 1 << 24;

impl PointCells {
    /// Lists the points of a set in the cells of lattices over its box, the smallest cells of which are twice as long as those of the field's; `None` if that
    /// takes too much memory, or numbers that f32 does not hold.
    pub(super) fn new(points: &PointSet, placement: &Placement, dims: [usize; 3]) -> Option<Self> {
        let (spacing, edges) = (points.mean_spacing(), placement.spacing());
        let (mut levels, mut entries) = (Vec::new(), 0);
        // Points by their level: the first whose cells are large enough, or the one that is a single cell.
        let longest = dims.into_iter().max().unwrap_or(1);
        let last = SMALLEST.max(longest.next_power_of_two().trailing_zeros());
        let level_of = |radius: f32| {
            let fits = |shift: &u32| {
                let edge = edges.min_element() * f64::from(1u32 << *shift);
                f64::from(radius) <= LARGEST_RADIUS * edge
            };
            (SMALLEST..last).find(fits).unwrap_or(last)
        };
        let mut by_level = vec![Vec::new(); last as usize + 1];
        for (k, &radius) in points.radii().iter().enumerate() {
            by_level[level_of(radius) as usize].push(k);
        }
        for (shift, own) in (0..).zip(&by_level).filter(|(_, own)| !own.is_empty()) {
            let level = PointLevel::new(points, own, (placement, dims), shift, MAX_ENTRIES - entries)?;
            entries += level.points.len();
            levels.push(level);
        }
        Some(Self { levels, edges: (edges / spacing).as_vec3().to_array(), spacing })
    }
}

impl PointLevel {
    /// Lists some points of a set in cells of `1 << shift` cells of a lattice an edge; `None` if that takes more than so many entries, too many cells, or numbers
    /// that f32 does not hold.
    fn new(
        points: &PointSet,
        own: &[usize],
        (placement, dims): (&Placement, [usize; 3]),
        shift: u32,
        max_entries: usize,
    ) -> Option<Self> {
        let cells = dims.map(|n| (n - 1).div_ceil(1 << shift));
        let count = cells.iter().try_fold(1usize, |count, &n| count.checked_mul(n)).filter(|&n| n <= MAX_CELLS)?;
        let (spacing, edge) = (points.mean_spacing(), placement.spacing() * f64::from(1u32 << shift));
        let lattice = (placement.origin(), edge, cells);
        // Numbers of points in each cell first, then their places in one list.
        let mut first = vec![0u32; count + 1];
        let mut entries = 0usize;
        for &k in own {
            if entries > max_entries {
                return None;
            }
            each_cell(points, k, lattice, |cell, _| {
                first[cell + 1] += 1;
                entries += 1;
            });
        }
        if entries > max_entries {
            return None;
        }
        for i in 0..count {
            first[i + 1] += first[i];
        }
        let none = NearPoint { offset: [0.0; 3], per_square: 0.0, amplitude: 0.0 };
        let mut near = vec![none; entries];
        let has_means = points.mixing() == PointMixing::Mean || points.colors().is_some();
        let nothing = Carried { weight: 0.0, value: 0.0, color: [1.0; 3] };
        let mut carried = vec![nothing; if has_means { entries } else { 0 }];
        let mut next = first.clone();
        let mut holds = true;
        for &k in own {
            let radius = f64::from(points.radii()[k]) / spacing;
            let (per_square, amplitude) = ((1.0 / (radius * radius)) as f32, points.amplitude(k) as f32);
            let color = points.colors().map_or([1.0; 3], |colors| colors[k]);
            let own = Carried { weight: points.weight_density(k) as f32, value: points.values()[k], color };
            holds &= per_square.is_normal() && amplitude.is_finite() && (!has_means || own.weight.is_normal());
            each_cell(points, k, lattice, |cell, corner| {
                let offset = ((points.positions()[k] - corner) / spacing).as_vec3().to_array();
                let entry = next[cell] as usize;
                near[entry] = NearPoint { offset, per_square, amplitude };
                if has_means {
                    carried[entry] = own;
                }
                next[cell] += 1;
            });
        }
        let has_jumps = points.mixing() == PointMixing::Mean;
        let column = |of: &dyn Fn(&NearPoint) -> f32| {
            let padded = near.iter().map(of).chain([0.0; LANES]);
            if has_jumps { padded.collect() } else { Vec::new() }
        };
        let supports = [
            column(&|near| near.offset[0]),
            column(&|near| near.offset[1]),
            column(&|near| near.offset[2]),
            column(&|near| 1.0 / near.per_square),
        ];
        holds.then_some(Self { shift, cells, first, points: near, carried, supports })
    }

    /// Returns the numbers of the entries of a cell.
    #[inline(always)]
    pub(super) fn entries(&self, cell: usize) -> std::ops::Range<usize> {
        self.first[cell] as usize..self.first[cell + 1] as usize
    }

    /// Returns the points that reach into a cell.
    #[inline(always)]
    pub(super) fn of(&self, cell: usize) -> &[NearPoint] {
        &self.points[self.entries(cell)]
    }

    /// Returns the parts of these points in means.
    #[inline(always)]
    pub(super) fn carried(&self, cell: usize) -> &[Carried] {
        &self.carried[self.entries(cell)]
    }
}

/// Calls `visit` with each cell, of a lattice with an origin, edges and numbers of cells, that the support of a point reaches into, and the cell's lower corner.
fn each_cell(
    points: &PointSet,
    k: usize,
    (origin, edge, cells): (DVec3, DVec3, [usize; 3]),
    mut visit: impl FnMut(usize, DVec3),
) {
    // A little more, for places that f32 puts into the next cell.
    const MARGIN: f64 = 1e-4;
    let radius = f64::from(points.radii()[k]) + MARGIN * edge.max_element();
    let at = points.positions()[k] - origin;
    let (low, high) = ((at - radius) / edge, (at + radius) / edge);
    // `as` saturates at 0.
    let range = |a: usize| low[a].floor() as usize..=(high[a].floor() as usize).min(cells[a] - 1);
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let corner = edge * DVec3::new(x as f64, y as f64, z as f64);
                let nearest = at.clamp(corner, corner + edge);
                if nearest.distance_squared(at) < radius * radius {
                    visit((z * cells[1] + y) * cells[0] + x, origin + corner);
                }
            }
        }
    }
}
