//! The textures that a prepared renderer keeps from picture to picture: made when a view first needs them, within the budget.

use std::sync::Arc;

use vr_core::clock::Instant;
use vr_core::filter::Lattice;
use vr_core::{Control, Counts, GradientMethod, GridVolume, RenderError, RenderStats, Scene, View, memory, with_grid};
use vr_kernels::vector::Operator;

use crate::bricks::{BrickKey, BrickLattice, BrickSource, Pool};
use crate::classified::{Classified, TextureKey, levels, palette};
use crate::compression::Compressed;
use crate::draw::{Bricked, Classifier, PacketScene, Pixel, draw_slices, draw_tiles};
use crate::layout::Layout;
use crate::occupancy::FieldRanges;
use crate::palette::Palette;
use crate::slices::Slices;
use crate::texture::{Blocks, InSlices, Relief, Texture, TextureVisitor, Voxels, visit_light};
use crate::texture_slicer::{DrawOrder, Format, TextureSlicer};
use crate::textures::{Stacks, hold};

/// Textures, and what they were made for.
#[derive(Default)]
pub(crate) struct TextureStore {
    stacks: Stacks,
    /// A texture of light, and what it was made for; `None`: for a scene that has changed since.
    classified: Option<(Option<TextureKey>, Classified)>,
    compressed: Option<Arc<Compressed>>,
    bricks: Option<Pool>,
    /// The palette of bricks, and the length that it was made for; `None`: for a scene that has changed since.
    palette: Option<(Option<f64>, Palette)>,
}

/// A picture to draw.
pub(crate) struct Job<'a> {
    pub(crate) scene: PacketScene<'a>,
    pub(crate) order: DrawOrder,
    pub(crate) control: &'a Control,
}

/// Pixels, row by row, and counts of the work.
pub(crate) type Drawn = Result<(Vec<Pixel>, Counts), RenderError>;

impl TextureVisitor for &Job<'_> {
    type Output = Drawn;

    fn visit<X: Texture>(self, texture: X) -> Drawn {
        match self.order {
            DrawOrder::Tiles => draw_tiles(&self.scene, &texture, self.control),
            DrawOrder::Slices => draw_slices(&self.scene, &texture, self.control),
        }
    }
}

/// A view of a scene, as far as textures depend on it.
#[derive(Clone, Copy)]
pub(crate) struct Needs<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) volume: &'a GridVolume,
    pub(crate) view: &'a View,
    pub(crate) slices: &'a Slices,
    pub(crate) layout: Layout,
    /// Gradients of values that fragments look at, if they look at any.
    pub(crate) gradients: Option<GradientMethod>,
}

impl Needs<'_> {
    /// True if gradients are taken from a field of their own, in which missing voxels are filled in.
    fn fills_in(&self) -> bool {
        self.gradients == Some(GradientMethod::CentralDifferences) && self.volume.vacuum_cells().is_some()
    }
}

impl TextureStore {
    /// The textures that are made before there is a view: compressed blocks.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] where the budget does not hold them, [`RenderError::Memory`] where there is too little memory.
    pub(crate) fn new(
        renderer: &TextureSlicer,
        volume: &GridVolume,
        control: &Control,
        stats: &mut RenderStats,
    ) -> Result<Self, RenderError> {
        let is_compressed = renderer.format == Format::Compressed;
        if is_compressed {
            memory::check("the compressed texture", Compressed::bytes_in_memory(volume))?;
        }
        let compressed =
            is_compressed.then(|| stats.time("compress", || Arc::new(control.run(|| Compressed::new(volume)))));
        if let Some(compressed) = &compressed {
            hold("the compressed texture", compressed.bytes(), renderer.bytes())?;
        }
        Ok(Self { compressed, ..Self::default() })
    }

    /// The compressed texture, of the format that has one.
    pub(crate) fn compressed(&self) -> Option<&Arc<Compressed>> {
        self.compressed.as_ref()
    }

