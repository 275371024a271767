//! The work of a picture, shared out among threads: bands of the intermediate image, and rows of the screen.

use std::sync::Mutex;

use fearless_simd::Level;
use vr_core::image_order::in_parallel;
use vr_core::parallel::locked;
use vr_core::{Control, RenderError};
use vr_kernels::vector::{Vectorized, run};

use crate::axis::Cells;
use crate::codes::Code;
use crate::composite::by_gradient::{ByGradient, Hat, Node};
use crate::composite::gradients::{GradientShading, Gradients};
use crate::composite::kernel::Kernel;
use crate::composite::over::{BY_RAYS, BY_TABLE, Over, UNSHADED};
use crate::composite::ray_lights::RayLights;
use crate::composite::{Band, Scratch, Work};
use crate::factorization::IndexView;
use crate::image::IntermediateImage;
use crate::lengths::Lengths;
use crate::optics::{Entry, Optics};
use crate::passes::Pass;
use crate::reflections::Reflection;
use crate::slices::Slices;
use crate::steepness::Steepness;
use crate::warp::DepthWarp;

/// Inputs of all kernels.
pub(crate) struct Job<'a> {
    pub(crate) cells: &'a Cells,
    pub(crate) slices: &'a Slices,
    pub(crate) level: Level,
    pub(crate) before: &'a [u32],
    /// Depths at which surfaces end the texels' rays; empty where there are none.
    pub(crate) stops: &'a [f32],
    pub(crate) scratch: &'a Mutex<Vec<Scratch>>,
    pub(crate) control: &'a Control,
}

impl Job<'_> {
    pub(crate) fn draw<K: Kernel>(&self, kernel: &K, image: &mut IntermediateImage) -> Result<(), RenderError> {
        let slices = self.slices;
        match self.cells {
            Cells::InLayers(runs) => self.each_band(image, &|band, scratch| {
                run(self.level, Work { kernel, slices, runs, band, scratch });
            }),
            Cells::Between(runs) => self.each_band(image, &|band, scratch| {
                run(self.level, Work { kernel, slices, runs, band, scratch });
            }),
        }
    }

    fn each_band(
        &self,
        image: &mut IntermediateImage,
        work: &(dyn Fn(&mut Band<'_>, &mut Scratch) + Sync),
    ) -> Result<(), RenderError> {
        let bands = image.bands(self.before, self.stops, self.control.threads());
        in_parallel(self.control, bands.len() as u32, |i| {
            let mut band = locked(&bands[i as usize]);
            let mut scratch = locked(self.scratch).pop().unwrap_or_default();
            work(&mut band, &mut scratch);
            locked(self.scratch).push(scratch);
        })?;
        Ok(())
    }
}

/// Further inputs of compositing.
pub(crate) struct OverJob<'a> {
    pub(crate) normals: &'a [u16],
    pub(crate) lighting: Lighting<'a>,
    pub(crate) optics: &'a Optics,
    pub(crate) index_view: &'a IndexView,
    pub(crate) pass: &'a Pass,
    pub(crate) correction: bool,
    pub(crate) termination: f32,
    pub(crate) level: f32,
    pub(crate) before: bool,
    /// `None` where opacity follows the value alone, and shading the normals of [`Lighting`], and voxels have no colours.
    pub(crate) steep: Option<SteepMedium<'a>>,
}

/// A medium whose samples look at gradients, or have colours of their own.
pub(crate) struct SteepMedium<'a> {
    pub(crate) media: &'a Steepness,
    pub(crate) gradients: Gradients<'a>,
    /// Colours of voxels, channel by channel; `None` where they have none.
    pub(crate) colors: Option<[&'a [u16]; 3]>,
    pub(crate) shading: GradientShading<'a>,
}

/// Light that normals reflect, and the rays that it is the same for.
pub(crate) enum Lighting<'a> {
    /// Nothing is shaded.
    None,
    /// Parallel rays: a table by the codes of normals.
    Table(&'a [Reflection]),
    /// Rays of many directions: computed for each.
    Rays(RayLights),
}

