//! The volume as it is encoded for one principal axis.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use vr_core::filter::Lattice;
use vr_core::parallel::each_part;
use vr_core::{
    AnyGrid, ColorGrid, GridVolume, LatticeVisitor, RenderError, UniformGrid, Voxel, gradient_at_sample, memory,
};

use crate::codes::Codes;
use crate::encode::{Dense, Layout, Leveled, PAD, Rule, Runs, VisibleBlocks, block_runs, packed};
use crate::reflections::encode;
use crate::shear_warp::EmptySpace;
use crate::steepness::unit;

/// Runs of cells, in layers or between them.
#[derive(Clone, Debug)]
pub(crate) enum Cells {
    InLayers(Runs<2>),
    Between(Runs<4>),
}

impl Cells {
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::InLayers(runs) => runs.bytes(),
            Self::Between(runs) => runs.bytes(),
        }
    }
}

/// Codes of voxels, in one byte or two.
#[derive(Clone, Debug)]
pub(crate) enum Codewords {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
}

impl Codewords {
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Bytes(all) => all.len(),
            Self::Words(all) => all.len() * 2,
        }
    }
}

/// Voxels in some order, with what kernels may read behind the last.
#[derive(Clone, Debug)]
pub(crate) struct Voxels {
    pub(crate) codes: Codewords,
    /// Codes of the normals; none where nothing is shaded.
    pub(crate) normals: Vec<u16>,
    /// World gradients in [`unit()`]s, component by component; none where no sample looks at them.
    pub(crate) gradients: [Vec<f32>; 3],
    /// Colours of their own, channel by channel; none of voxels that have none.
    pub(crate) colors: [Vec<u16>; 3],
}

impl Voxels {
    /// Number of stored voxels.
    pub(crate) fn stored(&self) -> usize {
        match &self.codes {
            Codewords::Bytes(all) => all.len() - PAD,
            Codewords::Words(all) => all.len() - PAD,
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        let gradients: usize = self.gradients.iter().map(|component| component.len() * 4).sum();
        let colors: usize = self.colors.iter().map(|channel| channel.len() * 2).sum();
        self.codes.bytes() + self.normals.len() * 2 + gradients + colors
    }
}

/// The volume for one axis.
#[derive(Clone, Debug)]
pub(crate) struct EncodedAxis {
    pub(crate) cells: Cells,
    pub(crate) voxels: Arc<Voxels>,
}

/// All voxels as they lie: with rows along x, and with rows along y. Made when first asked for, and not again for another transfer function.
#[derive(Default)]
pub(crate) struct WholeVolume([Option<Arc<Voxels>>; 2]);

impl WholeVolume {
    pub(crate) fn all(&self) -> impl Iterator<Item = &Arc<Voxels>> {
        self.0.iter().flatten()
    }
}

/// A volume to encode, and the rules for it.
pub(crate) struct Encoder<'a> {
    pub(crate) volume: &'a GridVolume,
    pub(crate) codes: &'a Codes,
    pub(crate) blocks: &'a VisibleBlocks,
    pub(crate) rule: Rule<'a>,
    /// True if samples lie between layers, too.
    pub(crate) between: bool,
    pub(crate) empty_space: EmptySpace,
    pub(crate) shaded: bool,
    /// True if samples look at the gradients of voxels.
    pub(crate) steep: bool,
    /// Colours of voxels; `None` where they have none.
    pub(crate) colors: Option<&'a ColorGrid>,
}

