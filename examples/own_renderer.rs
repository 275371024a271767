//! A renderer of one's own, and what the test kit says of it.
//!
//! `cargo run --release -p vr-examples --example own_renderer`

use vr_core::{
    Compositing, Control, Feature, Frame, Model, Prepared, Rays, RenderError, RenderStats, Rendered, Renderer, Scene,
    Unsupported, View,
};
use vr_physics::check::{Effort, agrees_with_reference, invariants};

/// Sees the volume's box alone: every ray that meets it is opaque grey. It draws something, and it is wrong.
#[derive(Clone)]
struct GreyBox;

impl Renderer for GreyBox {
    fn name(&self) -> &'static str {
        "box"
    }

    fn supports(&self, scene: &Scene, _view: Option<&View>) -> Result<(), RenderError> {
        let refuse = |feature: Feature| Err(Unsupported { renderer: "box", feature, what: feature.to_string() }.into());
        match () {
            () if scene.compositing != Compositing::Over => refuse(Feature::Compositing),
            () if scene.shading.is_some() => refuse(Feature::Shading),
            () if scene.has_gradient_opacity() => refuse(Feature::GradientOpacity),
            () if scene.surfaces.is_some() => refuse(Feature::Surfaces),
            () => Ok(()),
        }
    }

    fn prepare(&self, scene: &Scene, _control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        self.supports(scene, None)?;
        Ok(Box::new(PreparedBox { scene: scene.clone() }))
    }
}

struct PreparedBox {
    scene: Scene,
}

impl Prepared for PreparedBox {
    fn update(&mut self, scene: &Scene, _control: &Control) -> Result<(), RenderError> {
        GreyBox.supports(scene, None)?;
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, _control: &Control) -> Result<Rendered, RenderError> {
        let rays = Rays::new(view)?;
        let (low, high) = self.scene.volume.bounds();
        let boxed = vr_core::Clip { crop: Some((low, high)), planes: Vec::new() };
        let pixel = |i: u32| {
            let ray = rays.at(f64::from(i % view.size[0]) + 0.5, f64::from(i / view.size[0]) + 0.5);
            if ray.inside(&boxed).is_some() { [0.5, 0.5, 0.5, 1.0] } else { [0.0; 4] }
        };
        let pixels = (0..view.size[0] * view.size[1]).map(pixel).collect();
        Ok(Rendered { frame: Frame::new(view.size, pixels, None), stats: RenderStats::default() })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}

fn main() {
    let effort = Effort::cases(32);

    // It does not depend on threads: this passes.
    match invariants::ignores_threads(&GreyBox, &effort) {
        Ok(report) => println!("passed: {report}\n"),
        Err(failure) => println!("failed: {failure}\n"),
    }
    // It is not the volume that it draws: this fails, with the smallest scene that shows it, as a scene file.
    match agrees_with_reference(&GreyBox, |_, _| 1e-3, &effort) {
        Ok(report) => println!("passed: {report}"),
        Err(failure) => println!("failed: {failure}"),
    }
}
