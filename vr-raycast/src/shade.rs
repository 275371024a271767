//! Shading of classified samples.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{GradientMethod, Light, Placement, RayShading, Real, Shading, TransferFunction};
use vr_kernels::vector::{Modulation, OpticsTable, PacketShading, RowMixture};

use crate::chord::Chord;
use crate::classify::Classifier;

use crate::ray_value::RayValue;
use crate::run::Run;

/// Shading in the form that kernels use, the same for all rays.
#[derive(Clone, Debug)]
pub(crate) struct Shader<R> {
    shading: Arc<Shading>,
    lights: Vec<Light>,
    /// Matrix from gradients per index step, in stored units, to world gradients divided by `scale`.
    to_world: [[R; 3]; 3],
    /// Power of two of [`Placement::scaled_gradient_matrix`].
    scale: f64,
}

impl<R: Real> Shader<R> {
    pub(crate) fn new(shading: Arc<Shading>, lights: Vec<Light>, placement: &Placement, slope: f64) -> Self {
        let (matrix, scale) = placement.scaled_gradient_matrix(slope);
        let row = |a: usize| matrix.row(a).to_array().map(R::from_f64);
        Self { shading, lights, to_world: [row(0), row(1), row(2)], scale }
    }

    /// Returns the part of the shading that is constant along a ray of this direction.
    pub(crate) fn along(&self, direction: DVec3) -> RayShading<R> {
        self.shading.along(&self.lights, direction)
    }

    /// Returns the part that the vector engine needs, of a scene whose colours reflect or not; `None` if that is nothing. `tables`: those of the rows of its
    /// transfer function, if it has any.
    pub(crate) fn for_packets(
        &self,
        transfer: &TransferFunction,
        tables: Arc<[OpticsTable]>,
        reflects: bool,
    ) -> Option<PacketShading> {
        let shading = PacketShading {
            shading: Arc::clone(&self.shading),
            lights: self.lights.clone(),
            to_world: self.to_world.map(|row| row.map(|x| x.to_f64() as f32)),
            modulation: Modulation::new(&self.shading, self.scale),
            rows: RowMixture::new(transfer, tables, self.scale),
            reflects,
        };
        (reflects || shading.follows_gradients()).then_some(shading)
    }

    fn method(&self) -> GradientMethod {
        self.shading.gradient
    }

    fn world(&self, gradient: [R; 3]) -> [R; 3] {
        self.to_world.map(|row| row[0] * gradient[0] + row[1] * gradient[1] + row[2] * gradient[2])
    }

    fn magnitude(&self, world: [R; 3]) -> f64 {
        let [x, y, z] = world.map(R::to_f64);
        self.scale * (x * x + y * y + z * z).sqrt()
    }

    /// Shades a classified run: opacity (and by rows of the transfer function all of the light) by the gradient's magnitude first, then the
    /// colours of the places, then reflection.
    pub(crate) fn shade(
        &self,
        lights: &RayShading<R>,
        chord: &Chord<'_>,
        run: &mut Run<R>,
        classifier: &Classifier<R>,
    ) {
        let has_rows = classifier.transfer.has_rows();
        let modulates = !self.shading.gradient_opacity.is_empty();
        // Emission given on its own is light, not a surface.
        let reflects = !(classifier.transfer.has_emission() || has_rows && self.shading.is_flat());
        // Where nothing absorbs, there is no gradient to look at, unless it chooses what is emitted.
        let is_clear = |light: &[R; 4]| light[3] == R::ZERO && !(has_rows && *light != [R::ZERO; 4]);
        if !(modulates || reflects || has_rows) || run.light[..run.len()].iter().all(is_clear) {
            chord.tint(run);
            return;
        }
        chord.gradients(run, self.method());
        for j in 0..run.len() {
            if is_clear(&run.light[j]) {
                chord.tint_step(run, j);
                continue;
            }
            let world = self.world(run.gradient[j]);
            if modulates {
                let factor = self.shading.modulation(self.magnitude(world));
                run.light[j] = classifier.with_extinction_times(run, j, factor);
            }
            if has_rows {
                run.light[j] = classifier.by_rows(run, j, self.magnitude(world));
            }
            chord.tint_step(run, j);
            if reflects {
                let [r, g, b, alpha] = run.light[j];
                let (factor, added) = lights.reflect_turning(world, self.world(run.turn[j]), alpha);
                let lit = |light: R, c: usize| light * factor[c] + added[c] * alpha;
                run.light[j] = [lit(r, 0), lit(g, 1), lit(b, 2), alpha];
            }
        }
    }

    /// Shades the surface that a ray met.
    pub(crate) fn shade_surface(
        &self,
        lights: &RayShading<R>,
        chord: &Chord<'_>,
        run: &mut Run<R>,
        value: &mut RayValue,
    ) {
        chord.place_point(run, value.depth - chord.ray.offset);
        run.light[0] = [R::ONE; 4];
        chord.gradients(run, self.method());
        self.reflect_by(lights, run.gradient[0], value);
    }

    /// Shades a surface by its gradient per index step.
    pub(crate) fn reflect_by(&self, lights: &RayShading<R>, gradient: [R; 3], value: &mut RayValue) {
        let (factor, added) = lights.reflect(self.world(gradient));
        for c in 0..3 {
            value.rgba[c] = value.rgba[c] * factor[c].to_f64() + added[c].to_f64();
        }
    }
}
