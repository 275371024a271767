//! A renderer that has seen its scene.

use std::any::Any;
use std::sync::Arc;
use std::time::Instant;

use fearless_simd::Level;
use vr_core::filter::Lattice;
use vr_core::{
    Compositing, Control, Counts, Frame, GridVolume, Model, Prepared, Rays, RenderError, RenderStats, Rendered, Scene,
    View, with_grid,
};
use vr_kernels::ranges::{RangeBlocks, Visibility};
use vr_kernels::vector::{Operator, PacketShading, Pairs, Rows};

use crate::bricks::{BrickLattice, Pool};
use crate::capabilities::check;
use crate::classified::{Classified, TextureKey};
use crate::compression::Compressed;
use crate::draw::{Bricked, Classifier, PacketScene, Pass, Pixel, draw_slices, draw_tiles};
use crate::finish::Finish;
use crate::fragments::Setup;
use crate::model::SliceModel;
use crate::occupancy::Occupancy;
use crate::slices::Slices;
use crate::tables::Tables;
use crate::texture::{Blocks, Indices, Light, Luminance, Relief, Rgba, ShadedIndices, Texture, Voxels};
use crate::texture_slicer::{Blend, DrawOrder, Format, TextureSlicer};
use crate::textures::{Stacks, axes_of_stack, hold};

/// The scene, its textures, and what is kept from picture to picture.
pub(crate) struct PreparedTextureSlicer {
    renderer: TextureSlicer,
    scene: Scene,
    volume: Arc<GridVolume>,
    level: Level,
    tables: Tables,
    stacks: Stacks,
    /// A texture of light, and what it was made for; `None`: for a scene that has changed since.
    classified: Option<(Option<TextureKey>, Classified)>,
    compressed: Option<Arc<Compressed>>,
    /// Pool of bricks of the volume's sample type.
    pool: Option<Box<dyn Any + Send>>,
    /// Stages since the last picture, and their times.
    stats: RenderStats,
}

impl PreparedTextureSlicer {
    pub(crate) fn new(renderer: TextureSlicer, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&renderer, scene)?;
        control.check()?;
        let mut stats = RenderStats::default();
        let tables = stats.time("table", || Tables::new(&renderer, scene, &volume));
        let compressed = (renderer.format == Format::Compressed)
            .then(|| stats.time("compress", || Arc::new(control.run(|| Compressed::new(&volume)))));
        if let Some(compressed) = &compressed {
            hold("the compressed texture", compressed.bytes(), renderer.bytes())?;
        }
        Ok(Self {
            renderer,
            scene: scene.clone(),
            volume,
            level: Level::new(),
            tables,
            stacks: Stacks::default(),
            classified: None,
            compressed,
            pool: None,
            stats,
        })
    }

    /// Blocks in which something can be visible; `None` where all of them are drawn.
    fn occupancy(&self, volume: &GridVolume, operator: Operator, axes: [usize; 3]) -> Option<Occupancy> {
        if !self.renderer.skip_empty_space || operator.picks() {
            return None;
        }
        let ranges = RangeBlocks::of_volume(volume, Occupancy::EDGE);
        if self.renderer.holds_light() {
            let voxels = Visibility::<f32>::of_light(&self.scene.transfer, volume.calibration(), None, None);
            return Occupancy::new(&ranges, axes, |low, high| voxels.shows(low, high));
        }
        let fragments = &self.tables.of_length().visibility;
        Occupancy::new(&ranges, axes, |low, high| fragments.shows(low, high))
    }
}

