//! Light of voxels or points that are classified before they are splatted, where it depends on their gradients.

use fearless_simd::{Level, Simd};
use glam::DVec3;
use vr_kernels::vector::{LANES, Lanes, PacketLights, PacketShading, Shade, Vectorized, run};

use crate::gradient_optics::GradientOptics;
use crate::sight::Sight;

/// A voxel or point, as its light depends on it.
pub(crate) struct LitSample {
    pub(crate) value: f64,
    /// In the space of the packet's shading.
    pub(crate) gradient: [f64; 3],
    /// Length of the gradient, in value per world unit.
    pub(crate) magnitude: f64,
    /// In the world.
    pub(crate) place: DVec3,
    /// Colour of its own, by which its light is multiplied before it reflects.
    pub(crate) tint: [f64; 3],
}

/// Optics, lights and the eye, for samples that are classified themselves.
pub(crate) struct SampleShader<'a> {
    pub(crate) optics: &'a GradientOptics<'a>,
    pub(crate) packet: PacketShading,
    pub(crate) sight: Sight,
    pub(crate) level: Level,
}

impl SampleShader<'_> {
    /// (q, κ) of up to sixteen samples per world unit: shaded, and with the opacity that its gradient leaves each.
    pub(crate) fn rows(&self, samples: &[LitSample], lights: &mut PacketLights) -> Vec<[f32; 4]> {
        let (mut gradients, mut rows, mut directions) = ([Lanes::ZERO; 3], [Lanes::ZERO; 4], [[0.0; LANES]; 3]);
        for i in 0..LANES {
            // The last one again where there are fewer: what is not asked for costs no directions of its own.
            let sample = &samples[i.min(samples.len() - 1)];
            let row = tinted(self.optics.of_voxel(sample.value, sample.magnitude), sample.tint);
            let towards = self.sight.towards(sample.place);
            for a in 0..3 {
                gradients[a].0[i] = sample.gradient[a] as f32;
                directions[a][i] = towards[a];
            }
            for c in 0..4 {
                rows[c].0[i] = row[c] as f32;
            }
        }
        if self.optics.reflects {
            lights.look_along(&self.packet.lights, &directions);
            let shade = Shade { shading: &self.packet, lights };
            run(self.level, Reflect { shade, gradients: &gradients, rows: &mut rows });
        }
        (0..samples.len()).map(|i| std::array::from_fn(|c| rows[c].0[i])).collect()
    }
}

/// (q, κ) of a sample in a colour.
pub(crate) fn tinted([r, g, b, kappa]: [f64; 4], [x, y, z]: [f64; 3]) -> [f64; 4] {
    [r * x, g * y, b * z, kappa]
}

/// Shades (q, κ) of sixteen samples as light and opacity are: q becomes q·factor + κ·added.
struct Reflect<'a> {
    shade: Shade<'a>,
    gradients: &'a [Lanes; 3],
    rows: &'a mut [Lanes; 4],
}

impl Vectorized for Reflect<'_> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        self.shade.apply_to_gradients(simd, self.gradients, self.rows);
    }
}
