//! Whole scenes, put together from a volume, a transfer function, a picture and a look.

use std::sync::Arc;

use proptest::prelude::*;
use vr_core::{Compositing, Field, Filter, GradientMethod, Scene, Shading, View, Volume};

use super::cameras::{Cuts, Viewpoint, cuts, generic};
use super::looks::{Lit, scheme, shading, stretched, tame_compositing};
use super::transfers::{Recipe, recipe, tame_recipe, value_range};
use crate::check::TestScene;

/// Largest number of pixels along a side of a random picture.
pub(super) const MAX_PIXELS: u32 = 8;

/// View apart from the volume that it shows.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub viewpoint: Viewpoint,
    /// Width and height, where the viewpoint leaves them open.
    pub size: [u32; 2],
    pub supersampling: u32,
    pub cuts: Option<Cuts>,
}

/// A picture from some viewpoint, with one ray a pixel or a few.
pub(super) fn picture(viewpoint: impl Strategy<Value = Viewpoint>) -> impl Strategy<Value = Picture> {
    pictures(viewpoint, prop_oneof![5 => Just(1u32), 1 => 2u32..=3])
}

/// A picture with one ray a pixel.
pub(super) fn plain_picture(viewpoint: impl Strategy<Value = Viewpoint>) -> impl Strategy<Value = Picture> {
    pictures(viewpoint, Just(1))
}

fn pictures(
    viewpoint: impl Strategy<Value = Viewpoint>,
    supersampling: impl Strategy<Value = u32>,
) -> impl Strategy<Value = Picture> {
    let size = [1..=MAX_PIXELS, 1..=MAX_PIXELS];
    (viewpoint, size, supersampling, cuts()).prop_map(|(viewpoint, size, supersampling, cuts)| Picture {
        viewpoint,
        size,
        supersampling,
        cuts: Some(cuts),
    })
}

/// Look of a scene but for its transfer function.
#[derive(Clone, Debug)]
pub(super) struct Look {
    pub filter: Filter,
    pub shading: Option<Lit>,
    /// The threshold of `first` is a fraction of the range of values.
    pub compositing: Compositing,
    pub background: [f32; 3],
}

impl Look {
    /// The trilinear filter on a black background.
    pub fn plain(compositing: Compositing, shading: Option<Lit>) -> Self {
        Self { filter: Filter::default(), shading, compositing, background: [0.0; 3] }
    }
}

/// Any scene of some volumes that have no filter to choose: every transfer function, every compositing, shading.
pub(super) fn any_scene<V: Into<Volume> + std::fmt::Debug>(
    volumes: impl Strategy<Value = V>,
    viewpoint: impl Strategy<Value = Viewpoint>,
) -> impl Strategy<Value = TestScene> {
    let look = (scheme(), shading()).prop_map(|(compositing, shading)| Look::plain(compositing, shading));
    scenes(volumes, recipe(), picture(viewpoint), look)
}

/// A scene of some volumes whose picture depends continuously on every number: no jumps, no opacity near 1, no threshold, no shading.
pub(super) fn tame_scene<V: Into<Volume> + std::fmt::Debug>(
    volumes: impl Strategy<Value = V>,
) -> impl Strategy<Value = TestScene> {
    let look = tame_compositing().prop_map(|compositing| Look::plain(compositing, None));
    scenes(volumes, tame_recipe(), picture(generic()), look)
}

/// Scenes of these parts.
pub(super) fn scenes<V: Into<Volume> + std::fmt::Debug>(
    volumes: impl Strategy<Value = V>,
    recipe: impl Strategy<Value = Recipe>,
    picture: impl Strategy<Value = Picture>,
    look: impl Strategy<Value = Look>,
) -> impl Strategy<Value = TestScene> {
    (volumes, recipe, picture, look)
        .prop_map(|(volume, recipe, picture, look)| assemble(volume.into(), &recipe, &picture, look))
}

/// Puts a scene together: each part in the volume's own measures.
pub(super) fn assemble(volume: Volume, recipe: &Recipe, picture: &Picture, look: Look) -> TestScene {
    let size = picture.viewpoint.size(picture.size);
    let clip = picture.cuts.as_ref().map(|cuts| cuts.of_volume(&volume)).unwrap_or_default();
    let camera = picture.viewpoint.camera(&volume, size[1]);
    let view = View { supersampling: picture.supersampling, clip, ..View::new(camera, size) };
    let compositing = stretched(look.compositing, value_range(&volume));
    let transfer = recipe.of_volume(&volume);
    let has_gradient = volume.field().is_none_or(Field::has_gradient);
    let lit = look.shading.filter(|_| has_gradient).map(|(shading, lights)| (of_kind(shading, &volume), lights));
    // The gradient of a rectilinear grid is the grid's own choice.
    let gradient = lit.as_ref().map_or(GradientMethod::default(), |(shading, _)| shading.gradient);
    let volume = volume.with_filter(look.filter).with_gradient(gradient);
    let mut scene = Scene { compositing, background: look.background, ..Scene::new(volume, transfer) };
    if let Some((shading, lights)) = lit {
        (scene.shading, scene.lights) = (Some(Arc::new(shading)), lights);
    }
    TestScene { scene, view }
}

/// The shading with the only source of the gradient that a volume has, where it leaves no choice.
fn of_kind(shading: Shading, volume: &Volume) -> Shading {
    match volume {
        Volume::Grid(_) | Volume::Color(_) | Volume::Rectilinear(_) => shading,
        _ => Shading { gradient: GradientMethod::default(), ..shading },
    }
}
