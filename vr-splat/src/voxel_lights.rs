//! Light of the visible voxels of a grid, where it depends on their gradients or on colours of their own.

use fearless_simd::Level;
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{
    ColorGrid, GridVolume, LatticeVisitor, ParameterError, Scene, TransferFunction, View, Voxel, gradient_at_sample,
};
use vr_kernels::vector::{LANES, PacketLights};

use crate::gradient_optics::GradientOptics;
use crate::grid_gradients::{Gradients, world_gradient};
use crate::sample_shader::{LitSample, SampleShader, tinted};
use crate::shading::grid_shading;
use crate::sight::Sight;
use crate::splatter::Splatter;
use crate::visible::VisibleVoxels;
use crate::voxel_optics::optics_of;

/// (q, κ) of each visible voxel in a view, per world unit: in its colour, shaded, and with the opacity that its gradient leaves it.
pub(crate) struct VoxelLights {
    pub(crate) rows: Vec<[f32; 4]>,
    /// Number of the first voxel of each layer.
    pub(crate) starts: Vec<u32>,
}

impl VoxelLights {
    /// The light of a scene's visible voxels; `None` where the value alone decides.
    pub(crate) fn new(
        renderer: &Splatter,
        scene: &Scene,
        volume: &GridVolume,
        visible: &VisibleVoxels,
        view: &View,
        level: Level,
    ) -> Result<Option<Self>, ParameterError> {
        let (optics, colors) = (GradientOptics::new(scene), scene.volume.colors().map(|colors| &**colors));
        let shader = match &optics {
            Some(optics) => {
                let packet = grid_shading(optics, scene, volume);
                let gradients = Gradients::new(&optics.shading, renderer, volume);
                Some((SampleShader { optics, packet, sight: Sight::new(view)?, level }, gradients))
            }
            None if colors.is_none() => return Ok(None),
            None => None,
        };
        let layers = volume.with_lattice(Layers { shader, transfer: &scene.transfer, colors, volume, visible });
        let starts = layers.iter().scan(0, |sum, layer| {
            let start = *sum;
            *sum += layer.len() as u32;
            Some(start)
        });
        Ok(Some(Self { starts: starts.collect(), rows: layers.concat() }))
    }
}

/// Makes the light of each layer's voxels.
struct Layers<'a> {
    /// `None` where no gradient has a part in the light.
    shader: Option<(SampleShader<'a>, Gradients)>,
    transfer: &'a TransferFunction,
    colors: Option<&'a ColorGrid>,
    volume: &'a GridVolume,
    visible: &'a VisibleVoxels,
}

impl LatticeVisitor for Layers<'_> {
    type Output = Vec<Vec<[f32; 4]>>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        collect(self.visible.layers.len(), |z| {
            let voxels = self.visible.layers[z].iter().flat_map(|run| {
                let (x, y) = (usize::from(run.x), usize::from(run.y));
                (x..x + usize::from(run.length)).map(move |x| [x, y, z])
            });
            let Some((shader, gradients)) = &self.shader else {
                let row = |at| tinted(optics_of(self.transfer, self.value(&lattice, at)), self.tint(at));
                return voxels.map(|at| row(at).map(|x| x as f32)).collect();
            };
            let samples: Vec<LitSample> = voxels.map(|at| self.sample(&lattice, gradients, at)).collect();
            let mut lights = PacketLights::default();
            samples.chunks(LANES).flat_map(|some| shader.rows(some, &mut lights)).collect()
        })
    }
}

impl Layers<'_> {
    fn value<T: Voxel>(&self, lattice: &Lattice<'_, T>, [x, y, z]: [usize; 3]) -> f64 {
        self.volume.calibration().value(f64::from(lattice.at::<f32>(x, y, z)))
    }

    fn tint(&self, at: [usize; 3]) -> [f64; 3] {
        self.colors.map_or([1.0; 3], |colors| colors.color(at.map(|x| x as f64)))
    }

    fn sample<T: Voxel>(&self, lattice: &Lattice<'_, T>, gradients: &Gradients, at: [usize; 3]) -> LitSample {
        let place = at.map(|x| x as f64);
        let gradient: [f64; 3] = match gradients {
            Gradients::CentralDifferences => gradient_at_sample(lattice, at),
            other => other.at(self.volume, place),
        };
        LitSample {
            value: self.value(lattice, at),
            gradient,
            magnitude: world_gradient(self.volume, gradient).length(),
            place: self.volume.placement().to_world(DVec3::from_array(place)),
            tint: self.tint(at),
        }
    }
}
