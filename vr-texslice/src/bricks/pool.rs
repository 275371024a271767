//! Bricks that are resident, within a budget.

use std::collections::VecDeque;
use std::time::Duration;

use vr_core::clock::Instant;
use vr_core::{Control, RenderError};

use super::brick::{Brick, BrickKey, BrickSource};
use crate::region::Region;
use crate::textures::hold;

/// Textures of bricks, the least recently used of which go where there is no room for another.
pub(crate) struct Pool {
    /// Key of what its bricks hold.
    pub(crate) key: BrickKey,
    /// Least recently used first.
    resident: VecDeque<([usize; 3], Brick)>,
    bytes: u64,
    /// Bytes of compressed blocks, which stay beside them.
    blocks: u64,
    limit: u64,
    /// Time that making them took.
    time: Duration,
}

impl Pool {
    /// An empty pool with a budget, of which compressed blocks take so many bytes.
    pub(crate) fn new(key: BrickKey, blocks: u64, limit: u64) -> Self {
        let (resident, time) = (VecDeque::new(), Duration::ZERO);
        Self { key, resident, bytes: 0, blocks, limit, time }
    }

    /// Checks that there is room for the largest brick.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] if the budget does not hold so many bytes.
    pub(crate) fn check(&self, largest: u64) -> Result<(), RenderError> {
        let what = if self.blocks > 0 { "compressed blocks and a brick decoded from them" } else { "a brick" };
        hold(what, self.blocks + largest, self.limit)
    }

    /// The texture of a brick, which is made from its region of the source unless it is here still.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] if the budget does not hold it.
    pub(crate) fn brick(
        &mut self,
        number: [usize; 3],
        source: &BrickSource<'_>,
        region: &Region,
        control: &Control,
    ) -> Result<&Brick, RenderError> {
        let found = self.resident.iter().position(|(of, _)| *of == number);
        let brick = match found.and_then(|at| self.resident.remove(at)) {
            Some((_, brick)) => brick,
            None => {
                let bytes = source.bytes(region);
                self.check(bytes)?;
                self.make_room(bytes);
                let start = Instant::now();
                let brick = control.run(|| source.load(region));
                self.time += start.elapsed();
                self.bytes += brick.bytes();
                brick
            }
        };
        self.resident.push_back((number, brick));
        Ok(&self.resident[self.resident.len() - 1].1)
    }

    /// Lets the least recently used ones go, before another is made in their place: the budget holds at every moment.
    fn make_room(&mut self, bytes: u64) {
        while self.blocks + self.bytes + bytes > self.limit {
            let Some((_, oldest)) = self.resident.pop_front() else { break };
            self.bytes -= oldest.bytes();
        }
    }

