//! What one scene's transfer function and shading do to a field along one ray.

use vr_core::{OpacityRule, RayShading, Shading, TransferFunction};

/// Transfer function and shading as one ray meets them.
pub struct Optics<'a> {
    /// From value to extinction and emission.
    pub transfer: &'a TransferFunction,
    /// The shading, and what of it is constant along the ray.
    pub shading: Option<(&'a Shading, RayShading<f64>)>,
    /// Values at which the transfer function has a kink.
    pub(crate) kinks: Vec<f64>,
    /// Values at which it jumps.
    pub(crate) jumps: Vec<f64>,
}

impl<'a> Optics<'a> {
    /// For a ray whose shading is constant along it: see [`Shading::along`].
    pub fn new(transfer: &'a TransferFunction, shading: Option<(&'a Shading, RayShading<f64>)>) -> Self {
        let (mut kinks, mut jumps) = (Vec::new(), Vec::new());
        for pair in transfer.segments().windows(2) {
            if pair[0].end == pair[1].start { &mut kinks } else { &mut jumps }.push(pair[1].from);
        }
        Self { transfer, shading, kinks, jumps }
    }

    /// Largest light that a wall, or an infinitely deep medium, can send: the brightest colour, shaded as bright as can be.
    pub(crate) fn brightest_surface(&self) -> f64 {
        if self.transfer.has_emission() {
            return 0.0;
        }
        let color = self.transfer.brightest_color();
        match &self.shading {
            None => color,
            Some((s, _)) => {
                let light: f64 = s.lights.iter().map(|l| l.color.into_iter().fold(0.0, f64::max)).sum();
                (color * (s.ambient + s.diffuse * light) + s.specular * light).max(color)
            }
        }
    }

    /// Largest emission per world unit, where it is given on its own.
    pub(crate) fn brightest_emission(&self) -> f64 {
        self.transfer.brightest_emission()
    }

    /// Whether opacity 1 is a wall here.
    pub(crate) fn has_walls(&self) -> bool {
        self.transfer.rule() == OpacityRule::Power
    }
}
