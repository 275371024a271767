//! A scene: a volume with its optics, lights and surfaces.

use std::sync::Arc;

use glam::DVec3;

use crate::compositing::Compositing;
use crate::control::Control;
use crate::error::{ParameterError, RenderError};
use crate::field::Field;
use crate::scattering::Scattering;
use crate::shading::{Light, Shading};
use crate::surfaces::{Layer, Surfaces};
use crate::transfer::TransferFunction;
use crate::unsupported::{Feature, Unsupported};
use crate::view::View;
use crate::volume::Volume;

/// A volume with its optics, lights and surfaces. Cheap to clone: volume, transfer function, shading and surfaces are shared.
///
/// # Examples
/// ```
/// use std::sync::Arc;
/// use vr_core::phantom::{self, Phantom};
/// use vr_core::{Compositing, Scene, Shading};
///
/// let mut scene: Scene = phantom::by_name("hydrogen").unwrap().scene(5)?;
/// assert!(scene.reflection().is_none());
/// scene.shading = Some(Arc::new(Shading::default()));
/// assert!(scene.reflection().is_some());
/// scene.compositing = Compositing::Maximum;
/// assert!(scene.reflection().is_none(), "a picked value is not shaded");
/// scene.background = [f32::NAN; 3];
/// assert_eq!(scene.validate().unwrap_err().field, "image.background");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// The volume, and with a grid the filter that makes its field.
    pub volume: Volume,
    /// Map from value to extinction and emission.
    pub transfer: Arc<TransferFunction>,
    /// Reflection of light by surfaces in the volume; `None`: unshaded.
    pub shading: Option<Arc<Shading>>,
    /// Lights of the volume, where it is shaded, and of the surfaces.
    pub lights: Vec<Light>,
    /// Scattering of light in the medium; `None`: it absorbs and emits alone. Lights shine into a medium that scatters, with shadows.
    pub scattering: Option<Arc<Scattering>>,
    /// Opaque things among the volume.
    pub surfaces: Option<Arc<dyn Surfaces>>,
    /// Operator that makes a pixel of the field along a ray.
    pub compositing: Compositing,
    /// Linear radiance that comes in behind everything. Not part of a frame: added when a PNG is written.
    pub background: [f32; 3],
}

/// Largest radiance that can come from behind a point of a ray: where little enough of it gets through, the ray may end.
///
/// # Examples
/// ```
/// use vr_core::MaxRadiance;
///
/// // Emission adds up along a ray; light of a medium that absorbs as much as it emits does not.
/// assert_eq!(MaxRadiance::Emission(3.0).over(2.0), 6.0);
/// assert_eq!(MaxRadiance::Color(3.0).over(2.0), 3.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaxRadiance {
    /// Radiance of a medium of colours, shaded or not, however long it is.
    Color(f64),
    /// Emission given on its own, per world unit.
    Emission(f64),
}

impl MaxRadiance {
    /// Largest component, opacity 1 among them, that a stretch of so many world units can add.
    #[inline]
    pub fn over(self, length: f64) -> f64 {
        match self {
            Self::Color(radiance) => radiance.max(1.0),
            Self::Emission(emission) => (emission * length).max(1.0),
        }
    }
}

impl Scene {
    /// An unshaded scene under emission and absorption, before black, with a headlight for shading and surfaces that the caller may add.
    pub fn new(volume: Volume, transfer: TransferFunction) -> Self {
        Self {
            volume,
            transfer: Arc::new(transfer),
            shading: None,
            lights: vec![Light::default()],
            scattering: None,
            surfaces: None,
            compositing: Compositing::default(),
            background: [0.0; 3],
        }
    }

    /// Shading by which colours reflect light, `None` where nothing does: without shading, where a value is picked, and where emission is given
    /// on its own, which is light and no surface. The surface of [`Compositing::First`] always reflects.
    pub fn reflection(&self) -> Option<&Arc<Shading>> {
        let reflects = match self.compositing {
            Compositing::First { .. } => true,
            other => other.integrates_light() && !self.transfer.has_emission(),
        };
        self.shading.as_ref().filter(|_| reflects)
    }

    /// Largest radiance that any stretch of the medium can send.
    pub fn max_radiance(&self) -> MaxRadiance {
        if self.transfer.has_emission() {
            return MaxRadiance::Emission(self.transfer.brightest_emission());
        }
        let color = self.transfer.brightest_color();
        MaxRadiance::Color(self.reflection().map_or(color, |shading| shading.max_radiance(&self.lights, color)))
    }

    /// True if opacity follows the gradient's magnitude, by a factor or by the rows of the transfer function, whether or not colours reflect.
    pub fn has_gradient_opacity(&self) -> bool {
        let modulates = self.shading.as_ref().is_some_and(|s| !s.gradient_opacity.is_empty());
        (modulates || self.transfer.has_rows()) && self.compositing.integrates_light()
    }

    /// Shading by which gradients are found and looked at: the scene's own, or, where the rows of a transfer function need gradients without it, one
    /// that leaves colours as they are.
    pub fn gradient_shading(&self) -> Option<Arc<Shading>> {
        let flat = || self.transfer.has_rows().then(|| Arc::new(Shading::flat()));
        self.shading.clone().or_else(flat)
    }