    /// Takes note of a scene that differs from the last one in its transfer function, or in its shading or lights.
    pub(crate) fn forget(&mut self, transfer: bool, reflections: bool) {
        if !transfer && !reflections {
            return;
        }
        if let Some((made, texture)) = &mut self.classified {
            *made = None;
            if reflections {
                texture.forget_reflections();
            }
        }
        if let Some((made, _)) = &mut self.palette {
            *made = None;
        }
        // Indices outlive a transfer function; values, which have no key of light, outlive everything.
        let indices = self.palette.is_some() && !reflections;
        self.bricks = self.bricks.take().filter(|pool| pool.key.light.is_none() || indices);
    }

    /// Makes what a view needs, unless it is there.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] where the budget does not hold it.
    pub(crate) fn make(
        &mut self,
        renderer: &TextureSlicer,
        needs: &Needs<'_>,
        control: &Control,
        stats: &mut RenderStats,
    ) -> Result<(), RenderError> {
        let (volume, limit) = (needs.volume, renderer.bytes());
        if renderer.brick.is_some() {
            return self.make_pool(renderer, needs, stats);
        }
        let bytes = volume.sample_bytes() as u64;
        match needs.slices.axis() {
            _ if renderer.holds_light() => self.classify(renderer, needs, control, stats)?,
            _ if self.compressed.is_some() => {}
            Some(axis) => time_if_made(stats, "stack", || self.stacks.make(renderer, volume, axis))?,
            None => hold("the volume's texture", bytes, limit)?,
        }
        if needs.fills_in() && self.compressed.is_none() {
            hold("a volume's texture and that of its gradients", 2 * bytes, limit)?;
        }
        Ok(())
    }

    /// Makes the texture of light for a view, unless there is one that serves.
    fn classify(
        &mut self,
        renderer: &TextureSlicer,
        needs: &Needs<'_>,
        control: &Control,
        stats: &mut RenderStats,
    ) -> Result<(), RenderError> {
        let Needs { scene, volume, .. } = *needs;
        let format = renderer.format;
        hold("the texture of light", Classified::bytes(format, scene, volume), renderer.bytes())?;
        let made = TextureKey::new(scene, needs.view, needs.slices)?;
        if matches!(&self.classified, Some((of, _)) if *of == Some(made)) {
            return Ok(());
        }
        if let Some((of, texture)) = &mut self.classified {
            let start = Instant::now();
            if let Some(reflects) = control.run(|| texture.recolor(scene, volume, &made)) {
                stats.stages.push((if reflects { "reflect" } else { "palette" }, start.elapsed()));
                *of = Some(made);
                return Ok(());
            }
        }
        // The old one goes first: there may be no room for both.
        self.classified = None;
        memory::check("the texture of light", Classified::bytes(format, scene, volume))?;
        let new = || control.run(|| Classified::new(format, scene, volume, &made));
        self.classified = Some((Some(made), stats.time("classify", new)));
        Ok(())
    }

    /// Makes the pool of bricks for a view, unless there is one whose bricks serve; and their palette.
    fn make_pool(
        &mut self,
        renderer: &TextureSlicer,
        needs: &Needs<'_>,
        stats: &mut RenderStats,
    ) -> Result<(), RenderError> {
        let Needs { scene, volume, .. } = *needs;
        let light = renderer.holds_light().then(|| TextureKey::new(scene, needs.view, needs.slices)).transpose()?;
        let levels = levels(renderer.format, scene, volume);
        let mut key = BrickKey { gradients: needs.gradients, light, levels, layout: needs.layout };
        if let (Format::Paletted, Some(light)) = (renderer.format, &mut key.light) {
            let length = std::mem::take(&mut light.length);
            if self.palette.as_ref().is_none_or(|(made, _)| *made != Some(length)) {
                let new = stats.time("palette", || palette(renderer.format, scene, volume, length));
                self.palette = new.map(|palette| (Some(length), palette));
            }
        }
        if self.bricks.as_ref().is_none_or(|pool| pool.key != key) {
            let blocks = self.compressed.as_ref().map_or(0, |compressed| compressed.bytes());
            self.bricks = Some(Pool::new(key, blocks, renderer.bytes()));
        }
        Ok(())
    }

