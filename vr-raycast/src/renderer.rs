//! The ray caster as a [`Renderer`].

use vr_core::{Configurable, Control, OptionError, Options, Prepared, RenderError, Renderer, Scene, View};

use crate::capabilities::{check, check_view};
use crate::caster::{RayCaster, Step};
use crate::options::{LARGEST_ERROR, MAX_ERROR};
use crate::prepared::PreparedCaster;

impl Renderer for RayCaster {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        let (caster, scene) = (self.settled_for(scene), self.scene_of(scene));
        check(&caster, &scene)?;
        view.map_or(Ok(()), |view| {
            view.validate()?;
            check_view(&caster, view)
        })
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedCaster::new(self.clone(), scene, control)?))
    }

    fn max_error(&self) -> Option<f64> {
        if let Step::ErrorBound(error) = self.step { Some(error) } else { None }
    }

    fn with_max_error(&self, error: f64) -> Option<Result<Box<dyn Renderer>, OptionError>> {
        // Steps that were chosen otherwise do not go with it.
        let chosen = match self.step {
            Step::Auto | Step::ErrorBound(_) => Options::new(),
            _ => self.to_options(),
        };
        // A minimum would take NaN for a number.
        let error = if error > LARGEST_ERROR { LARGEST_ERROR } else { error };
        let promising = self.configure(&chosen.with(MAX_ERROR, error));
        Some(promising.map(|caster| Box::new(caster) as Box<dyn Renderer>))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn promises_what_can_be_kept() {
        let promised = |caster: RayCaster, error: f64| {
            let promising = caster.with_max_error(error).expect("it can promise");
            promising.map(|renderer| renderer.max_error()).map_err(|e| e.to_string())
        };
        assert_eq!(RayCaster::default().max_error(), None);
        assert_eq!(promised(RayCaster::default(), 1e-3), Ok(Some(1e-3)));
        assert_eq!(promised(RayCaster { step: Step::ErrorBound(0.5), ..RayCaster::default() }, 1e-3), Ok(Some(1e-3)));
        assert_eq!(promised(RayCaster::default(), 7.0), Ok(Some(1.0)));
        assert!(promised(RayCaster::uniform(1.0), 1e-3).unwrap_err().contains("steps=uniform"));
        for wrong in [1e-7, f64::NAN] {
            assert!(promised(RayCaster::default(), wrong).is_err(), "{wrong}");
        }
    }
}
