//! A renderer that has seen its scene.

use std::sync::Arc;

use fearless_simd::Level;
use vr_core::filter::Lattice;
use vr_core::image_order::in_parallel;
use vr_core::{
    Compositing, Control, Filter, Frame, GridVolume, LatticeVisitor, Model, ParameterError, PointSet, Prepared,
    RenderError, RenderStats, Rendered, Scene, View, Voxel, memory,
};
use vr_kernels::vector::{Operator, VoxelColors};

use crate::bins::{Bins, Keys, TILE};
use crate::capabilities::{check, check_view};
use crate::classified::{Classified, Visible};
use crate::finish::Picture;
use crate::ghosts::Ghosts;
use crate::gradient_optics::GradientOptics;
use crate::input::{SplatInput, offset, profile};
use crate::kernel::Profile;
use crate::model::SplatModel;
use crate::point_lights::{GradientsAtPoints, point_lights};
use crate::projection::SplatView;
use crate::shading::Shader;
use crate::sheets::{ImageSheets, MIN_MET, OwnSheets, reach_in_view, takes_middles};
use crate::source::{GridSplats, PointSplats, Source, Spread};
use crate::splatter::{Buffers, CompositingOrder, Splatter};
use crate::tile::{Bounds, Classifier, Content, FootprintKernel, Painter, SplatLight, VisibleCells};
use crate::visible::VisibleVoxels;
use crate::voxel_lights::VoxelLights;

/// The scene, what can be seen of it, and tables.
pub(crate) struct PreparedSplatter {
    /// As it was asked for.
    given: Splatter,
    /// With the kernel that the volume's filter is.
    renderer: Splatter,
    scene: Scene,
    input: SplatInput,
    level: Level,
    kernel: FootprintKernel,
    /// Reach of voxels' kernels for which visible cells were found.
    reach: [f64; 3],
    classified: Classified,
    ghosts: Option<Ghosts>,
    /// Stages since the last picture, and their times.
    stats: RenderStats,
}

impl PreparedSplatter {
    pub(crate) fn new(given: Splatter, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let input = check(&given, scene)?;
        let renderer = given.spreading(&input);
        control.check()?;
        let mut stats = RenderStats::default();
        let kernel = stats.time("kernel", || FootprintKernel::new(&profile(&renderer, &input)));
        let ghosts = stats.time("filter", || control.run(|| Ghosts::new(&renderer, &input)));
        // How far a low-pass widens kernels is known when there is a view (`fit_reach`).
        let reach = renderer.kernel.reach();
        let make = || Classified::new(&renderer, scene, &input, ghosts.as_ref(), reach);
        let classified = stats.time("classify", || control.run(make));
        let (scene, level) = (scene.clone(), Level::new());
        let mut made = Self { given, renderer, scene, input, level, kernel, reach, classified, ghosts, stats };
        made.prepare_gradients(control);
        Ok(made)
    }

    /// Finds visible cells anew if a low-pass gives kernels another reach in a view.
    fn fit_reach(&mut self, view: &View, control: &Control) -> Result<(), ParameterError> {
        if self.renderer.low_pass == 0.0 || self.renderer.splats_light() || matches!(self.input, SplatInput::Points(_))
        {
            return Ok(());
        }
        let reach = reach_in_view(&self.renderer, &self.scene.volume, &self.splat_view(view)?);
        if reach != self.reach {
            let make = || Classified::new(&self.renderer, &self.scene, &self.input, self.ghosts.as_ref(), reach);
            self.classified = self.stats.time("classify", || control.run(make));
            self.reach = reach;
        }
        Ok(())
    }

    /// Finds the gradients at points that the scene's light depends on, so that the first frame does not pay for them.
    fn prepare_gradients(&mut self, control: &Control) {
        let SplatInput::Points(points) = &self.input else { return };
        if self.renderer.splats_light() && GradientOptics::new(&self.scene).is_some() {
            self.stats.time("gradients", || control.run(|| GradientsAtPoints::of(points)));
        } else if self.scene.reflection().is_some() && !self.scene.compositing.integrates_light() {
            self.stats.time("gradients", || control.run(|| points.prepare_derived()));
        }
    }
}

