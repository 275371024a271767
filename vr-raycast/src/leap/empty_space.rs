//! What a prepared scene knows of its empty space.

use std::sync::Arc;

use vr_core::{Compositing, GridVolume, Real, Scene};
use vr_kernels::ranges::RangeBlocks;

use super::{Boxes, ChessboardCloud, ExactCloud, Leaper, NodeRanges, Octree, Polyhedron, Pyramid};
use super::{Visibility, VisibleBlocks};
use crate::caster::{Leaping, RayCaster, Step};
use crate::classify::Classifier;
use crate::walk::VicinityFlags;

/// Cells along the edge of a block. Ranges of blocks of 8³ take 12 bytes per 512 voxels; of 4³, they would take more than an 8-bit volume may
/// grow by, and rays would ask more often.
pub(crate) const EDGE: usize = 8;

/// Where nothing is visible: made when the scene is prepared, and again when its transfer function changes.
#[derive(Clone)]
pub(crate) enum EmptySpace {
    /// Intervals of rays.
    Leaper(Arc<dyn Leaper>),
    /// The same, by an octree, whose ranges outlive a transfer function.
    Octree(Arc<Octree>),
    /// A flag along rays.
    Vicinity(Arc<VicinityFlags>),
}

impl EmptySpace {
    /// What a caster wants for a scene, which `classifier` is made for; `None` where all is sampled. `last`: what was made when only the
    /// transfer function, or the compositing, was another one.
    pub(crate) fn new<R: Real>(
        caster: &RayCaster,
        scene: &Scene,
        volume: &GridVolume,
        classifier: &Classifier<R>,
        last: Option<&Self>,
    ) -> Option<Self> {
        let visibility = match scene.compositing {
            Compositing::First { threshold } => Visibility::of_threshold(threshold, classifier.calibration),
            Compositing::Over | Compositing::Accumulate { .. } => Visibility::of_light(
                &classifier.transfer,
                classifier.calibration,
                classifier.table.as_ref().map(|(table, _)| table),
                classifier.profile.as_ref().and_then(|profile| profile.table.as_ref()),
            ),
            Compositing::Average | Compositing::Maximum | Compositing::Minimum => return None,
        };
        let dims = volume.dims();
        if let Step::Vicinity { coarse, .. } = caster.step {
            let edge = coarse.ceil() as usize;
            let blocks = VisibleBlocks::new(dims, &RangeBlocks::of_volume(volume, edge), &visibility);
            return Some(Self::Vicinity(Arc::new(VicinityFlags::new(&blocks))));
        }
        // The others have maps of their own.
        if caster.leaping == Leaping::None || !matches!(caster.step, Step::Uniform(_)) {
            return None;
        }
        let ranges = RangeBlocks::of_volume(volume, EDGE);
        let blocks = || VisibleBlocks::new(dims, &ranges, &visibility);
        Some(match caster.leaping {
            Leaping::None => return None,
            Leaping::Octree => {
                let nodes = match last {
                    Some(Self::Octree(octree)) => octree.nodes(),
                    _ => Arc::new(NodeRanges::new(dims, &ranges)),
                };
                Self::Octree(Arc::new(Octree::new(nodes, &ranges, &visibility)))
            }
            Leaping::Pyramid => Self::Leaper(Arc::new(Pyramid::new(&blocks()))),
            Leaping::Auto | Leaping::ExactCloud => Self::Leaper(Arc::new(ExactCloud::new(&blocks()))),
            Leaping::ChessboardCloud => Self::Leaper(Arc::new(ChessboardCloud::new(&blocks()))),
            Leaping::Boxes => Self::Leaper(Arc::new(Boxes::new(&blocks()))),
            Leaping::Polyhedron => Self::Leaper(Arc::new(Polyhedron::new(&blocks()))),
        })
    }
}
