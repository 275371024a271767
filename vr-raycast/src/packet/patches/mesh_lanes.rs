//! Lanes in an adaptive mesh that are looked at one by one: their gradients, and values at the rim of a level.

use vr_core::Field;
use vr_core::amr::AmrLattice;
use vr_kernels::vector::{LANES, Lanes, Stencils};

use super::lanes::LaneSteps;
use super::mesh::{MeshLanes, MeshPatches, gradient_length};
use super::mesh_lattices::stencil;
use super::mesh_rim::MeshRim;

impl<'a> MeshPatches<'a> {
    /// Sets the values of lanes beside samples that their levels do not have; NaN in vacuum.
    #[inline(never)]
    pub(super) fn complete_at_rim(
        &self,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: &[f32; LANES],
        (low, fraction): (&[[i32; LANES]; 3], &[[f32; LANES]; 3]),
        lanes: u32,
        value: &mut Lanes,
    ) {
        let rim = MeshRim { grid: self.grid, samples: self.samples, lattices: self.lattices };
        let border = AmrLattice::border(self.grid.centring()) as i32;
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let low = [low[0][lane] - border, low[1][lane] - border, low[2][lane] - border];
            let fraction = [fraction[0][lane], fraction[1][lane], fraction[2][lane]];
            let block = within.number[lane];
            let near = (border == 1).then(|| rim.value(block, low, fraction)).flatten();
            value.0[lane] = near.unwrap_or_else(|| {
                let at = steps.world_at(lane, number[lane]);
                let fraction = (at - self.blocks[block].place.origin) * self.blocks[block].place.rate - low_of(low);
                let value = self.samples.value_at_rim(block, low, fraction).or_else(|| self.grid.value(at));
                value.map_or(f32::NAN, |value| value as f32)
            });
        }
    }

    /// Stages what gradients of lanes are made of; returns the lanes at the rim of a level, of which that does not hold.
    #[inline(never)]
    pub(super) fn gather_stencils(
        &self,
        within: &MeshLanes<'a>,
        low: &[[i32; LANES]; 3],
        lanes: u32,
        stencils: &mut Stencils,
    ) -> u32 {
        let border = AmrLattice::border(self.grid.centring()) as i32;
        let mut rims = 0;
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let low = [low[0][lane], low[1][lane], low[2][lane]];
            let out = stencils.of_lane(lane);
            let [first, last] = within.inner[lane];
            let is_inner = (0..3).all(|a| first[a] <= low[a] && low[a] <= last[a]) && {
                let [row, layer] = [within.strides[0][lane], within.strides[1][lane]];
                let begin = (low[2] * layer + low[1] * row + low[0]) as usize;
                let (row, layer) = (row as usize, layer as usize);
                // A sum of finite numbers and one that is not is none.
                let sum = within.values[lane].get(begin..begin + layer + row + 2).map_or(f32::NAN, |values| {
                    let pair = |at: usize| values[at] * 0.0 + values[at + 1] * 0.0;
                    pair(0) + pair(row) + pair(layer) + pair(layer + row)
                });
                sum == 0.0
            };
            let differences = within.differences[lane].filter(|_| is_inner);
            if differences.is_some_and(|d| stencil(d, low, out) && out.iter().all(|sample| !sample.is_nan())) {
                continue;
            }
            if !self.samples.stencil(within.number[lane], low.map(|i| i - border), out) {
                rims |= 1 << lane;
            }
        }
        rims
    }

    /// Fills the gradients of lanes beside samples that their levels do not have.
    #[inline(never)]
    pub(super) fn rim_gradients(
        &self,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: &[f32; LANES],
        (low, fraction): (&[[i32; LANES]; 3], &[[f32; LANES]; 3]),
        lanes: u32,
        gradient: &mut [Lanes; 3],
    ) {
        let rim = MeshRim { grid: self.grid, samples: self.samples, lattices: self.lattices };
        let border = AmrLattice::border(self.grid.centring()) as i32;
        let unit = gradient_length(self.grid);
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let low = [low[0][lane] - border, low[1][lane] - border, low[2][lane] - border];
            let fraction = [fraction[0][lane], fraction[1][lane], fraction[2][lane]];
            let near = (border == 1).then(|| rim.gradient(within.number[lane], low, fraction, unit)).flatten();
            let found = near.unwrap_or_else(|| {
                let found = self.grid.gradient(steps.world_at(lane, number[lane])).unwrap_or_default() * unit;
                found.as_vec3().to_array()
            });
            for a in 0..3 {
                gradient[a].0[lane] = found[a];
            }
        }
    }
}

fn low_of(low: [i32; 3]) -> glam::DVec3 {
    glam::DVec3::from_array(low.map(f64::from))
}