impl Prepared for PreparedSplatter {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let input = check(&self.given, scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            *self = Self::new(self.given.clone(), scene, control)?;
            return Ok(());
        }
        let picks = |scene: &Scene| !scene.compositing.integrates_light();
        if self.scene.transfer != scene.transfer || picks(scene) != picks(&self.scene) {
            let (renderer, ghosts, reach) = (&self.renderer, self.ghosts.as_ref(), self.reach);
            let make = || Classified::new(renderer, scene, &input, ghosts, reach);
            self.classified = self.stats.time("classify", || control.run(make));
        }
        (self.scene, self.input) = (scene.clone(), input);
        self.prepare_gradients(control);
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        check_view(view)?;
        control.check()?;
        self.fit_reach(view, control)?;
        let mut stats = std::mem::take(&mut self.stats);
        let frame = match (&self.input, &self.classified.visible) {
            (SplatInput::Grid(grid), Visible::Voxels(voxels)) => {
                let draw = DrawGrid { prepared: self, grid, voxels, view, control, stats: &mut stats };
                match &self.ghosts {
                    Some(ghosts) => draw.visit(ghosts.lattice())?,
                    None => grid.with_lattice(draw)?,
                }
            }
            (SplatInput::Points(points), Visible::Points(visible)) => {
                self.draw_points(points, visible, view, control, &mut stats)?
            }
            _ => unreachable!("classified as what it is"),
        };
        control.report(1.0);
        Ok(Rendered { frame, stats })
    }

    /// The sum over sheets or splats under `over`; the canonical pixel under every other operator.
    fn model(&self, view: &View) -> Result<Model, RenderError> {
        if self.scene.compositing != Compositing::Over {
            return Ok(Model::Canonical);
        }
        let model = SplatModel::new(&self.renderer, &self.scene, &self.input, view)?;
        Ok(Model::Discrete(Arc::new(model)))
    }
}

/// A picture to draw: splats, and their view.
struct Drawing<'a> {
    source: &'a dyn Source,
    splat_view: &'a SplatView,
    /// The axis of the volume's own sheets, and the layer of each.
    layers: Option<(usize, &'a [u32])>,
    /// Cells in which something can be seen at all.
    cells: Option<VisibleCells<'a>>,
    /// Light of splats that are classified already.
    light: SplatLight<'a>,
}

/// Draws a grid, whatever its samples are.
struct DrawGrid<'a> {
    prepared: &'a PreparedSplatter,
    grid: &'a GridVolume,
    voxels: &'a VisibleVoxels,
    view: &'a View,
    control: &'a Control,
    stats: &'a mut RenderStats,
}

impl LatticeVisitor for DrawGrid<'_> {
    type Output = Result<Frame, RenderError>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        let Self { prepared, grid, voxels, view, control, stats } = self;
        let renderer = &prepared.renderer;
        let input = &prepared.input;
        let splat_view = prepared.splat_view(view)?;
        let own = (renderer.buffers == Buffers::Axis).then(|| OwnSheets::new(renderer, grid, view)).transpose()?;
        let sheets = own.as_ref().map(|own| (own.axis, own.order.as_slice()));
        let beyond = voxels.beyond;
        let cells = voxels.cells.as_ref().map(|bits| VisibleCells { bits, dims: lattice.dims, beyond });
        let spread =
            Spread { reach: renderer.kernel.reach(), low_pass: renderer.low_pass, offset: offset(input).0, beyond };
        // Light of voxels in which gradients have a part, or colours of their own, is found for the view.
        let lit = renderer.splats_light() && prepared.scene.compositing.integrates_light();
        let lights = if lit {
            let make =
                || control.run(|| VoxelLights::new(renderer, &prepared.scene, grid, voxels, view, prepared.level));
            stats.time("light", make)?
        } else {
            None
        };
        let numbers = lights.as_ref().map(|lights| lights.starts.as_slice());
        let source = GridSplats::new(lattice, voxels, &splat_view, grid.placement(), spread, sheets, numbers);
        let layers = own.as_ref().map(|own| (own.axis, own.layers.as_slice()));
        let light = match &lights {
            Some(lights) => SplatLight::OfSample(&lights.rows),
            None => SplatLight::OfValue(&prepared.classified.light),
        };
        let drawing = Drawing { source: &source, splat_view: &splat_view, layers, cells, light };
        prepared.draw(view, &drawing, control, stats)
    }
}

impl PreparedSplatter {
    fn draw_points(
        &self,
        points: &PointSet,
        visible: &[u32],
        view: &View,
        control: &Control,
        stats: &mut RenderStats,
    ) -> Result<Frame, RenderError> {
        let splat_view = self.splat_view(view)?;
        // Light of points in which gradients have a part is found for the view.
        let lights = if self.renderer.splats_light() {
            let make = || control.run(|| point_lights(&self.scene, points, visible, view, self.level));
            stats.time("light", make)?
        } else {
            None
        };
        let (low_pass, numbered) = (self.renderer.low_pass, lights.is_some() || self.classified.mixture.is_some());
        let source = PointSplats { points, visible, view: &splat_view, low_pass, numbered };
        let light = match &lights {
            Some(rows) => SplatLight::OfSample(rows),
            None => SplatLight::OfValue(&self.classified.light),
        };
        let drawing = Drawing { source: &source, splat_view: &splat_view, layers: None, cells: None, light };
        self.draw(view, &drawing, control, stats)
    }

    /// The view of all that may be drawn.
    fn splat_view(&self, view: &View) -> Result<SplatView, ParameterError> {
        crate::sheets::splat_view(&self.renderer, &self.scene, &self.input, view)
    }

