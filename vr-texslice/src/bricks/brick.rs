//! The texture of a brick: the part of a volume's texture in its cells.

use vr_core::filter::Lattice;
use vr_core::{AnyGrid, GradientMethod, GridVolume, Scene, UniformGrid, with_grid};

use super::lattice::Cells;
use crate::classified::{LightTexels, TextureKey};
use crate::compression::Compressed;
use crate::layout::Layout;
use crate::palette::Levels;
use crate::region::Region;
use crate::texture::{Decoded, InSlices, Relief, TextureVisitor, Voxels, visit_light};
use crate::texture_slicer::Format;

/// Texels of a brick.
pub(crate) enum Brick {
    /// Values as they are stored; and, where gradients are taken from these, the same with missing ones filled in.
    Values { grid: AnyGrid, filled: Option<Vec<f32>> },
    /// Values decoded from compressed blocks, NaN where they are missing; and, for gradients, what the blocks hold there.
    Decoded { values: Vec<f32>, filled: Option<Vec<f32>> },
    /// Light and opacity, or indices into a palette.
    Light(LightTexels),
}

/// Key of what bricks hold: those made for another are of no use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BrickKey {
    /// Gradients that are taken from them, if any are.
    pub(crate) gradients: Option<GradientMethod>,
    /// Key of texels of light; of indices into a palette without the length, which changes the palette alone.
    pub(crate) light: Option<TextureKey>,
    /// Levels of the gradient's magnitude that indices have beside them.
    pub(crate) levels: Option<Levels>,
    pub(crate) layout: Layout,
}

/// Source of bricks: the volume, and how a format has it.
pub(crate) struct BrickSource<'a> {
    pub(crate) format: Format,
    pub(crate) scene: &'a Scene,
    pub(crate) volume: &'a GridVolume,
    pub(crate) compressed: Option<&'a Compressed>,
    pub(crate) palette: Option<&'a [[f32; 4]]>,
    pub(crate) key: BrickKey,
}

impl BrickSource<'_> {
    /// True if central differences are taken from its bricks.
    fn has_differences(&self) -> bool {
        self.key.gradients == Some(GradientMethod::CentralDifferences)
    }

    /// True if samples lie on layers, beside missing voxels: what lies there belongs to the cells on both sides.
    fn looks_before(&self) -> bool {
        self.key.layout.per_layer.is_some() && self.volume.vacuum_cells().is_some()
    }

    /// Texels around a brick's own that it needs: central differences reach a voxel further, the interpolant's derivative no further than its cell.
    fn apron(&self) -> usize {
        usize::from(self.has_differences())
    }

    /// Layers before a brick's own that it needs along its last axis.
    fn layers_before(&self) -> usize {
        // Samples are moved to layers, from as far as half a slice before them: the middle of a segment that ends there may lie in the cell before.
        let middles = self.format == Format::PreIntegrated && self.key.gradients.is_some();
        let moved = self.key.layout.per_layer.is_some() && middles;
        (self.apron() + usize::from(moved)).max(usize::from(self.looks_before()))
    }

    /// The texels of a brick, along their own axes.
    pub(crate) fn region(&self, cells: &Cells) -> Region {
        let around = Region::around(cells, self.apron(), self.key.layout.turned(self.volume.dims()));
        around.starting_at_layer(cells[2][0].saturating_sub(self.layers_before()))
    }

    /// True if bricks hold a second set of values, for gradients beside missing voxels.
    fn is_filled(&self) -> bool {
        self.has_differences() && self.volume.vacuum_cells().is_some()
    }

    /// Bytes of a brick.
    pub(crate) fn bytes(&self, region: &Region) -> u64 {
        let texel = match (self.key.light, self.compressed) {
            (Some(key), _) => {
                let shaded = key.seen.is_some() || self.scene.volume.has_colors();
                LightTexels::texel_bytes(self.format, shaded, self.key.levels.is_some())
            }
            (None, Some(_)) => size_of::<f32>() as u64,
            (None, None) => self.volume.voxel_type().bytes() as u64,
        };
        let filled = if self.is_filled() { size_of::<f32>() as u64 } else { 0 };
        region.count() as u64 * (texel + filled)
    }

    /// Makes the texture of a brick: copies, decodes or classifies its texels.
    pub(crate) fn load(&self, region: &Region) -> Brick {
        let layout = &self.key.layout;
        // Light, what is decoded and what gradients are found from lie along the volume's own axes.
        let own = region.turned_back(layout);
        if let Some(key) = &self.key.light {
            return Brick::Light(LightTexels::new(self.format, self.scene, self.volume, key, &own));
        }
        if let Some(compressed) = self.compressed {
            let filled = self.is_filled().then(|| compressed.decode(&own));
            return Brick::Decoded { values: compressed.decode_with_missing(&own), filled };
        }
        let grid = with_grid!(self.volume.values(), g => {
            let texels = region.copied_along(layout.axes, &Lattice { samples: g.samples(), dims: g.dims() });
            let grid = UniformGrid::new(region.dims, texels, *g.placement(), g.calibration());
            grid.expect("a brick has two texels along each axis").into()
        });
        let filled = self.volume.filled_floats().filter(|_| self.is_filled());
        let filled = filled.map(|samples| own.copied(&Lattice { samples, dims: self.volume.dims() }));
        Brick::Values { grid, filled }
    }
}

impl Brick {
    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        let floats = |filled: &Option<Vec<f32>>| filled.as_ref().map_or(0, |filled| size_of_val(&filled[..]));
        match self {
            Self::Values { grid, filled } => (with_grid!(grid, g => size_of_val(g.samples())) + floats(filled)) as u64,
            Self::Decoded { values, filled } => (size_of_val(&values[..]) + floats(filled)) as u64,
            Self::Light(texels) => texels.bytes(),
        }
    }

    /// Hands over the texture of a region's texels.
    pub(crate) fn with_texture<V: TextureVisitor>(
        &self,
        source: &BrickSource<'_>,
        region: &Region,
        visitor: V,
    ) -> V::Output {
        let method = source.key.gradients.unwrap_or_default();
        let layout = source.key.layout;
        let own = region.turned_back(&layout);
        let dims = own.dims;
        let visitor = InSlices::new(visitor, source.volume, layout);
        match self {
            Self::Values { grid, filled } => with_grid!(grid, g => {
                let relief = match (method, filled) {
                    (GradientMethod::Analytic, _) => Relief::Interpolant,
                    (_, Some(samples)) => Relief::filled(&Lattice { samples, dims }, layout.axes),
                    (_, None) => Relief::Values,
                };
                let lattice = Lattice { samples: g.samples(), dims: region.dims };
                visitor.of_turned_texels().visit(Voxels::new(&lattice, relief))
            }),
            Self::Decoded { values, filled } => {
                let filled = Lattice { samples: filled.as_ref().unwrap_or(values), dims };
                let (values, whole) = (Lattice { samples: &values[..], dims }, source.volume.dims());
                visitor.visit(Decoded::new(&values, (filled, method), own.first, whole))
            }
            Self::Light(texels) => visit_light(texels, source.palette, dims, visitor),
        }
    }
}
