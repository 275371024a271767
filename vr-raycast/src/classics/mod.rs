#![doc = include_str!("README.md")]

mod boxes;
mod chessboard_cloud;
mod coherent;
mod homogeneity;
mod homogeneous_walk;
mod octree;
mod polyhedron;
mod pyramid;
mod straightness;
mod template;
mod vicinity;
mod voxels;

#[cfg(test)]
mod speed;
#[cfg(test)]
mod tests;

pub(crate) use coherent::{CoherenceBuffer, coherent};
pub(crate) use homogeneity::Homogeneity;
pub(crate) use homogeneous_walk::HomogeneousWalk;
pub(crate) use template::draw_by_template;
pub(crate) use voxels::voxel_walk;

use std::any::Any;
use std::sync::Arc;

use vr_core::{Compositing, Filter, ParameterError, RangeBlocks, Real, Scene, UniformVolume};

use crate::caster::{
    Classification, Connectivity, Leaping, Order, Precision, RayCaster, Rule, Screen, Step, Traversal,
};
use crate::leap::{EDGE, Leaper, Visibility, VisibleBlocks};
use boxes::Boxes;
use chessboard_cloud::ChessboardCloud;
use octree::{NodeRanges, Octree};
use polyhedron::Polyhedron;
use pyramid::Pyramid;
use vicinity::Vicinity;

/// Makes the structure that a caster asks for by name; `None` if it is not a classic one. `last`: made for the same field.
pub(crate) fn leaper<R: Real>(
    caster: &RayCaster,
    volume: &UniformVolume,
    filter: Filter,
    visibility: &Visibility<R>,
    last: Option<&Arc<dyn Leaper>>,
) -> Option<Arc<dyn Leaper>> {
    let dims = volume.dims();
    let blocks = |edge| VisibleBlocks::new(dims, &volume.range_blocks(filter, edge), visibility);
    if let Step::Vicinity { coarse, .. } = caster.step {
        return Some(Arc::new(Vicinity::new(&blocks(coarse.ceil() as usize))));
    }
    Some(match caster.leaping {
        Leaping::Auto | Leaping::None | Leaping::ExactCloud => return None,
        Leaping::Octree => Arc::new(octree(dims, &volume.range_blocks(filter, EDGE), visibility, last)),
        Leaping::Pyramid => Arc::new(Pyramid::new(&blocks(EDGE))),
        Leaping::ChessboardCloud => Arc::new(ChessboardCloud::new(&blocks(EDGE))),
        Leaping::Boxes => Arc::new(Boxes::new(&blocks(EDGE))),
        Leaping::Polyhedron => Arc::new(Polyhedron::new(&blocks(EDGE))),
    })
}

/// An octree, whose ranges outlive a transfer function.
fn octree<R: Real>(
    dims: [usize; 3],
    ranges: &RangeBlocks,
    visibility: &Visibility<R>,
    last: Option<&Arc<dyn Leaper>>,
) -> Octree {
    let last = last.and_then(|last| (last.as_ref() as &dyn Any).downcast_ref::<Octree>());
    let nodes = last.map_or_else(|| Arc::new(NodeRanges::new(dims, ranges)), Octree::nodes);
    Octree::new(nodes, ranges, visibility)
}

/// Checks the numbers of classic steps and traversals, and that they go together.
pub(crate) fn validate(caster: &RayCaster) -> Result<(), ParameterError> {
    match caster.step {
        Step::Vicinity { coarse, fine } if !(coarse > fine && coarse <= RayCaster::LONGEST_STEP) => {
            let allowed = "must be longer than the fine step, and at most 64";
            return Err(ParameterError::new("render.coarse", coarse, allowed));
        }
        Step::Homogeneous { error, .. } if !(error > 0.0 && error <= 1.0) => {
            return Err(ParameterError::new("render.homogeneity", error, "must be above 0 and at most 1"));
        }
        _ => {}
    }
    if caster.traversal == Traversal::Voxels && !matches!(caster.rule, Rule::Midpoint | Rule::Exact) {
        return Err(ParameterError::new("render.traversal", "voxels", "goes with rule = \"midpoint\" only"));
    }
    Ok(())
}

/// Returns the feature of a scene that homogeneous steps have no answer to.
pub(crate) fn beyond_steps(caster: &RayCaster, scene: &Scene) -> Option<&'static str> {
    if !matches!(caster.step, Step::Homogeneous { .. }) {
        None
    } else if scene.compositing != Compositing::Over || caster.order == Order::BackToFront {
        Some("homogeneous steps under anything but over, front to back")
    } else if caster.rule != Rule::Midpoint {
        Some("homogeneous steps by another rule than the midpoint's")
    } else if scene.shading.is_some() {
        Some("homogeneous steps with shading: values do not tell how it changes")
    } else {
        None
    }
}

/// Returns the feature of a scene that a classic screen has no answer to.
pub(crate) fn beyond_screen(caster: &RayCaster, scene: &Scene) -> Option<String> {
    let compositing = format!("compositing '{}'", scene.compositing.name());
    let uneven = !matches!(caster.step, Step::Uniform(_)) || caster.traversal != Traversal::Samples;
    let uneven = uneven.then_some("steps that are not all of one length (set a step, in voxels)".to_owned());
    let filter = caster.filter_of(scene);
    let found = match caster.screen {
        Screen::EveryPixel | Screen::Adaptive { .. } => vec![],
        Screen::Coherent => vec![
            (!scene.compositing.integrates_light()).then_some(compositing),
            uneven,
            // What a table of segments shows cannot be told from the values at their ends.
            (!matches!(caster.rule, Rule::Midpoint | Rule::Left)).then(|| format!("the rule '{}'", caster.rule.name())),
        ],
        Screen::Template { connectivity } => {
            let own_values = connectivity == Connectivity::Discrete && filter == Filter::Nearest;
            vec![
                (scene.compositing != Compositing::Over).then_some(compositing),
                scene.shading.is_some().then_some("shading".to_owned()),
                (!own_values && filter != Filter::Trilinear).then(|| format!("the filter '{filter}'")),
                (caster.order == Order::BackToFront).then_some("compositing back to front".to_owned()),
                uneven,
                (caster.leaping != Leaping::Auto).then_some("a way of leaping".to_owned()),
                (caster.rule != Rule::Midpoint).then(|| format!("the rule '{}'", caster.rule.name())),
                (caster.precision == Precision::F64).then_some("64-bit precision".to_owned()),
                (caster.classification == Classification::Exact).then_some("exact classification".to_owned()),
            ]
        }
    };
    found.into_iter().flatten().next()
}