    fn draw(
        &self,
        view: &View,
        drawing: &Drawing<'_>,
        control: &Control,
        stats: &mut RenderStats,
    ) -> Result<Frame, RenderError> {
        let &Drawing { source, splat_view, layers, cells, light } = drawing;
        let (renderer, scene, input) = (&self.renderer, &self.scene, &self.input);
        let layer = scene.layer(view, control)?;
        let (_, calibration) = offset(input);
        let grid = match input {
            SplatInput::Grid(grid) => Some(grid),
            SplatInput::Points(_) => None,
        };
        let operator = Operator::new(scene.compositing, calibration, renderer.order == CompositingOrder::BackToFront);
        let colors = scene.volume.colors().map(|colors| VoxelColors::new(colors));
        // Where nothing is missing, a mean needs no sheets: but the Gaussian filter's, whose weights have another sum at every place, and that of colours, which
        // are looked up in sheets.
        let sums = operator == Operator::Average
            && colors.is_none()
            && grid.is_some_and(|grid| grid.vacuum_cells().is_none() && grid.filter() != Filter::Gaussian);
        let sheets = ImageSheets::new(renderer, &scene.volume, input, splat_view)?;
        let exact = |stored: f32, length: f32| {
            if length <= 0.0 {
                return [0.0; 4];
            }
            scene.transfer.step(calibration.value(f64::from(stored)), f64::from(length)).map(|x| x as f32)
        };
        // A picked value is shaded once, at its place.
        let shader = Shader::new(renderer, scene, input, calibration, splat_view);
        // Everything that tiles share.
        let painter = Painter {
            view: splat_view,
            bounds: Bounds {
                clip: &view.clip,
                layer: layer.as_ref(),
                samples: view.supersampling,
                grid: grid.map(|grid| (grid.placement(), grid.dims())),
                boxed: crate::sheets::is_boxed(renderer, scene, input),
            },
            kernel: &self.kernel,
            in_middle: match profile(renderer, input) {
                Profile::Radial(radial) if takes_middles(renderer, input) => radial.weight(),
                _ => None,
            },
            operator,
            buffers: renderer.buffers,
            distance: sheets.distance as f32,
            per_distance: (1.0 / sheets.distance) as f32,
            sheets: sheets.count,
            ring: sheets.ring,
            layers,
            content: if sums {
                Content::Sums
            } else if renderer.splats_light() && !operator.picks() {
                Content::Light(light)
            } else {
                Content::Values {
                    classifier: if self.classified.resolved {
                        Classifier::Table(&self.classified.values)
                    } else if let Some(ramps) = &self.classified.ramps {
                        Classifier::Ramps(ramps)
                    } else {
                        Classifier::Exact(&exact)
                    },
                    normalised: grid.is_some(),
                    mixture: self.classified.mixture.as_ref(),
                    colors: colors.as_ref(),
                    cells,
                    shader: shader.as_ref(),
                }
            },
            // A mean weighs what it takes, however little.
            min_met: if operator == Operator::Average { f32::NEG_INFINITY } else { (MIN_MET * splat_view.unit) as f32 },
            negligible: if renderer.termination < 1.0 {
                let (low, high) = scene.volume.bounds();
                ((1.0 - renderer.termination) / scene.max_radiance().over(low.distance(high))) as f32
            } else {
                -1.0
            },
            level: self.level,
        };
        // Order of the splats of a tile.
        let keys = match renderer.buffers {
            _ if sums => Keys::Own,
            Buffers::Image => Keys::Image { distance: sheets.distance, count: sheets.count },
            Buffers::Axis => Keys::Own,
            Buffers::Samples => Keys::Depth,
        };
        let [across, down] = splat_view.size.map(|n| n.div_ceil(TILE));
        // Each thread is at a tile.
        let tiles = u64::from(across * down).min(control.threads() as u64);
        memory::check("the sheets of the tiles", tiles * painter.sheet_bytes())?;
        // Tiles, in groups of rows whose splats fit into the memory allowed.
        let mut picture = Picture::new(renderer, scene, view, calibration, operator);
        let rows = rows_at_once(source.count(), down);
        for first in (0..down).step_by(rows as usize) {
            let last = (first + rows).min(down);
            let bins = stats.time("bin", || Bins::new(source, splat_view, keys, first..last, control))?;
            let drawn = stats.time("draw", || {
                in_parallel(control, across * (last - first), |tile| {
                    let (column, row) = (tile % across * TILE, (first + tile / across) * TILE);
                    painter.draw(column, row, bins.sorted(tile))
                })
            })?;
            for tile in &drawn {
                stats.counts.rays += tile.work.rays;
                stats.counts.samples += tile.work.met;
                stats.counts.skipped += tile.work.skipped;
                stats.counts.terminated += tile.work.opaque;
                picture.take(tile, splat_view);
            }
        }
        Ok(picture.finish(layer.as_ref()))
    }
}

/// Bytes of splats that are held at once.
const MAX_BYTES: u64 = 1 << 29;
/// Bytes of a splat, in its tiles and as it is sorted.
const BYTES: u64 = 48;

/// Number of rows of tiles that are drawn at once.
fn rows_at_once(splats: u64, rows: u32) -> u32 {
    let parts = (splats * BYTES).div_ceil(MAX_BYTES).clamp(1, u64::from(rows));
    rows.div_ceil(parts as u32)
}
