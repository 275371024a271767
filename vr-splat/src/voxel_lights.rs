//! Light of the visible voxels of a grid, where it depends on their gradients.

use fearless_simd::Level;
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{GridVolume, LatticeVisitor, ParameterError, Scene, View, Voxel, gradient_at_sample};
use vr_kernels::vector::{LANES, PacketLights};

use crate::gradient_optics::GradientOptics;
use crate::grid_gradients::{Gradients, world_gradient};
use crate::sample_shader::{LitSample, SampleShader};
use crate::shading::grid_shading;
use crate::sight::Sight;
use crate::splatter::Splatter;
use crate::visible::VisibleVoxels;

/// (q, κ) of each visible voxel in a view, per world unit: shaded, and with the opacity that its gradient leaves it.
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
        let Some(optics) = GradientOptics::new(scene) else { return Ok(None) };
        let gradients = Gradients::new(&optics.shading, renderer, volume);
        let packet = grid_shading(&optics, scene, volume);
        let shader = SampleShader { optics: &optics, packet, sight: Sight::new(view)?, level };
        let layers = volume.with_lattice(Layers { shader, gradients, volume, visible });
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
    shader: SampleShader<'a>,
    gradients: Gradients,
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
            let samples: Vec<LitSample> = voxels.map(|at| self.sample(&lattice, at)).collect();
            let mut lights = PacketLights::default();
            samples.chunks(LANES).flat_map(|some| self.shader.rows(some, &mut lights)).collect()
        })
    }
}

impl Layers<'_> {
    fn sample<T: Voxel>(&self, lattice: &Lattice<'_, T>, at: [usize; 3]) -> LitSample {
        let place = at.map(|x| x as f64);
        let gradient: [f64; 3] = match self.gradients {
            Gradients::CentralDifferences => gradient_at_sample(lattice, at),
            other => other.at(self.volume, place),
        };
        LitSample {
            value: self.volume.calibration().value(f64::from(lattice.at::<f32>(at[0], at[1], at[2]))),
            gradient,
            magnitude: world_gradient(self.volume, gradient).length(),
            place: self.volume.placement().to_world(DVec3::from_array(place)),
        }
    }
}
