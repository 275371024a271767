//! Walk of a beam through blocks.

use vr_core::IndexRay;

use super::visible_blocks::BlockGrid;

/// Structure over blocks that tells which of them are visible.
pub(crate) trait Regions: Send + Sync {
    /// True if the block at an index is visible.
    fn is_visible(&self, index: usize) -> bool;

    /// Returns a region around the block at an index in which all blocks are visible, or clear, like this one.
    fn around(&self, block: [usize; 3], index: usize) -> Region;
}

/// Region all of whose blocks are visible, or all of whose blocks are clear. It may reach beyond the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Region {
    /// Blocks `low .. high` along each axis.
    Cube { low: [usize; 3], high: [usize; 3] },
    /// All points nearer than this to any point of the block, in block edges, and the block itself.
    Ball(f64),
}

/// Diagonal of a block in its edges: √3, rounded up.
const DIAGONAL: f64 = 1.7321;

/// Ray with a thickness on its way through blocks.
///
/// Everything is mirrored so that the beam flies towards larger coordinates along each axis; coordinates are in block edges. At a distance s
/// the beam covers, along each axis, what lies between its rear, `rear + s·speed`, and its front, which is ahead by twice the reach. So it
/// touches one or two blocks along each axis, and up to eight in all. A front that enters a block, or a rear that leaves one, is an event;
/// there are finitely many, for both move in one direction, and each event moves an index on.
pub(crate) struct Beam {
    grid: BlockGrid,
    flipped: [bool; 3],
    front: [f64; 3],
    rear: [f64; 3],
    speed: [f64; 3],
    /// World distance per block edge along each axis; +∞ where the beam does not move.
    pace: [f64; 3],
    /// World distance per block edge along the ray.
    slowness: f64,
    end: f64,
}

/// Position of a beam: its distance, and the blocks of its rear and its front along each axis (mirrored), which are the same or neighbours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    s: f64,
    rear: [usize; 3],
    front: [usize; 3],
}

/// Returns the first interval behind `from` in which the beam touches a visible block.
pub(crate) fn next_interval<R: Regions>(grid: BlockGrid, regions: &R, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
    let beam = Beam::new(grid, ray);
    let from = from.max(ray.start);
    if from >= ray.end {
        return None;
    }
    let mut place = beam.place(from);
    loop {
        let begin = beam.cross(regions, &mut place, false)?;
        let end = beam.cross(regions, &mut place, true).unwrap_or(ray.end);
        // Rounding may find the beam's rear, at `from`, still in the block that it has just left.
        if end > from {
            return Some((begin, end));
        }
    }
}

impl Beam {
    fn new(grid: BlockGrid, ray: &IndexRay) -> Self {
        let per_cell = 1.0 / grid.edge as f64;
        let (origin, direction) = ((ray.origin * per_cell).to_array(), (ray.direction * per_cell).to_array());
        let flipped = direction.map(|d| d < 0.0);
        let at = |a: usize| if flipped[a] { grid.blocks[a] as f64 - origin[a] } else { origin[a] };
        let speed = direction.map(f64::abs);
        Self {
            grid,
            flipped,
            front: std::array::from_fn(|a| at(a) + grid.reach),
            rear: std::array::from_fn(|a| at(a) - grid.reach),
            speed,
            pace: speed.map(|v| 1.0 / v),
            slowness: 1.0 / (speed[0] * speed[0] + speed[1] * speed[1] + speed[2] * speed[2]).sqrt(),
            end: ray.end,
        }
    }

    /// Returns the position of the beam at a distance.
    fn place(&self, s: f64) -> Place {
        let rear = std::array::from_fn(|a| self.block(a, self.rear[a], s, 0, self.grid.blocks[a]));
        let front = std::array::from_fn(|a| self.block(a, self.front[a], s, rear[a], self.grid.blocks[a]));
        Place { s, rear, front }
    }

    /// Returns the block in which an edge of the beam is, held in `low .. high`.
    #[inline(always)]
    fn block(&self, axis: usize, edge: f64, s: f64, low: usize, high: usize) -> usize {
        // The cast turns negative coordinates into 0.
        ((edge + s * self.speed[axis]) as i32 as usize).max(low).min(high - 1)
    }

    /// Returns the distance at which an edge of the beam reaches the plane before a block that is ahead of it; +∞ if there is no such block or the beam does not
    /// move along the axis (an edge that does not move lies in its block and not on a plane ahead: the product is +∞).
    #[inline(always)]
    fn reaches(&self, axis: usize, edge: f64, plane: usize) -> f64 {
        if plane < self.grid.blocks[axis] { (plane as i32 as f64 - edge) * self.pace[axis] } else { f64::INFINITY }
    }

