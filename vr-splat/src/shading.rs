//! Gradients' part in what is classified sheet by sheet: light that is reflected, and opacity that follows their magnitude.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use glam::{DMat3, DVec3};
use vr_core::{Calibration, GridVolume, PointSet, Scene};
use vr_kernels::vector::{LANES, Lanes, Modulation, PacketLights, PacketShading, Shade, StepOptics, splat};

use crate::gradient_optics::GradientOptics;
use crate::grid_gradients::GridGradients;
use crate::input::SplatInput;
use crate::point_gradients::PointGradient;
use crate::projection::SplatView;
use crate::splatter::Splatter;

/// The scene's optics by gradients, and the source of the gradients.
pub(crate) struct Shader<'a> {
    optics: GradientOptics<'a>,
    pub(crate) packet: PacketShading,
    source: Source<'a>,
    /// From stored numbers, as they are splatted, to values.
    calibration: Calibration,
}

/// Sources of gradients.
enum Source<'a> {
    /// A grid, in which they are looked up.
    Grid(GridGradients<'a>),
    /// Points whose kernels have this gradient, which is summed sheet by sheet, and the world length of the unit that sums are per.
    Points(PointGradient, f64),
}

/// Homogeneous pieces of sixteen rays.
pub(crate) struct Pieces {
    pub(crate) slope: Slope,
    /// Stored numbers, as they are splatted.
    pub(crate) value: Lanes,
    /// World lengths.
    pub(crate) length: Lanes,
    /// The table's rows of the values, and lengths in its unit; `None` where they were classified one by one, or opacity is what it is.
    pub(crate) optics: Option<StepOptics>,
    /// Colours of their places, by which light is multiplied before it reflects, where voxels or points have any.
    pub(crate) tint: Option<[Lanes; 3]>,
}

impl Pieces {
    /// Multiplies light by the colours of places.
    #[inline(always)]
    fn tint<S: Simd>(&self, simd: S, light: &mut [Lanes; 4]) {
        if let Some(tint) = &self.tint {
            for c in 0..3 {
                light[c] = Lanes::new(light[c].load(simd) * tint[c].load(simd));
            }
        }
    }
}

/// Gradients of pieces.
pub(crate) enum Slope {
    /// Those of a grid at these places in index space.
    At([Lanes; 3]),
    /// These, along the view's axes and per unit of the view.
    Known([Lanes; 3]),
}

impl<'a> Shader<'a> {
    /// Shader of a scene whose light depends on gradients.
    pub(crate) fn new(
        renderer: &Splatter,
        scene: &'a Scene,
        input: &'a SplatInput,
        calibration: Calibration,
        view: &SplatView,
    ) -> Option<Self> {
        let optics = GradientOptics::new(scene)?;
        let (packet, source) = match input {
            SplatInput::Grid(grid) => {
                let gradients = GridGradients::new(&optics.shading, renderer, grid);
                (grid_shading(&optics, scene, grid), Source::Grid(gradients))
            }
            SplatInput::Points(points) => (
                packet_shading(&optics, scene, view.frame, 1.0 / view.unit),
                Source::Points(PointGradient::new(points.kernel()), view.unit),
            ),
        };
        Some(Self { optics, packet, source, calibration })
    }

    /// True if opacity follows the gradient.
    pub(crate) fn follows(&self) -> bool {
        self.optics.follows
    }

    /// The gradient of points' kernels, where that is summed; `None` of a grid.
    pub(crate) fn summed(&self) -> Option<PointGradient> {
        match self.source {
            Source::Points(gradient, _) => Some(gradient),
            Source::Grid(_) => None,
        }
    }