    /// Draws a picture through the textures made for its view. `visible` is true if a field between two stored numbers can be visible.
    pub(crate) fn draw(
        &mut self,
        job: &Job<'_>,
        renderer: &TextureSlicer,
        needs: &Needs<'_>,
        visible: impl Fn(f32, f32) -> bool + Sync,
        stats: &mut RenderStats,
    ) -> Drawn {
        let Some(edge) = renderer.brick else { return stats.time("draw", || self.draw_whole(job, needs)) };
        let drawn = stats.time("draw", || self.draw_bricks(job, renderer, needs, edge as usize, visible));
        if let Some(time) = self.bricks.as_mut().and_then(Pool::take_time) {
            stats.stages.push(("brick", time));
        }
        drawn
    }

    /// Draws the volume brick by brick.
    fn draw_bricks(
        &mut self,
        job: &Job<'_>,
        renderer: &TextureSlicer,
        needs: &Needs<'_>,
        edge: usize,
        visible: impl Fn(f32, f32) -> bool + Sync,
    ) -> Drawn {
        let volume = needs.volume;
        let pool = self.bricks.as_mut().expect("made for the view");
        let layout = pool.key.layout;
        let lattice = BrickLattice::new(volume.dims(), edge, layout);
        let mut order = lattice.front_to_back(job.scene.view, volume.placement())?;
        if job.scene.pass.operator == Operator::Over {
            order.reverse();
        }
        let ranges = FieldRanges::new(volume, self.compressed.as_deref(), edge);
        let segments = matches!(job.scene.pass.classifier, Classifier::Segments(_));
        let shows = |bricks: [[usize; 2]; 3]| ranges.show(layout.turned_back(bricks), segments, &visible);
        let source = BrickSource {
            format: renderer.format,
            scene: needs.scene,
            volume,
            compressed: self.compressed.as_deref(),
            palette: self.palette.as_ref().map(|(_, palette)| &palette[..]),
            key: pool.key,
        };
        Bricked { scene: &job.scene, source, lattice, order: &order, shows: &shows }.draw(pool, job.control)
    }

    /// Draws through one texture, whichever it is.
    fn draw_whole(&self, job: &Job<'_>, needs: &Needs<'_>) -> Drawn {
        let Needs { volume, layout, .. } = *needs;
        let dims = volume.dims();
        let slices = InSlices::new(job, volume, layout);
        if let Some(compressed) = &self.compressed {
            return slices.visit(Blocks { compressed, method: needs.gradients.unwrap_or_default() });
        }
        if let Some((_, Classified { texels, palette, .. })) = &self.classified {
            return visit_light(texels, palette.as_deref(), dims, slices);
        }
        let relief = match (needs.gradients, volume.filled_floats()) {
            (Some(GradientMethod::Analytic), _) => Relief::Interpolant,
            (_, Some(samples)) if needs.fills_in() => Relief::filled(&Lattice { samples, dims }, layout.axes),
            _ => Relief::Values,
        };
        let values = needs.slices.axis().map_or(volume.values(), |axis| self.stacks.of(volume, axis));
        let slices = slices.of_turned_texels();
        with_grid!(values, g => {
            let lattice = Lattice { samples: g.samples(), dims: layout.turned(dims) };
            slices.visit(Voxels::new(&lattice, relief))
        })
    }
}

/// Does work that tells if anything had to be made; only then it is a stage.
pub(crate) fn time_if_made(
    stats: &mut RenderStats,
    stage: &'static str,
    work: impl FnOnce() -> Result<bool, RenderError>,
) -> Result<(), RenderError> {
    let start = Instant::now();
    if work()? {
        stats.stages.push((stage, start.elapsed()));
    }
    Ok(())
}
