//! World distances along the rays of pixels, and depths of slices.

use glam::{DVec2, DVec3};

use crate::factorization::{Factorization, IndexView};

/// Conversion between world distances along rays, from where they start, and depths: positions on the principal axis that grow from front to back.
pub(crate) struct RayDistances<'a> {
    view: &'a IndexView,
    factorization: &'a Factorization,
    /// Depth at which a ray starts, as a linear function of (x, y, 1) of the screen.
    start: DVec3,
    /// World length of a voxel along the principal axis, of parallel rays.
    parallel: Option<f64>,
}

impl<'a> RayDistances<'a> {
    pub(crate) fn new(view: &'a IndexView, factorization: &'a Factorization) -> Self {
        let start = factorization.sign * view.origins().transpose().col(factorization.axes[2]);
        let parallel = (!view.is_perspective()).then(|| view.world_length(factorization.step(0.0, 0.0)));
        Self { view, factorization, start, parallel }
    }

    /// World distance at which the ray through a point of the screen, which is a texel of the image, reaches a depth.
    #[inline(always)]
    pub(crate) fn distance(&self, screen: DVec2, texel: DVec2, depth: f64) -> f64 {
        (depth - self.start_of(screen)) * self.length(texel)
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
        self.parallel.unwrap_or_else(|| self.view.world_length(self.factorization.step(texel.x, texel.y)))
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{Camera, Placement, Projection, Rays, View};

    use super::*;
    use crate::passes::passes;

    #[test]
    fn distances_are_those_of_the_rays_of_vr_core() {
        let placement = Placement::from_spacing([1.0, 1.5, 0.7]).unwrap();
        let last = DVec3::new(40.0, 30.0, 90.0);
        for projection in [Projection::Orthographic { height: 70.0 }, Projection::Perspective { fov: 80.0 }] {
            let (eye, target) = (DVec3::new(90.0, 35.0, 60.0), DVec3::new(10.0, 20.0, 30.0));
            let view = View::new(Camera { eye, target, up: DVec3::Y, projection }, [64, 48]);
            let (index, rays) = (IndexView::new(&view, &placement).unwrap(), Rays::new(&view).unwrap());
            for pass in passes(&index, [DVec3::ZERO, last], last, 0.5).unwrap() {
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