impl Prepared for PreparedTextureSlicer {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.renderer, scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            *self = Self::new(self.renderer.clone(), scene, control)?;
            return Ok(());
        }
        if self.scene.transfer != scene.transfer {
            self.tables = self.stats.time("table", || Tables::new(&self.renderer, scene, &volume));
        }
        if let Some((made, texture)) = &mut self.classified
            && (self.scene.transfer != scene.transfer
                || self.scene.shading != scene.shading
                || self.scene.lights != scene.lights)
        {
            *made = None;
            if self.scene.shading != scene.shading || self.scene.lights != scene.lights {
                texture.forget_reflections();
            }
        }
        (self.scene, self.volume) = (scene.clone(), volume);
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let scene = self.scene.clone();
        let volume = &*Arc::clone(&self.volume);
        let rays = Rays::new(view)?;
        control.check()?;
        let layer = scene.layer(view, control)?;
        let mut stats = std::mem::take(&mut self.stats);
        let operator =
            Operator::new(scene.compositing, volume.calibration(), self.renderer.blend == Blend::BackToFront);
        // Extremes and crossings are wanted where rays enter and leave, too.
        let finds = matches!(operator, Operator::Extreme { .. } | Operator::First { .. });
        let on_faces = finds || (self.renderer.is_pre_integrated() && !operator.picks());
        // Slices of the view, and tables for their slabs.
        let slices = Slices::new(&self.renderer, view, volume.placement(), volume.dims(), on_faces)?;
        time_if_made(&mut stats, "table", || Ok(self.tables.tabulate(&scene, volume, slices.table_length())))?;
        // The texture that these slices need.
        let axes = slices.axis().map_or([0, 1, 2], axes_of_stack);
        match slices.axis() {
            Some(axis) => {
                time_if_made(&mut stats, "stack", || self.stacks.make(&self.renderer, volume, axis))?;
            }
            None if self.renderer.holds_light() => self.classify(&scene, volume, view, &slices, control, &mut stats)?,
            None if self.compressed.is_some() || self.renderer.brick.is_some() => {}
            None => hold("the volume's texture", volume.sample_bytes() as u64, self.renderer.bytes())?,
        }
        // Blocks to leave out, and shading and classification of fragments.
        let occupancy = stats.time("cull", || self.occupancy(volume, operator, axes));
        let shading =
            scene.reflection().filter(|_| scene.compositing.integrates_light() && !self.renderer.holds_light());
        let shading = shading.map(|s| {
            // A field without missing voxels is the volume's own, and lies as that does.
            let axes = if volume.vacuum_cells().is_some() { [0, 1, 2] } else { axes };
            PacketShading::new(Arc::clone(s), &scene.lights, volume.placement(), axes)
        });
        if shading.is_some() && volume.vacuum_cells().is_some() && self.compressed.is_none() {
            hold(
                "a volume's texture and that of its gradients",
                2 * volume.sample_bytes() as u64,
                self.renderer.bytes(),
            )?;
        }
        let tables = self.tables.of_length();
        let even = slices.are_even();
        let exact = |stored: f32, ratio: f32| {
            if stored.is_nan() {
                return [f32::NAN; 4];
            }
            let value = volume.calibration().value(f64::from(stored));
            scene.transfer.step(value, f64::from(ratio) * tables.length).map(|c| c as f32)
        };
        let classifier = match &self.tables.segments {
            _ if operator.picks() => Classifier::Values,
            Some(table) => {
                let max = || scene.transfer.brightest_color_by_channel().map(|c| c as f32);
                let brightest = (!scene.transfer.has_emission()).then(max);
                Classifier::Segments { table, brightest }
            }
            None if self.renderer.holds_light() => Classifier::Done { even },
            None if !tables.baked.resolves() => Classifier::Exact(&exact),
            None => Classifier::Table { rows: Rows::new(&tables.baked), optics: &tables.optics, even },
        };
        // Everything that pixels share.
        let setup = Setup {
            rays: &rays,
            placement: volume.placement(),
            dims: volume.dims(),
            clip: &view.clip,
            slices: &slices,
            axes,
            on_faces,
        };
        let finish = Finish { operator, scene: &scene, volume, compressed: self.compressed.as_deref() };
        let job = Job {
            scene: PacketScene {
                view,
                layer: layer.as_ref(),
                setup,
                pass: Pass {
                    classifier,
                    operator,
                    dims: axes.map(|a| volume.dims()[a]),
                    on_faces,
                    length: tables.length as f32,
                    negligible: if self.renderer.termination < 1.0 {
                        (1.0 - self.renderer.termination) as f32
                    } else {
                        -1.0
                    },
                    occupancy: occupancy.as_ref(),
                },
                shading: shading.as_ref(),
                max_radiance: scene.max_radiance(),
                finish: &|rays, state, i| finish.pixel(rays, state, i),
                level: self.level,
            },
            order: self.renderer.order,
            control,
        };
        // The picture, brick by brick or through one texture.
        let (pixels, counts) = match self.renderer.brick {
            Some(edge) => {
                let pool = &mut self.pool;
                stats.time("draw", || {
                    draw_bricks(&job, volume, edge as usize, self.renderer.bytes(), pool, |low, high| {
                        !self.renderer.skip_empty_space || operator.picks() || tables.visibility.shows(low, high)
                    })
                })?
            }
            None => stats.time("draw", || self.draw(&job, volume, slices.axis()))?,
        };
        stats.counts = counts;
        control.report(1.0);
        let depth = Some(pixels.iter().map(|p| p.depth as f32).collect());
        let rgba = pixels.iter().map(|p| p.rgba.map(|c| c as f32)).collect();
        Ok(Rendered { frame: Frame::new(view.size, rgba, depth), stats })
    }

    /// The sum over slabs under `over`; the canonical pixel under every other operator.
    fn model(&self, view: &View) -> Result<Model, RenderError> {
        if self.scene.compositing != Compositing::Over {
            return Ok(Model::Canonical);
        }
        let of = (&self.scene, &self.volume);
        Ok(Model::Discrete(Arc::new(SliceModel::new(&self.renderer, of, view, self.compressed.clone())?)))
    }
}

/// Does work that tells if anything had to be made; only then it is a stage.
fn time_if_made(
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

/// A picture to draw.
struct Job<'a> {
    scene: PacketScene<'a>,
    order: DrawOrder,
    control: &'a Control,
}

