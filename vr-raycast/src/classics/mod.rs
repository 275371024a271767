#![doc = include_str!("README.md")]

mod boxes;
mod c_buffer;
mod chessboard_cloud;
mod coherent;
mod homogeneity;
mod homogeneous_walk;
mod moments;
mod octree;
pub(crate) mod options;
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

pub(crate) use homogeneity::{Homogeneity, homogeneity};
pub(crate) use homogeneous_walk::HomogeneousWalk;
pub use template::Connectivity;
pub(crate) use template::TemplateWalk;

use std::any::Any;
use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Compositing, Control, Feature, GridVolume, IndexRay, Layer, Ray, Real, RenderError, Rendered, Scene, View,
};
use vr_kernels::ranges::RangeBlocks;

use crate::caster::{EmptySpace, ImageSampling, RayCaster, Rule, Step, Traversal};
use crate::engine::Engine;
use crate::leap::{EDGE, Leaper, Visibility, VisibleBlocks};
use crate::prepared::PreparedCaster;
use crate::render_tables::{RenderTables, TablesByPrecision};
use crate::walk::{Walk, Walks};
use boxes::Boxes;
use c_buffer::CBuffer;
use chessboard_cloud::ChessboardCloud;
use coherent::CoherenceBuffer;
use octree::{NodeRanges, Octree};
use polyhedron::Polyhedron;
use pyramid::Pyramid;
use template::draw_by_template;
use vicinity::Vicinity;
use voxels::voxel_walk;

/// Makes the structure that a caster asks for by name; `None` if it is not a classic one. `last` is one made for the same field.
pub(crate) fn leaper<R: Real>(
    caster: &RayCaster,
    volume: &GridVolume,
    visibility: &Visibility<R>,
    last: Option<&Arc<dyn Leaper>>,
) -> Option<Arc<dyn Leaper>> {
    let dims = volume.dims();
    let blocks = |edge| VisibleBlocks::new(dims, &RangeBlocks::of_volume(volume, edge), visibility);
    if let Step::Vicinity { coarse, .. } = caster.step {
        return Some(Arc::new(Vicinity::new(&blocks(coarse.ceil() as usize))));
    }
    Some(match caster.empty_space {
        EmptySpace::Auto | EmptySpace::None | EmptySpace::ExactCloud => return None,
        EmptySpace::Octree => Arc::new(octree(dims, &RangeBlocks::of_volume(volume, EDGE), visibility, last)),
        EmptySpace::Pyramid => Arc::new(Pyramid::new(&blocks(EDGE))),
        EmptySpace::ChessboardCloud => Arc::new(ChessboardCloud::new(&blocks(EDGE))),
        EmptySpace::Boxes => Arc::new(Boxes::new(&blocks(EDGE))),
        EmptySpace::Polyhedron => Arc::new(Polyhedron::new(&blocks(EDGE))),
    })
}

/// Makes an octree; its ranges outlive a transfer function.
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

/// Rule that sets the steps of classic walks.
#[derive(Clone, Copy)]
pub(crate) enum WalkKind<'a> {
    /// Walk from voxel to voxel.
    Voxels,
    /// Walk in long steps where the medium is nearly the same.
    Homogeneous(&'a Homogeneity),
}

/// Returns the kind of walk that a caster asks for; `None` if it is not a classic one.
pub(crate) fn walk_kind<'a, R: Real>(caster: &RayCaster, tables: &'a RenderTables<R>) -> Option<WalkKind<'a>> {
    if caster.traversal == Traversal::Voxels {
        return Some(WalkKind::Voxels);
    }
    tables.homogeneity.as_deref().map(WalkKind::Homogeneous)
}

impl<'a> WalkKind<'a> {
    /// Begins the walk of a ray, as [`Walks::along`] does.
    pub(crate) fn along(self, ray: IndexRay, walks: &Walks<'_>, start: u32, backwards: bool) -> Walk<'a> {
        match self {
            Self::Voxels => Walk::Listed(voxel_walk(&ray, walks.dims, start, backwards)),
            Self::Homogeneous(map) => {
                Walk::Homogeneous(HomogeneousWalk::new(map, ray, walks.step, walks.voxel, backwards))
            }
        }
    }
}

/// State that a coherent screen keeps from picture to picture. No picture depends on it, but for what it costs.
pub(crate) enum Coherence {
    /// Visible cells of the blocks that were met first.
    Cells(CoherenceBuffer),
    /// Points that were met first.
    Points(CBuffer),
}

impl Coherence {
    /// Makes the state before the first picture; `None` for screens that keep none.
    pub(crate) fn of(caster: &RayCaster, scene: &Scene, volume: &GridVolume, engine: &Engine) -> Option<Self> {
        Some(match caster.image_sampling {
            ImageSampling::Coherent => Self::Cells(CoherenceBuffer::of(scene, volume, engine)?),
            ImageSampling::CBuffer => Self::Points(CBuffer::of(scene, volume, engine)?),
            _ => return None,
        })
    }