impl OverJob<'_> {
    pub(crate) fn draw<P: Code>(
        &self,
        voxels: &[P],
        job: &Job<'_>,
        image: &mut IntermediateImage,
    ) -> Result<(), RenderError> {
        let (view, f, spacing) = (self.index_view, &self.pass.factorization, job.slices.spacing);
        if let Some(steep) = &self.steep {
            return self.draw_steep(steep, voxels, job, image);
        }
        // Depths are for ratios; what is interpolated after classification is a sample.
        let ratios = view.is_perspective() && self.correction;
        let entry = if self.before || !ratios { Entry::Sample } else { Entry::Depth };
        let lengths = Lengths::<P>::new(self.optics, view, f, spacing, self.correction, entry);
        match (self.before, &self.lighting) {
            (false, Lighting::None) => job.draw(&self.kernel::<P, false, UNSHADED>(voxels, &lengths), image),
            (false, Lighting::Table(_)) => job.draw(&self.kernel::<P, false, BY_TABLE>(voxels, &lengths), image),
            (false, Lighting::Rays(_)) => job.draw(&self.kernel::<P, false, BY_RAYS>(voxels, &lengths), image),
            (true, Lighting::None) => job.draw(&self.kernel::<P, true, UNSHADED>(voxels, &lengths), image),
            (true, Lighting::Table(_)) => job.draw(&self.kernel::<P, true, BY_TABLE>(voxels, &lengths), image),
            (true, Lighting::Rays(_)) => job.draw(&self.kernel::<P, true, BY_RAYS>(voxels, &lengths), image),
        }
    }

    /// Draws a medium whose samples look at gradients, or have colours of their own.
    fn draw_steep<P: Code>(
        &self,
        SteepMedium { media, gradients, colors, shading }: &SteepMedium<'_>,
        voxels: &[P],
        job: &Job<'_>,
        image: &mut IntermediateImage,
    ) -> Result<(), RenderError> {
        let (view, f, spacing) = (self.index_view, &self.pass.factorization, job.slices.spacing);
        let node = |(hat, optics): (Hat, &Optics)| Node {
            lengths: Lengths::<P>::new(optics, view, f, spacing, self.correction, Entry::Depth),
            hat,
        };
        let nodes: Vec<_> = Hat::of_nodes(&media.nodes).into_iter().zip(&media.optics).map(node).collect();
        let lengths = &nodes[0].lengths;
        if self.before {
            let over = self.kernel::<P, true, UNSHADED>(voxels, lengths);
            job.draw(&ByGradient { over, nodes: &nodes, gradients, colors: *colors, shading }, image)
        } else {
            let over = self.kernel::<P, false, UNSHADED>(voxels, lengths);
            job.draw(&ByGradient { over, nodes: &nodes, gradients, colors: *colors, shading }, image)
        }
    }

    fn kernel<'b, P: Code, const PRE_CLASSIFIED: bool, const SHADING: u8>(
        &'b self,
        voxels: &'b [P],
        lengths: &'b Lengths<P>,
    ) -> Over<'b, P, PRE_CLASSIFIED, SHADING> {
        let (reflections, rays) = match &self.lighting {
            Lighting::None => (&[][..], None),
            Lighting::Table(reflections) => (*reflections, None),
            Lighting::Rays(rays) => (&[][..], Some(rays)),
        };
        Over {
            voxels,
            normals: self.normals,
            reflections,
            rays,
            optics: self.optics,
            lengths,
            termination: self.termination,
            level: self.level,
            // Light that is cut before has no such depth.
            half: if self.level < 0.5 { f32::INFINITY } else { 0.5 },
        }
    }
}

/// Resamples an image onto the screen, and lowers the world distances of its pixels to those of what the image shows.
pub(crate) fn warp_rows(
    warp: &DepthWarp<'_>,
    width: usize,
    (pixels, distances): (&mut [[f32; 4]], &mut [f32]),
    level: Level,
    control: &Control,
) -> Result<(), RenderError> {
    /// Rows of a task.
    const ROWS: usize = 16;
    let bands: Vec<_> =
        pixels.chunks_mut(width * ROWS).zip(distances.chunks_mut(width * ROWS)).map(Mutex::new).collect();
    in_parallel(control, bands.len() as u32, |i| {
        let (pixels, distances) = &mut *locked(&bands[i as usize]);
        run(level, WarpRows { warp, first: i * ROWS as u32, width, pixels, distances });
    })?;
    Ok(())
}

struct WarpRows<'a> {
    warp: &'a DepthWarp<'a>,
    first: u32,
    width: usize,
    pixels: &'a mut [[f32; 4]],
    distances: &'a mut [f32],
}

impl Vectorized for WarpRows<'_> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: fearless_simd::Simd>(self, simd: S) {
        let rows = self.pixels.chunks_exact_mut(self.width).zip(self.distances.chunks_exact_mut(self.width));
        for (i, (pixels, distances)) in rows.enumerate() {
            let y = self.first + i as u32;
            self.warp.row(simd, y, pixels, distances);
        }
    }
}
