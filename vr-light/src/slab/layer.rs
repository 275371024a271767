//! Slabs and their layers.

use vr_core::ParameterError;
use vr_core::scattering::PhaseFunction;

/// Largest optical thickness of a slab.
pub(super) const MAX_THICKNESS: f64 = 1e6;
/// Largest radiance or flux, as in scenes.
pub(super) const MAX_LIGHT: f64 = 1e6;
/// Largest number of layers.
const MAX_LAYERS: usize = 1000;

/// A homogeneous layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Optical thickness: extinction times geometric thickness.
    pub thickness: f64,
    /// Share of the extinction that is scattering.
    pub albedo: f64,
    /// Directions in which scattered light leaves.
    pub phase: PhaseFunction,
    /// Radiance with which the medium is in equilibrium: it emits 1 − albedo times this per optical thickness, by Kirchhoff's law.
    pub source: f64,
}

impl Layer {
    /// A layer that emits nothing.
    pub fn new(thickness: f64, albedo: f64, phase: PhaseFunction) -> Self {
        Self { thickness, albedo, phase, source: 0.0 }
    }
}

/// Surface beneath a slab, which reflects by Lambert's law. The default is black: nothing comes back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ground {
    /// Share of the flux that is reflected.
    pub albedo: f64,
    /// Radiance that it emits itself.
    pub emission: f64,
}

/// Layers, the first on top, over a ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Slab {
    layers: Vec<Layer>,
    ground: Ground,
}

impl Slab {
    /// Layers over a black ground.
    ///
    /// # Errors
    /// A thickness that is negative, or above 10⁶ altogether; an albedo outside of 0 to 1; a source that is negative or above 10⁶; more than 1000
    /// layers.
    pub fn new(layers: Vec<Layer>) -> Result<Self, ParameterError> {
        if layers.len() > MAX_LAYERS {
            return Err(ParameterError::new("slab.layers", layers.len(), "must be 1000 layers at most"));
        }
        let mut total = 0.0;
        for (i, layer) in layers.iter().enumerate() {
            let wrong = |key: &str, found: f64, allowed| {
                Err(ParameterError::new(format!("slab.layers[{i}].{key}"), found, allowed))
            };
            total += layer.thickness;
            if layer.thickness.is_nan() || layer.thickness < 0.0 || total > MAX_THICKNESS {
                return wrong("thickness", layer.thickness, "must not be negative, and all together 1e6 at most");
            }
            if !(0.0..=1.0).contains(&layer.albedo) {
                return wrong("albedo", layer.albedo, "must be 0 to 1");
            }
            if !(0.0..=MAX_LIGHT).contains(&layer.source) {
                return wrong("source", layer.source, "must be 0 to 1e6");
            }
        }
        Ok(Self { layers, ground: Ground::default() })
    }

    /// The slab over this ground.
    ///
    /// # Errors
    /// An albedo outside of 0 to 1, an emission that is negative or above 10⁶.
    pub fn with_ground(self, ground: Ground) -> Result<Self, ParameterError> {
        if !(0.0..=1.0).contains(&ground.albedo) {
            return Err(ParameterError::new("slab.ground.albedo", ground.albedo, "must be 0 to 1"));
        }
        if !(0.0..=MAX_LIGHT).contains(&ground.emission) {
            return Err(ParameterError::new("slab.ground.emission", ground.emission, "must be 0 to 1e6"));
        }
        Ok(Self { ground, ..self })
    }

    /// The layers, the first on top.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The surface beneath.
    pub fn ground(&self) -> Ground {
        self.ground
    }

    /// Optical thickness of all layers.
    pub fn thickness(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness).sum()
    }

    /// Largest radiance that the layers or the ground would have in equilibrium.
    pub(super) fn max_source(&self) -> f64 {
        self.layers.iter().map(|layer| layer.source).fold(self.ground.emission, f64::max)
    }
}