    /// True if the state made for one scene holds for another one, too. Compositing decides what a table is needed for, and so what can be
    /// seen.
    pub(crate) fn holds_for(then: &Scene, now: &Scene) -> bool {
        let same_light = then.transfer == now.transfer && then.compositing == now.compositing;
        then.volume.same(&now.volume) && same_light
    }
}

/// Returns the number of steps of a ray that can be left out if nothing before a distance can be seen, rounding included: whole steps that end before it, but
/// for the last one under an operator that looks for a crossing between two samples.
fn steps_before(part: &IndexRay, distance: f64, step: f64, compositing: Compositing) -> u32 {
    let looks_back = matches!(compositing, Compositing::First { .. });
    // `as` saturates.
    (((distance - part.start) / step).floor() as u32).saturating_sub(u32::from(looks_back))
}

/// Returns the distance along a ray at which it reaches a depth, which is measured along the view.
fn distance_at_depth(part: &IndexRay, ray: &Ray, forward: DVec3, depth: f64) -> f64 {
    depth / ray.direction.dot(forward) - part.offset
}

impl PreparedCaster {
    /// Draws a view, with the surfaces in it, if the caster's screen is a classic one.
    pub(crate) fn draw_by_classic_screen(
        &mut self,
        seen: (&View, Option<&Layer>),
        control: &Control,
    ) -> Option<Result<Rendered, RenderError>> {
        let volume = self.source.grid()?;
        if let (ImageSampling::Template { connectivity }, Some(kernel)) =
            (self.caster.image_sampling, self.engine.kernel())
        {
            return Some(match kernel {
                TablesByPrecision::F32(tables) => self
                    .pipeline(tables, seen)
                    .and_then(|pipeline| draw_by_template(connectivity, pipeline, volume, control)),
                TablesByPrecision::F64(tables) => self
                    .pipeline(tables, seen)
                    .and_then(|pipeline| draw_by_template(connectivity, pipeline, volume, control)),
            });
        }
        let (volume, step) = (Arc::clone(volume), self.caster.world_step(volume.placement()));
        let compositing = self.scene.compositing;
        let mut buffer = self.coherence.take()?;
        let drawn = self.tracer(seen).and_then(|tracer| match &mut buffer {
            Coherence::Cells(buffer) => buffer.draw(tracer.as_ref(), &volume, (step, compositing), seen, control),
            Coherence::Points(buffer) => buffer.draw(tracer.as_ref(), &volume, (step, compositing), seen, control),
        });
        self.coherence = Some(buffer);
        Some(drawn)
    }
}

/// Returns the feature of a scene that homogeneous steps cannot draw, and its description.
pub(crate) fn beyond_steps(caster: &RayCaster, scene: &Scene) -> Option<(Feature, &'static str)> {
    let modulates = scene.shading.as_ref().is_some_and(|s| !s.gradient_opacity.is_empty());
    let cuts = matches!(scene.compositing, Compositing::Accumulate { .. });
    if !matches!(caster.step, Step::Homogeneous { .. } | Step::Variance { .. }) {
        None
    } else if !scene.compositing.integrates_light() {
        Some((Feature::Setting, "homogeneous steps under operators that gather no light, of which their bound is"))
    } else if !matches!(caster.rule, Rule::Auto | Rule::Midpoint) {
        Some((Feature::Setting, "homogeneous steps by another rule than the midpoint's"))
    } else if cuts && scene.transfer.has_emission() {
        let what = "homogeneous steps under accumulate of an emission of its own, which shines where opacity hardly changes: no bound is known of where it is cut";
        Some((Feature::Setting, what))
    } else if scene.transfer.has_rows() || modulates {
        let what = "homogeneous steps with opacity by the gradient: values do not tell how it changes";
        Some((Feature::GradientOpacity, what))
    } else {
        None
    }
}

/// Returns the feature of a scene or setting that a classic screen cannot draw.
pub(crate) fn beyond_screen(caster: &RayCaster, scene: &Scene) -> Option<String> {
    let compositing = format!("compositing '{}'", scene.compositing.name());
    let uneven = !matches!(caster.step, Step::Uniform(_)) || caster.traversal != Traversal::Samples;
    let uneven = uneven.then_some("steps that are not all of one length (set a step, in voxels)".to_owned());
    let found = match caster.image_sampling {
        ImageSampling::Auto | ImageSampling::EveryPixel | ImageSampling::Adaptive { .. } => vec![],
        ImageSampling::Coherent | ImageSampling::CBuffer => vec![
            (!scene.compositing.integrates_light() && !matches!(scene.compositing, Compositing::First { .. }))
                .then(|| format!("{compositing}, which depends on what cannot be seen, too,")),
            uneven,
            // All values of a straight line lie between those of a continuous field at its ends: the ray has met them in the same cells.
            matches!(caster.rule, Rule::Quadratic | Rule::Exact).then(|| {
                format!(
                    "the rule '{}', whose curves leave the range of the values in the cells that they pass,",
                    caster.rule.name()
                )
            }),
        ],
        ImageSampling::Template { connectivity } => {
            let is_discrete = connectivity == Connectivity::Discrete;
            let leaps = caster.empty_space != EmptySpace::Auto || caster.step.finds_empty_space();
            vec![
                (!caster.step.is_on_lattice())
                    .then_some("steps that each ray sets for itself, where all step alike (set a step, in voxels)".to_owned()),
                (caster.traversal != Traversal::Samples).then_some(
                    "a traversal of each ray's own (template-faces goes from cell to cell, template-discrete from voxel to voxel)".to_owned(),
                ),
                (is_discrete && !matches!(caster.rule, Rule::Auto | Rule::Midpoint)).then(|| {
                    format!("the rule '{}', where a voxel stands for all of a step (must be midpoint)", caster.rule.name())
                }),
                (is_discrete && leaps).then_some("a way of leaping, which looks along rays, where voxels lie beside them".to_owned()),
            ]
        }
    };
    found.into_iter().flatten().next()
}
