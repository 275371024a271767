//! World distances along the rays of pixels, and depths of slices.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8};
use glam::{DVec2, DVec3};

use crate::factorization::{Factorization, IndexView};

/// Conversion between world distances along rays, from where they start, and depths: positions on the principal axis that grow from front to back.
pub(crate) struct RayDistances {
    /// Depth at which a ray starts, as a linear function of (x, y, 1) of the screen.
    start: DVec3,
    /// World vector of a voxel along the principal axis on the ray of texel (0, 0), and its change from a texel to the next one to the right, and to
    /// the one below.
    steps: [DVec3; 3],
    /// Length of that vector, of parallel rays.
    parallel: Option<f64>,
}

impl RayDistances {
    pub(crate) fn new(view: &IndexView, factorization: &Factorization) -> Self {
        let start = factorization.sign * view.origins().transpose().col(factorization.axes[2]);
        let step = |x: f64, y: f64| view.world_vector(factorization.step(x, y));
        let first = step(0.0, 0.0);
        let parallel = (!view.is_perspective()).then(|| first.length());
        Self { start, steps: [first, step(1.0, 0.0) - first, step(0.0, 1.0) - first], parallel }
    }

    /// World distance at which the ray through a point of the screen, which is a texel of the image, reaches a depth.
    #[inline(always)]
    pub(crate) fn distance(&self, screen: DVec2, texel: DVec2, depth: f64) -> f64 {
        (depth - self.start_of(screen)) * self.length(texel)
    }

    /// The same of sixteen neighbouring points of a row of the screen, the first of which is given.
    #[inline(always)]
    pub(crate) fn distances<S: Simd>(
        &self,
        simd: S,
        screen: DVec2,
        [x, y]: [[f64x8<S>; 2]; 2],
        depths: f32x16<S>,
    ) -> f32x16<S> {
        let columns = f64x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (low, high) = depths.widen();
        let start = columns * self.start.x + self.start_of(screen);
        let (low, high) = (low - start, high - (start + 8.0 * self.start.x));
        (low * self.lengths(simd, x[0], y[0])).narrow(high * self.lengths(simd, x[1], y[1]))
    }

    /// World lengths of a voxel along the principal axis on the rays of eight texels.
    #[inline(always)]
    fn lengths<S: Simd>(&self, simd: S, x: f64x8<S>, y: f64x8<S>) -> f64x8<S> {
        if let Some(length) = self.parallel {
            return f64x8::splat(simd, length);
        }
        let [first, right, down] = self.steps;
        let mut square = f64x8::splat(simd, 0.0);
        for a in 0..3 {
            let component = x * right[a] + y * down[a] + first[a];
            square += component * component;
        }
        square.sqrt()
    }

    /// Depth at a world distance along the ray.
    pub(crate) fn depth(&self, screen: DVec2, texel: DVec2, distance: f64) -> f64 {
        self.start_of(screen) + distance / self.length(texel)
    }

    #[inline(always)]
    fn start_of(&self, screen: DVec2) -> f64 {
        self.start.x * screen.x + self.start.y * screen.y + self.start.z
    }

    /// World length of a voxel along the principal axis.
    #[inline(always)]
    fn length(&self, texel: DVec2) -> f64 {
        let [first, right, down] = self.steps;
        self.parallel.unwrap_or_else(|| (first + texel.x * right + texel.y * down).length())
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{Camera, Placement, Projection, Rays, View};

    use super::*;
    use crate::passes::{TexelLattice, passes};

    #[test]
    fn distances_are_those_of_the_rays_of_vr_core() {
        let placement = Placement::from_spacing([1.0, 1.5, 0.7]).unwrap();
        let last = DVec3::new(40.0, 30.0, 90.0);
        for projection in [Projection::Orthographic { height: 70.0 }, Projection::Perspective { fov: 80.0 }] {
            let (eye, target) = (DVec3::new(90.0, 35.0, 60.0), DVec3::new(10.0, 20.0, 30.0));
            let view = View::new(Camera { eye, target, up: DVec3::Y, projection }, [64, 48]);
            let (index, rays) = (IndexView::new(&view, &placement).unwrap(), Rays::new(&view).unwrap());
            for pass in passes(&index, [DVec3::ZERO, last], last, TexelLattice { texel: 0.5, nearest: false }).unwrap()
            {
                let f = &pass.factorization;
                let distances = RayDistances::new(&index, f);
                for screen in [DVec2::new(0.5, 0.5), DVec2::new(31.0, 20.25), DVec2::new(63.5, 40.0)] {
                    let texel = f.texels_of_screen() * screen.extend(1.0);
                    if texel.z <= 0.0 {
                        continue;
                    }
                    let texel = texel.truncate() / texel.z;
                    let ray = rays.at(screen.x, screen.y);
                    let at = placement.to_index(ray.origin + 33.0 * ray.direction);
                    let depth = distances.depth(screen, texel, 33.0);
                    assert!((depth - f.sign * at[f.axes[2]]).abs() < 1e-10, "{depth} {at}");
                    assert!((distances.distance(screen, texel, depth) - 33.0).abs() < 1e-10);
                }
            }
        }
    }
}
