//! A renderer that has seen its scene.

use std::sync::Arc;

use fearless_simd::Level;
use vr_core::filter::Lattice;
use vr_core::vector::Rows;
use vr_core::{
    Compositing, Control, Counts, Filter, Frame, Model, Prepared, Projection, Rays, RenderError, RenderStats, Rendered,
    Scene, UniformVolume, View, with_grid,
};

use crate::draw::{Classifier, Operator, Pass, Pixel, Scene16, draw_tiles};
use crate::finish::Finish;
use crate::fragments::Setup;
use crate::model::SliceModel;
use crate::occupancy::Occupancy;
use crate::shading::{brightest, packet_shading};
use crate::slices::Slices;
use crate::support::{check, check_view, shades};
use crate::tables::{Tables, is_visible};
use crate::tex_slice::{Blend, Format, TexSlice};
use crate::texture::{Texture, Voxels};
use crate::textures::{Stacks, axes_of_stack, hold};

/// The scene, its textures, and what is kept from picture to picture.
pub(crate) struct PreparedTexSlice {
    renderer: TexSlice,
    scene: Scene,
    level: Level,
    tables: Tables,
    stacks: Stacks,
    /// What was made since the last picture, and how long it took.
    stats: RenderStats,
}

impl PreparedTexSlice {
    pub(crate) fn new(renderer: TexSlice, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&renderer, scene)?;
        control.check()?;
        let mut stats = RenderStats::default();
        let tables = stats.time("table", || Tables::new(&renderer, scene, volume));
        Ok(Self { renderer, scene: scene.clone(), level: Level::new(), tables, stacks: Stacks::default(), stats })
    }

    fn operator(&self, volume: &UniformVolume) -> Operator {
        let calibration = volume.calibration();
        let sign = calibration.slope.signum() as f32;
        match self.scene.compositing {
            Compositing::Accumulate { level } if level < 1.0 => Operator::Under { level: level as f32 },
            Compositing::Maximum => Operator::Extreme { sign },
            Compositing::Minimum => Operator::Extreme { sign: -sign },
            Compositing::Average => Operator::Average,
            Compositing::First { threshold } => {
                Operator::First { sign, threshold: calibration.stored(threshold) as f32 }
            }
            _ if self.renderer.blend == Blend::BackToFront => Operator::Over,
            _ => Operator::Under { level: 1.0 },
        }
    }

    /// Blocks in which something can be visible; `None` where all of them are drawn.
    fn occupancy(&self, volume: &UniformVolume, operator: Operator, axes: [usize; 3]) -> Option<Occupancy> {
        if !self.renderer.skip || operator.picks() {
            return None;
        }
        let ranges = volume.range_blocks(Filter::Trilinear, Occupancy::EDGE);
        Occupancy::new(&ranges, axes, |low, high| match (&self.tables.segments, self.renderer.holds_light()) {
            (Some(segments), _) => !segments.is_clear(low, high),
            (None, true) => is_visible(&self.scene.transfer, volume, low, high),
            (None, false) => self.tables.of_length().shows(low, high),
        })
    }
}

impl Prepared for PreparedTexSlice {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.renderer, scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            *self = Self::new(self.renderer.clone(), scene, control)?;
            return Ok(());
        }
        if self.scene.transfer != scene.transfer {
            self.tables = self.stats.time("table", || Tables::new(&self.renderer, scene, volume));
        }
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let scene = self.scene.clone();
        let volume = check(&self.renderer, &scene)?;
        let rays = Rays::new(view)?;
        check_view(&self.renderer, view, matches!(view.camera.projection, Projection::Perspective { .. }))?;
        control.check()?;
        let mut stats = std::mem::take(&mut self.stats);
        let operator = self.operator(volume);
        let on_faces = operator.wants_faces() || (self.renderer.is_pre_integrated() && !operator.picks());
        let slices = Slices::new(&self.renderer, view, volume.placement(), volume.dims(), on_faces)?;
        stats.time("table", || self.tables.tabulate(&scene, volume, slices.table_length()));
        let axes = slices.axis().map_or([0, 1, 2], axes_of_stack);
        match slices.axis() {
            Some(axis) => {
                stats.time("stack", || self.stacks.make(&self.renderer, volume, axis))?;
            }
            None => hold("the volume's texture", volume.sample_bytes() as u64, self.renderer.bytes())?,
        }
        let occupancy = stats.time("cull", || self.occupancy(volume, operator, axes));
        let shading = shades(&scene).then(|| packet_shading(&scene, volume, axes)).flatten();
        let shading = shading.filter(|_| scene.compositing.integrates_light());
        let tables = self.tables.of_length();
        let even = slices.are_even();
        let classifier = match &self.tables.segments {
            _ if operator.picks() => Classifier::Values,
            Some(segments) => Classifier::Segments(segments),
            None if self.renderer.holds_light() => Classifier::Done { even },
            None => Classifier::Table { rows: Rows::of(&tables.baked), optics: &tables.optics, even },
        };
        let setup = Setup {
            rays: &rays,
            placement: volume.placement(),
            dims: volume.dims(),
            clip: &view.clip,
            slices: &slices,
            axes,
            on_faces,
        };
        let finish = Finish { operator, scene: &scene, volume };
        let job = Job {
            scene: Scene16 {
                view,
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
                most: brightest(&scene),
                finish: &|rays, state, i| finish.pixel(rays, state, i),
                level: self.level,
            },
            control,
        };
        let (pixels, counts) = stats.time("draw", || self.draw(&job, volume, slices.axis()))?;
        stats.counts = counts;
        control.report(1.0);
        let depth = finish.has_depth().then(|| pixels.iter().map(|p| p.depth as f32).collect());
        let rgba = pixels.iter().map(|p| p.rgba.map(|c| c as f32)).collect();
        Ok(Rendered { frame: Frame::new(view.size, rgba, depth), stats })
    }

    /// The sum over slabs; of what is no sum, and of one that is cut at a level, the scene as it is.
    fn model(&self, view: &View) -> Model {
        if self.scene.compositing != Compositing::Over {
            return Model::Canonical;
        }
        Model::Discrete(Arc::new(SliceModel::new(&self.renderer, &self.scene, view)))
    }
}

/// A picture to draw.
struct Job<'a> {
    scene: Scene16<'a>,
    control: &'a Control,
}

type Drawn = Result<(Vec<Pixel>, Counts), RenderError>;

impl Job<'_> {
    fn through<X: Texture>(&self, texture: &X) -> Drawn {
        draw_tiles(&self.scene, texture, self.control)
    }
}

impl PreparedTexSlice {
    /// Draws through whichever texture it is.
    fn draw(&self, job: &Job<'_>, volume: &UniformVolume, stack: Option<usize>) -> Drawn {
        match (self.renderer.format, stack) {
            (_, Some(axis)) => with_grid!(self.stacks.of(volume, axis), g => {
                let lattice = Lattice { samples: g.samples(), dims: g.dims() };
                job.through(&Voxels::stack(&lattice, self.renderer.per_layer()))
            }),
            (Format::Scalar | Format::PreIntegrated | _, None) => with_grid!(volume.grid(), g => {
                job.through(&Voxels::new(&Lattice { samples: g.samples(), dims: g.dims() }))
            }),
        }
    }
}