impl Encoder<'_> {
    /// The volume for the principal axis `w`.
    pub(crate) fn encode(&self, w: usize, whole: &mut WholeVolume) -> Result<EncodedAxis, RenderError> {
        if self.empty_space == EmptySpace::Octree {
            let layout = Layout::new(self.volume.dims(), w);
            let cells = if self.between {
                block_runs::<4>(layout, self.blocks)?.map(Cells::Between)
            } else {
                block_runs::<2>(layout, self.blocks)?.map(Cells::InLayers)
            };
            // Missing samples are for runs that end at them.
            if let Some(cells) = cells {
                let turned = usize::from(w == 0);
                if whole.0[turned].is_none() {
                    let size = if self.volume.voxel_type().bytes() == 1 { 1 } else { 2 };
                    self.check_memory(self.volume.dims().iter().product(), size)?;
                }
                let voxels = whole.0[turned].get_or_insert_with(|| Arc::new(self.all_voxels(turned == 1)));
                return Ok(EncodedAxis { cells, voxels: Arc::clone(voxels) });
            }
        }
        match self.volume.values() {
            AnyGrid::U8(grid) => self.pack(grid, w, |s| s, Codewords::Bytes),
            AnyGrid::I8(grid) => self.pack(grid, w, |s| (s as u8) ^ 0x80, Codewords::Bytes),
            AnyGrid::U16(grid) => self.pack(grid, w, |s| s, Codewords::Words),
            AnyGrid::I16(grid) => self.pack(grid, w, |s| (s as u16) ^ 0x8000, Codewords::Words),
            AnyGrid::F32(grid) => self.pack(grid, w, |s| self.codes.code(s), Codewords::Words),
        }
    }

    fn pack<T: Leveled + Sync, P: Copy + Default + Send>(
        &self,
        grid: &UniformGrid<T>,
        w: usize,
        code: impl Fn(T) -> P + Sync,
        keep: impl Fn(Vec<P>) -> Codewords,
    ) -> Result<EncodedAxis, RenderError> {
        let dense = Dense::visible(grid.samples(), grid.dims(), w, self.blocks);
        let (cells, packing) = if self.between {
            let (runs, packing) = packed::<4, T>(&dense, self.blocks, self.rule)?;
            (Cells::Between(runs), packing)
        } else {
            let (runs, packing) = packed::<2, T>(&dense, self.blocks, self.rule)?;
            (Cells::InLayers(runs), packing)
        };
        self.check_memory(packing.stored(), size_of::<P>())?;
        let codes = keep(packing.pack(&dense, code));
        let normals = self.normals(dense.layout, &|row| packing.fill(row));
        let gradients = self.gradients(dense.layout, &|row| packing.fill(row));
        let colors = self.colors(dense.layout, &|row| packing.fill(row));
        Ok(EncodedAxis { cells, voxels: Arc::new(Voxels { codes, normals, gradients, colors }) })
    }

    /// Refuses a number of voxels, with codes of a size each, for which there is too little memory.
    fn check_memory(&self, voxels: usize, code_bytes: usize) -> Result<(), RenderError> {
        let normal = if self.shaded { size_of::<u16>() } else { 0 };
        let gradient = if self.steep { 3 * size_of::<f32>() } else { 0 };
        let color = if self.colors.is_some() { 3 * size_of::<u16>() } else { 0 };
        Ok(memory::check("the run-length encoded volume", (voxels * (code_bytes + normal + gradient + color)) as u64)?)
    }

    fn all_voxels(&self, turned: bool) -> Voxels {
        let codes = match self.volume.values() {
            AnyGrid::U8(grid) => Codewords::Bytes(lying(grid, turned, |s| s)),
            AnyGrid::I8(grid) => Codewords::Bytes(lying(grid, turned, |s| (s as u8) ^ 0x80)),
            AnyGrid::U16(grid) => Codewords::Words(lying(grid, turned, |s| s)),
            AnyGrid::I16(grid) => Codewords::Words(lying(grid, turned, |s| (s as u16) ^ 0x8000)),
            AnyGrid::F32(grid) => Codewords::Words(lying(grid, turned, |s| self.codes.code(s))),
        };
        let layout = Layout::new(self.volume.dims(), if turned { 0 } else { 2 });
        let normals = self.normals(layout, &|fill| all_rows(layout, fill));
        let gradients = self.gradients(layout, &|fill| all_rows(layout, fill));
        let colors = self.colors(layout, &|fill| all_rows(layout, fill));
        Voxels { codes, normals, gradients, colors }
    }

    /// Colours of voxels in the order in which `order` asks for them; none of voxels that have none.
    fn colors(&self, layout: Layout, order: &dyn Fn(&FillRow<'_, u16>) -> Vec<u16>) -> [Vec<u16>; 3] {
        let Some(colors) = self.colors else { return Default::default() };
        colors.channels().map(|channel| {
            order(&|[u, v, k], row| {
                for (i, to) in row.iter_mut().enumerate() {
                    let [x, y, z] = layout.position([u + i, v, k]);
                    *to = channel.samples[(z * channel.dims[1] + y) * channel.dims[0] + x];
                }
            })
        })
    }

    /// Codes of normals in the order in which `order` asks for them; none where nothing is shaded.
    fn normals(&self, layout: Layout, order: &dyn Fn(&FillRow<'_, u16>) -> Vec<u16>) -> Vec<u16> {
        if !self.shaded {
            return Vec::new();
        }
        let (to_world, _) = self.volume.placement().scaled_gradient_matrix(1.0);
        self.volume.with_lattice(OfGradients { layout, order, to_world, of: encode })
    }

    /// World gradients in the same order; none where no sample looks at them.
    fn gradients(&self, layout: Layout, order: &dyn Fn(&FillRow<'_, f32>) -> Vec<f32>) -> [Vec<f32>; 3] {
        if !self.steep {
            return Default::default();
        }
        let to_world = gradient_matrix(self.volume);
        std::array::from_fn(|c| {
            self.volume.with_lattice(OfGradients { layout, order, to_world, of: |gradient: [f32; 3]| gradient[c] })
        })
    }
}

/// From gradients of stored numbers per index step to those in the world, in [`unit()`]s.
pub(crate) fn gradient_matrix(volume: &GridVolume) -> DMat3 {
    let (placement, factor) = (volume.placement(), volume.calibration().slope / unit(volume));
    DMat3::from_cols_array_2d(&DVec3::AXES.map(|axis| (placement.gradient_to_world(axis) * factor).to_array()))
}

/// Fills all voxels row by row; as they lie, rows are one behind the other along the axis of the second longest stride.
fn all_rows<V: Copy + Default + Send>(layout: Layout, fill: &FillRow<'_, V>) -> Vec<V> {
    let [nu, nv, nw] = layout.size;
    let mut all = vec![V::default(); nu * nv * nw + PAD];
    each_part(all[..nu * nv * nw].chunks_mut(nu), |row, values| fill([0, row % nv, row / nv], values));
    all
}

/// Codes of all voxels, with rows along x, or along y where they are to be turned.
fn lying<T: Voxel, P: Default + Clone + Send>(
    grid: &UniformGrid<T>,
    turned: bool,
    code: impl Fn(T) -> P + Sync,
) -> Vec<P> {
    let dense = Dense::new(grid.samples(), grid.dims(), if turned { 0 } else { 2 });
    let n = grid.samples().len();
    let mut codes = vec![P::default(); n + PAD];
    const CHUNK: usize = 1 << 16;
    each_part(codes[..n].chunks_mut(CHUNK).zip(dense.samples.chunks(CHUNK)), |_, (codes, samples)| {
        for (to, &sample) in codes.iter_mut().zip(*samples) {
            *to = code(sample);
        }
    });
    codes
}

/// Fills a row of numbers of voxels, from a voxel (u, v, k) on.
type FillRow<'a, V> = dyn Fn([usize; 3], &mut [V]) + Sync + 'a;

/// Numbers that follow from the gradients of voxels.
struct OfGradients<'a, V, F> {
    layout: Layout,
    order: &'a dyn Fn(&FillRow<'_, V>) -> Vec<V>,
    /// From gradients per index step to gradients in the world.
    to_world: DMat3,
    of: F,
}

impl<V, F: Fn([f32; 3]) -> V + Sync> LatticeVisitor for OfGradients<'_, V, F> {
    type Output = Vec<V>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Vec<V> {
        let columns = self.to_world.to_cols_array_2d().map(|c| c.map(|x| x as f32));
        let of = self.of;
        (self.order)(&|[u, v, k], numbers| {
            for (i, number) in numbers.iter_mut().enumerate() {
                let g = gradient_at_sample::<T, f32>(&lattice, self.layout.position([u + i, v, k]));
                let world = std::array::from_fn(|i| columns[0][i] * g[0] + columns[1][i] * g[1] + columns[2][i] * g[2]);
                *number = of(world);
            }
        })
    }
}