    /// Returns the block of the grid that a mirrored block is.
    #[inline(always)]
    fn unmirrored(&self, block: [usize; 3]) -> [usize; 3] {
        std::array::from_fn(|a| if self.flipped[a] { self.grid.blocks[a] - 1 - block[a] } else { block[a] })
    }

    /// Goes on for as long as the beam touches something visible (`visible`), or touches nothing visible. Returns the distance at which that ends; `None` if
    /// it does not before the ray does.
    fn cross<R: Regions>(&self, regions: &R, place: &mut Place, visible: bool) -> Option<f64> {
        while place.s < self.end {
            if place.rear == place.front {
                let block = self.unmirrored(place.front);
                let index = self.grid.index(block);
                if regions.is_visible(index) != visible {
                    return Some(place.s);
                }
                self.leave(regions.around(block, index), visible, place);
            } else {
                if self.touches_visible(regions, place) != visible {
                    return Some(place.s);
                }
                self.step(place);
            }
        }
        None
    }

    /// True if any of the two, four or eight blocks that the beam touches can be seen.
    fn touches_visible<R: Regions>(&self, regions: &R, place: &Place) -> bool {
        let Place { rear, front, .. } = place;
        (rear[2]..=front[2]).any(|z| {
            (rear[1]..=front[1])
                .any(|y| (rear[0]..=front[0]).any(|x| regions.is_visible(self.grid.index(self.unmirrored([x, y, z])))))
        })
    }

    /// Goes on to the next event.
    fn step(&self, place: &mut Place) {
        let (mut s, mut axis) = (f64::INFINITY, 0);
        for a in 0..3 {
            let at = if place.rear[a] < place.front[a] {
                self.reaches(a, self.rear[a], place.front[a])
            } else {
                self.reaches(a, self.front[a], place.front[a] + 1)
            };
            if at < s {
                (s, axis) = (at, a);
            }
        }
        place.s = place.s.max(s);
        if s == f64::INFINITY {
            return;
        }
        if place.rear[axis] < place.front[axis] {
            place.rear[axis] = place.front[axis];
        } else {
            place.front[axis] += 1;
        }
    }

    /// Goes on to the point where the front leaves a region that holds all of the beam; or the rear, in search of the end of a `visible` stretch.
    #[inline(always)]
    fn leave(&self, region: Region, visible: bool, place: &mut Place) {
        let here = place.front;
        if let Region::Ball(radius) = region {
            // The beam's corners are √3 of its reach away from the ray.
            let radius = radius - 2.0 * self.grid.reach;
            // A shorter way may not even leave the block.
            if radius > DIAGONAL {
                place.s += radius * self.slowness;
                for a in 0..3 {
                    let n = self.grid.blocks[a];
                    place.rear[a] = self.block(a, self.rear[a], place.s, here[a], n);
                    place.front[a] = self.block(a, self.front[a], place.s, place.rear[a], n);
                }
                return;
            }
        }
        let far: [usize; 3] = match region {
            Region::Cube { low, high } => std::array::from_fn(|a| {
                let n = self.grid.blocks[a];
                if self.flipped[a] { n - low[a].min(n) } else { high[a].min(n) }
            }),
            Region::Ball(_) => here.map(|b| b + 1),
        };
        let at: [f64; 3] = std::array::from_fn(|a| self.reaches(a, self.front[a], far[a]));
        let (mut s, mut axis) = (f64::INFINITY, 0);
        for a in 0..3 {
            if at[a] < s {
                (s, axis) = (at[a], a);
            }
        }
        if s == f64::INFINITY {
            place.s = f64::INFINITY;
            return;
        }
        // From s on, the beam is on both sides of the plane, until its rear follows. As a rule nothing else happens in between, and both events
        // are one.
        let s = place.s.max(s);
        let after = s + 2.0 * self.grid.reach * self.pace[axis];
        let mut alone = true;
        for a in 0..3 {
            if a != axis {
                place.rear[a] = self.block(a, self.rear[a], s, here[a], far[a]);
                place.front[a] = self.block(a, self.front[a], after, place.rear[a], far[a]);
                alone &= place.rear[a] == place.front[a] && at[a] > after;
            }
        }
        place.front[axis] = far[axis];
        if alone {
            place.rear[axis] = far[axis];
            place.s = if visible { after } else { s };
            return;
        }
        place.rear[axis] = far[axis] - 1;
        for a in 0..3 {
            if a != axis {
                place.front[a] = self.block(a, self.front[a], s, place.rear[a], far[a]);
            }
        }
        place.s = s;
    }
}