    /// Takes the time that bricks took to make since it was taken last; `None` if none was made.
    pub(crate) fn take_time(&mut self) -> Option<Duration> {
        let time = std::mem::take(&mut self.time);
        (time > Duration::ZERO).then_some(time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::*;

    use super::super::BrickLattice;
    use crate::layout::Layout;
    use crate::texture_slicer::Format;

    fn scene() -> Scene {
        let samples: Vec<u16> = (0..9 * 7 * 6).map(|i| i as u16).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([9, 7, 6], samples, placement, Calibration::default()).unwrap();
        let point = ControlPoint::new(0.0, [1.0; 3], 0.5);
        Scene::new(grid.into(), TransferFunction::new(vec![point], OpacityRule::Power, 1.0).unwrap())
    }

    #[test]
    fn bricks_share_a_layer_and_the_least_recently_used_go() {
        let scene = scene();
        let volume = scene.volume.grid().unwrap();
        let key = BrickKey { gradients: None, light: None, levels: None, layout: Layout::VOLUME };
        let source =
            BrickSource { format: Format::Scalar, scene: &scene, volume, compressed: None, palette: None, key };
        let lattice = BrickLattice::new(volume.dims(), 4, Layout::VOLUME);
        assert_eq!(lattice.count(), [2, 2, 2]);
        let largest = source.bytes(&lattice.largest(|cells| source.region(cells)));
        assert_eq!(largest, 5 * 5 * 5 * 2);
        let mut pool = Pool::new(key, 0, 2 * largest);
        let control = Control::default();
        // The third is smaller, and the two largest ones fill the pool.
        for (number, left) in [
            ([0, 0, 0], vec![[0, 0, 0]]),
            ([1, 0, 0], vec![[0, 0, 0], [1, 0, 0]]),
            ([0, 0, 0], vec![[1, 0, 0], [0, 0, 0]]),
            ([1, 1, 1], vec![[0, 0, 0], [1, 1, 1]]),
            ([0, 0, 0], vec![[1, 1, 1], [0, 0, 0]]),
            ([1, 0, 0], vec![[0, 0, 0], [1, 0, 0]]),
        ] {
            let cells = lattice.cells_of(number);
            let region = source.region(&cells);
            let brick = pool.brick(number, &source, &region, &control).unwrap();
            assert_eq!(brick.bytes(), source.bytes(&region));
            let Brick::Values { grid: AnyGrid::U16(grid), filled: None } = brick else { panic!("words") };
            let whole = |[x, y, z]: [usize; 3]| ((z * 7 + y) * 9 + x) as u16;
            let corners = [grid.samples()[0], grid.samples()[region.count() - 1]];
            assert_eq!(corners, [cells.map(|c| c[0]), cells.map(|c| c[1])].map(whole));
            assert_eq!(pool.resident.iter().map(|(of, _)| *of).collect::<Vec<_>>(), left);
        }
        let mut none = Pool::new(key, 0, largest - 1);
        let region = source.region(&lattice.cells_of([0; 3]));
        assert!(matches!(none.check(largest), Err(RenderError::TooLarge { .. })));
        assert!(matches!(none.brick([0; 3], &source, &region, &control), Err(RenderError::TooLarge { .. })));
    }

    #[test]
    fn a_budget_holds_at_every_moment() {
        let scene = scene();
        let volume = scene.volume.grid().unwrap();
        let gradients = Some(GradientMethod::CentralDifferences);
        let key = BrickKey { gradients, light: None, levels: None, layout: Layout::VOLUME };
        let source =
            BrickSource { format: Format::Scalar, scene: &scene, volume, compressed: None, palette: None, key };
        let lattice = BrickLattice::new(volume.dims(), 2, Layout::VOLUME);
        let largest = source.bytes(&lattice.largest(|cells| source.region(cells)));
        let control = Control::default();
        let held = |pool: &Pool| pool.resident.iter().map(|(_, brick)| brick.bytes()).sum::<u64>();
        for limit in largest..4 * largest {
            // Of blocks beside them nothing is left for bricks.
            let mut pool = Pool::new(key, 300, limit + 300);
            let mut last_used: Vec<[usize; 3]> = Vec::new();
            let mut state = limit;
            for _ in 0..50 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let number = std::array::from_fn(|a| (state >> (40 + 8 * a)) as usize % lattice.count()[a]);
                let region = source.region(&lattice.cells_of(number));
                if !last_used.contains(&number) {
                    // Before a brick is made, there is room for it, and no more than that was made.
                    let before: Vec<_> = pool.resident.iter().map(|(_, brick)| brick.bytes()).collect();
                    pool.make_room(source.bytes(&region));
                    assert!(held(&pool) + source.bytes(&region) <= limit, "{limit}");
                    let went = before.len() - pool.resident.len();
                    let one_less: u64 = before[went.saturating_sub(1)..].iter().sum();
                    assert!(went == 0 || one_less + source.bytes(&region) > limit, "{limit}");
                }
                pool.brick(number, &source, &region, &control).unwrap();
                assert!(held(&pool) == pool.bytes && pool.bytes <= limit, "{limit}");
                last_used.retain(|of| *of != number);
                last_used.push(number);
                // What is here is what was used last, in this order.
                let here: Vec<_> = pool.resident.iter().map(|(of, _)| *of).collect();
                assert!(last_used.ends_with(&here), "{limit}: {here:?} of {last_used:?}");
                last_used = here;
            }
        }
    }
}