    /// Checks the numbers that the parts do not check when they are made.
    ///
    /// # Errors
    /// A [`ParameterError`] naming the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.compositing.validate()?;
        if !self.compositing.integrates_light() && self.volume.field().is_some_and(Field::values_are_codes) {
            let allowed = "volumes with labels in colours of their own have no values to compare: over or accumulate; or show them as the volume";
            return Err(ParameterError::new("render.compositing", self.compositing.name(), allowed));
        }
        if self.background.iter().any(|&c| !(c >= 0.0 && c.is_finite())) {
            let allowed = "must be finite and not negative";
            return Err(ParameterError::new("image.background", self.background, allowed));
        }
        if self.transfer.has_rows() {
            self.validate_rows()?;
        }
        Light::validate_all(&self.lights)?;
        if let Some(scattering) = &self.scattering {
            self.validate_scattering(scattering)?;
        }
        self.shading.as_ref().map_or(Ok(()), |s| s.validate())
    }

    /// Checks what goes with the rows of a two-dimensional transfer function.
    fn validate_rows(&self) -> Result<(), ParameterError> {
        if !self.compositing.integrates_light() {
            let allowed = "a transfer function with rows by gradient goes with over and accumulate: a picked or averaged value has no gradient to choose a row";
            return Err(ParameterError::new("render.compositing", self.compositing.name(), allowed));
        }
        if let Some(shading) = self.shading.as_ref().filter(|s| !s.gradient_opacity.is_empty()) {
            let allowed = "must be absent beside rows by gradient: those hold the opacity at every magnitude";
            return Err(ParameterError::new("shading.gradient_opacity", &shading.gradient_opacity, allowed));
        }
        Ok(())
    }

    /// Checks scattering, and what goes with it.
    fn validate_scattering(&self, scattering: &Scattering) -> Result<(), ParameterError> {
        scattering.validate()?;
        if !self.compositing.integrates_light() {
            let allowed =
                "a medium that scatters goes with over and accumulate: a picked or averaged value is no light";
            return Err(ParameterError::new("render.compositing", self.compositing.name(), allowed));
        }
        if self.shading.is_some() {
            let allowed = "must be absent beside shading: that imitates the light which scattering computes";
            return Err(ParameterError::new("scattering", "shading", allowed));
        }
        Ok(())
    }

    /// Refuses a medium that scatters, for renderers of emission and absorption.
    ///
    /// # Errors
    /// [`Unsupported`] with [`Feature::Scattering`].
    pub fn without_scattering(&self, renderer: &'static str) -> Result<(), Unsupported> {
        let what = "scattering: it draws emission and absorption alone";
        match self.scattering {
            None => Ok(()),
            Some(_) => Err(Unsupported { renderer, feature: Feature::Scattering, what: what.into() }),
        }
    }

    /// Draws the scene's surfaces as they are seen in a view; `None` where it has none.
    ///
    /// # Errors
    /// Same as for [`View::validate`] and [`Surfaces::layer`]; also an error if the layer does not have one entry per pixel.
    pub fn layer(&self, view: &View, control: &Control) -> Result<Option<Layer>, RenderError> {
        view.validate()?;
        let Some(surfaces) = &self.surfaces else { return Ok(None) };
        let layer = surfaces.layer(&self.lights, view, control)?;
        if layer.pixels.len() as u64 != u64::from(view.size[0]) * u64::from(view.size[1]) {
            let allowed = "the layer of a scene's surfaces must have one entry per pixel of the picture";
            return Err(ParameterError::new("surfaces", layer.pixels.len(), allowed).into());
        }
        Ok(Some(layer))
    }

    /// Lower and upper corner of the world box around all that there is to see: the volume, and the surfaces where there are any.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (low, high) = self.volume.bounds();
        let (other_low, other_high) = self.surfaces.as_ref().map_or((low, high), |s| s.bounds());
        (low.min(other_low), high.max(other_high))
    }

    /// True if both have the same surfaces, in memory.
    pub fn has_surfaces_of(&self, other: &Self) -> bool {
        match (&self.surfaces, &other.surfaces) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// The same scene with its volume under another filter; see [`Volume::with_filter`].
    #[must_use]
    pub fn with_filter(&self, filter: crate::Filter) -> Self {
        Self { volume: self.volume.with_filter(filter), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{ControlPoint, OpacityRule};
    use crate::{Calibration, Placement, UniformGrid};

    #[test]
    fn surfaces_and_integrated_colours_reflect() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([2; 3], vec![0u8; 8], placement, Calibration::default()).unwrap();
        let first = Compositing::First { threshold: 0.0 };
        for emission in [None, Some([1.0; 3])] {
            let point = ControlPoint { emission, ..ControlPoint::new(0.0, [1.0; 3], 0.5) };
            let transfer = TransferFunction::new(vec![point], OpacityRule::Power, 1.0).unwrap();
            let mut scene = Scene::new(grid.clone().into(), transfer);
            assert!(scene.reflection().is_none() && !scene.has_gradient_opacity());
            let shading = Shading { gradient_opacity: vec![(0.0, 0.5)], ..Shading::default() };
            scene.shading = Some(Arc::new(shading));
            let mut reflects = |compositing| {
                scene.compositing = compositing;
                (scene.reflection().is_some(), scene.has_gradient_opacity())
            };
            assert_eq!(reflects(Compositing::Over), (emission.is_none(), true));
            assert_eq!(reflects(Compositing::Accumulate { level: 0.5 }), (emission.is_none(), true));
            assert_eq!(reflects(first), (true, false));
            assert_eq!(reflects(Compositing::Maximum), (false, false));
            scene.compositing = Compositing::Over;
            let max = scene.max_radiance();
            // Of white under a headlight: 0.2 + 0.7, which is less than the colour itself, and 0.3 of highlight.
            assert_eq!(max, if emission.is_none() { MaxRadiance::Color(1.3) } else { MaxRadiance::Emission(1.0) });
            let over = |max: MaxRadiance| [0.5, 2.0].map(|length| max.over(length));
            assert_eq!(over(max), if emission.is_none() { [1.3; 2] } else { [1.0, 2.0] });
            assert_eq!(over(MaxRadiance::Color(0.5)), [1.0; 2], "opacity");
        }
    }
}
