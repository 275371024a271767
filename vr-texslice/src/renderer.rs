//! The renderer behind the trait that all renderers stand behind.

use vr_core::{
    Control, DocumentedError, NamedSetting, OptionError, OptionSpec, Options, OrderClaim, Prepared, RenderError,
    Renderer, Scene,
};

use crate::options::{SPECS, configure};
use crate::prepared::PreparedTexSlice;
use crate::settings::{orders, settings};
use crate::tex_slice::TexSlice;

impl Renderer for TexSlice {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn options(&self) -> &[OptionSpec] {
        &SPECS
    }

    fn configure(&self, options: &Options) -> Result<Box<dyn Renderer>, OptionError> {
        Ok(Box::new(configure(self, options)?))
    }

    fn settings(&self) -> Vec<NamedSetting> {
        settings()
    }

    fn orders(&self) -> Vec<OrderClaim> {
        orders()
    }

    fn hard_case_error(&self, case: &str) -> Option<DocumentedError> {
        self.documented_error(case).map(Into::into)
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedTexSlice::new(self.clone(), scene, control)?))
    }
}