/// Draws the volume brick by brick.
fn draw_bricks(
    job: &Job<'_>,
    volume: &GridVolume,
    edge: usize,
    limit: u64,
    pool: &mut Option<Box<dyn Any + Send>>,
    shows: impl Fn(f32, f32) -> bool + Sync,
) -> Drawn {
    let lattice = BrickLattice::new(volume.dims(), edge);
    let mut order = lattice.front_to_back(job.scene.view, volume.placement())?;
    if job.scene.pass.operator == Operator::Over {
        order.reverse();
    }
    let ranges = RangeBlocks::of_volume(volume, edge);
    let shows = |brick: [usize; 3]| {
        let range = ranges.at(brick);
        !range.is_empty() && shows(range.low, range.high)
    };
    fn draw<T: Pairs>(
        bricked: &Bricked<'_, T>,
        pool: &mut Option<Box<dyn Any + Send>>,
        limit: u64,
        control: &Control,
    ) -> Drawn {
        let pool = pool.get_or_insert_with(|| Box::new(Pool::<T>::new(limit)));
        let pool = pool.downcast_mut::<Pool<T>>().expect("a volume keeps its sample type");
        bricked.draw(pool, control)
    }
    with_grid!(volume.values(), g => {
        let volume = Lattice { samples: g.samples(), dims: g.dims() };
        draw(&Bricked { scene: &job.scene, volume, lattice, order: &order, shows: &shows }, pool, limit, job.control)
    })
}

type Drawn = Result<(Vec<Pixel>, Counts), RenderError>;

impl Job<'_> {
    fn through<X: Texture>(&self, texture: &X) -> Drawn {
        match self.order {
            DrawOrder::Tiles => draw_tiles(&self.scene, texture, self.control),
            DrawOrder::Slices => draw_slices(&self.scene, texture, self.control),
        }
    }
}

impl PreparedTextureSlicer {
    /// Makes the texture of light for a view, unless there is one that serves.
    fn classify(
        &mut self,
        scene: &Scene,
        volume: &GridVolume,
        view: &View,
        slices: &Slices,
        control: &Control,
        stats: &mut RenderStats,
    ) -> Result<(), RenderError> {
        let format = self.renderer.format;
        hold(
            "the texture of light",
            Classified::bytes(format, volume, scene.reflection().is_some()),
            self.renderer.bytes(),
        )?;
        let made = TextureKey::new(scene, view, slices)?;
        match &mut self.classified {
            Some((of, _)) if *of == Some(made) => {}
            Some((of, texture @ Classified::Indices { .. })) => {
                let start = Instant::now();
                let reflects = control.run(|| texture.recolor(scene, volume, &made));
                stats.stages.push((if reflects { "reflect" } else { "palette" }, start.elapsed()));
                *of = Some(made);
            }
            other => {
                // The old one goes first: there may be no room for both.
                *other = None;
                let new = || control.run(|| Classified::new(format, scene, volume, &made));
                *other = Some((Some(made), stats.time("classify", new)));
            }
        }
        Ok(())
    }

    /// Draws through whichever texture it is.
    fn draw(&self, job: &Job<'_>, volume: &GridVolume, stack: Option<usize>) -> Drawn {
        let dims = volume.dims();
        let relief = |axes: [usize; 3]| {
            let samples =
                volume.filled_floats().filter(|_| job.scene.shading.is_some() && volume.vacuum_cells().is_some());
            samples.map(|samples| Relief::new(&Lattice { samples, dims }, axes))
        };
        if let Some(axis) = stack {
            return with_grid!(self.stacks.of(volume, axis), g => {
                let lattice = Lattice { samples: g.samples(), dims: g.dims() };
                // A point is looked for between slices, too: where a ray enters and leaves, both have their share.
                let texture = match job.scene.pass.operator {
                    Operator::First { .. } => Voxels::new(&lattice),
                    _ => Voxels::stack(&lattice, self.renderer.per_layer()),
                };
                job.through(&texture.with_relief(relief(axes_of_stack(axis))))
            });
        }
        if let Some(compressed) = &self.compressed {
            return job.through(&Blocks(compressed));
        }
        match &self.classified {
            Some((_, Classified::Rgba(texels))) => job.through(&Light { texels: Rgba(texels), dims }),
            Some((_, Classified::Luminance(texels))) => job.through(&Light { texels: Luminance(texels), dims }),
            Some((_, Classified::Indices { texels, palette, reflections: None })) => {
                job.through(&Light { texels: Indices { texels, palette }, dims })
            }
            Some((_, Classified::Indices { texels, palette, reflections: Some(reflections) })) => {
                let colors = Indices { texels, palette };
                job.through(&Light { texels: ShadedIndices { colors, reflections: &reflections.texels }, dims })
            }
            None => with_grid!(volume.values(), g => {
                job.through(&Voxels::new(&Lattice { samples: g.samples(), dims: g.dims() }).with_relief(relief([0, 1, 2])))
            }),
        }
    }
}
