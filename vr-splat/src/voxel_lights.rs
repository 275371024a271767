//! Light of voxels that are classified before they are splatted, where it depends on their gradients.

use fearless_simd::{Level, Simd};
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{GridVolume, LatticeVisitor, ParameterError, Projection, Scene, View, Voxel, gradient_at_sample};
use vr_kernels::vector::{LANES, Lanes, PacketLights, PacketShading, Shade, Vectorized, run};

use crate::gradient_optics::GradientOptics;
use crate::shading::{Gradients, packet_shading, world_gradient};
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
        let packet = packet_shading(&optics, scene, volume);
        let gradients = Gradients::new(&optics.shading, renderer, volume);
        let view = Sight::new(view)?;
        let layers =
            volume.with_lattice(Shadings { optics: &optics, packet: &packet, gradients, volume, visible, view, level });
        let starts = layers.iter().scan(0, |sum, layer| {
            let start = *sum;
            *sum += layer.len() as u32;
            Some(start)
        });
        Ok(Some(Self { starts: starts.collect(), rows: layers.concat() }))
    }
}

/// Directions in which voxels are seen.
#[derive(Clone, Copy)]
pub(crate) enum Sight {
    /// The same for all.
    Along(DVec3),
    /// From the eye.
    From(DVec3),
}

impl Sight {
    pub(crate) fn new(view: &View) -> Result<Self, ParameterError> {
        Ok(match view.camera.projection {
            Projection::Perspective { .. } => Self::From(view.camera.eye),
            Projection::Orthographic { .. } => Self::Along(view.camera.frame()?.z_axis),
        })
    }

    /// Unit vector from the eye to a place in the world.
    pub(crate) fn towards(self, place: DVec3) -> DVec3 {
        match self {
            Self::Along(direction) => direction,
            Self::From(eye) => (place - eye).normalize_or_zero(),
        }
    }
}

/// Makes the light of each layer's voxels.
struct Shadings<'a> {
    optics: &'a GradientOptics<'a>,
    packet: &'a PacketShading,
    gradients: Gradients,
    volume: &'a GridVolume,
    visible: &'a VisibleVoxels,
    view: Sight,
    level: Level,
}

impl LatticeVisitor for Shadings<'_> {
    type Output = Vec<Vec<[f32; 4]>>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        collect(self.visible.layers.len(), |z| {
            let voxels = self.visible.layers[z].iter().flat_map(|run| {
                let (x, y) = (usize::from(run.x), usize::from(run.y));
                (x..x + usize::from(run.length)).map(move |x| [x, y, z])
            });
            let voxels: Vec<[usize; 3]> = voxels.collect();
            let mut lights = PacketLights::default();
            voxels.chunks(LANES).flat_map(|some| self.packet(&lattice, some, &mut lights)).collect()
        })
    }
}

impl Shadings<'_> {
    /// The light of up to sixteen voxels.
    fn packet<T: Voxel>(
        &self,
        lattice: &Lattice<'_, T>,
        voxels: &[[usize; 3]],
        lights: &mut PacketLights,
    ) -> Vec<[f32; 4]> {
        let (placement, calibration) = (self.volume.placement(), self.volume.calibration());
        let (mut gradients, mut rows, mut directions) = ([Lanes::ZERO; 3], [Lanes::ZERO; 4], [[0.0; LANES]; 3]);
        for i in 0..LANES {
            // The last one again where there are fewer: what is not asked for costs no directions of its own.
            let at = voxels[i.min(voxels.len() - 1)];
            let gradient: [f64; 3] = match self.gradients {
                Gradients::CentralDifferences => gradient_at_sample(lattice, at),
                other => other.at(self.volume, at.map(|x| x as f64)),
            };
            let value = calibration.value(f64::from(lattice.at::<f32>(at[0], at[1], at[2])));
            let row = self.optics.of_voxel(value, world_gradient(self.volume, gradient).length());
            let towards = self.view.towards(placement.to_world(DVec3::from_array(at.map(|x| x as f64))));
            for a in 0..3 {
                gradients[a].0[i] = gradient[a] as f32;
                directions[a][i] = towards[a];
            }
            for c in 0..4 {
                rows[c].0[i] = row[c] as f32;
            }
        }
        if self.optics.reflects {
            lights.look_along(&self.packet.lights, &directions);
            let shade = Shade { shading: self.packet, lights };
            run(self.level, Reflect { shade, gradients: &gradients, rows: &mut rows });
        }
        (0..voxels.len()).map(|i| std::array::from_fn(|c| rows[c].0[i])).collect()
    }
}

/// Shades (q, κ) of sixteen voxels as light and opacity are: q becomes q·factor + κ·added.
struct Reflect<'a> {
    shade: Shade<'a>,
    gradients: &'a [Lanes; 3],
    rows: &'a mut [Lanes; 4],
}

impl Vectorized for Reflect<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.shade.apply_to_gradients(simd, self.gradients, self.rows);
    }
}