    /// Shades light and opacity of pieces that were classified by their values alone.
    #[inline(always)]
    pub(crate) fn shade<S: Simd>(&self, simd: S, lights: &PacketLights, pieces: &Pieces, light: &mut [Lanes; 4]) {
        let shade = Shade { shading: &self.packet, lights };
        let modulated = pieces.optics.as_ref().filter(|_| self.optics.follows && self.packet.modulation.is_some());
        // Vectors know factors on the extinction, and central differences.
        let vectors = !self.optics.follows || modulated.is_some();
        match (&self.source, &pieces.slope) {
            (Source::Grid(grid), Slope::At(place)) if vectors && grid.are_central_differences() => {
                if light[3].load(simd).simd_gt(splat(simd, 0.0)).any_true() {
                    grid.shade(simd, shade, place, modulated, light, |light| pieces.tint(simd, light));
                } else {
                    pieces.tint(simd, light);
                }
            }
            (_, Slope::Known(gradient)) if vectors => {
                let still = [Lanes::ZERO; 3];
                shade.apply_by(simd, &[*gradient, still], modulated, light, |light| pieces.tint(simd, light));
            }
            _ => {
                let gradient = self.one_by_one(pieces, light);
                pieces.tint(simd, light);
                if self.optics.reflects {
                    shade.apply_to_gradients(simd, &gradient, light);
                }
            }
        }
    }

    /// Makes the light of pieces whose opacity follows the gradient anew, before it reflects; returns the gradients in the packet's space.
    #[inline(never)]
    fn one_by_one(&self, pieces: &Pieces, light: &mut [Lanes; 4]) -> [Lanes; 3] {
        let mut gradients = [Lanes::ZERO; 3];
        for i in 0..LANES {
            // Where the value alone is clear, every gradient is.
            if (0..4).all(|c| light[c].0[i] == 0.0) {
                continue;
            }
            let (gradient, magnitude) = self.of_lane(&pieces.slope, i);
            for a in 0..3 {
                gradients[a].0[i] = gradient[a] as f32;
            }
            if self.optics.follows {
                let value = self.calibration.value(f64::from(pieces.value.0[i]));
                let step = self.optics.step(value, magnitude, f64::from(pieces.length.0[i]));
                for c in 0..4 {
                    light[c].0[i] = step[c] as f32;
                }
            }
        }
        gradients
    }

    /// The gradient of one of the lanes in the packet's space, and its magnitude in value per world unit.
    fn of_lane(&self, slope: &Slope, lane: usize) -> ([f64; 3], f64) {
        match (&self.source, slope) {
            (Source::Grid(grid), Slope::At(place)) => {
                let gradient = grid.of_lane(place, lane);
                (gradient, grid.magnitude(gradient))
            }
            (Source::Points(_, unit), Slope::Known(known)) => {
                let gradient = [0, 1, 2].map(|a| f64::from(known[a].0[lane]));
                (gradient, DVec3::from(gradient).length() / unit)
            }
            _ => unreachable!("gradients of grids are looked up, and those of points are known"),
        }
    }
}

/// Shading in the form that vectors take, for gradients that a matrix turns to the world, but for a factor `scale` on their magnitude.
fn packet_shading(optics: &GradientOptics<'_>, scene: &Scene, to_world: DMat3, scale: f64) -> PacketShading {
    PacketShading {
        shading: optics.shading.clone(),
        lights: scene.lights.clone(),
        to_world: std::array::from_fn(|a| to_world.row(a).to_array().map(|x| x as f32)),
        modulation: Modulation::new(&optics.shading, scale),
        // Mixtures are made one by one.
        rows: None,
        reflects: optics.reflects,
    }
}

/// Shading for gradients per index step of a grid in stored units.
pub(crate) fn grid_shading(optics: &GradientOptics<'_>, scene: &Scene, volume: &GridVolume) -> PacketShading {
    let (matrix, scale) = volume.placement().scaled_gradient_matrix(volume.calibration().slope);
    packet_shading(optics, scene, matrix, scale)
}

/// Shading for gradients of points per half their mean radius, along the world's axes.
pub(crate) fn point_shading(optics: &GradientOptics<'_>, scene: &Scene, points: &PointSet) -> PacketShading {
    packet_shading(optics, scene, DMat3::IDENTITY, 1.0 / points.mean_spacing())
}
