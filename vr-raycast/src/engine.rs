//! Engines that draw a scene.

use std::sync::Arc;

use vr_core::{Feature, Placement, RenderError, Scene};

use crate::capabilities::unsupported;
use crate::caster::{Precision, RayCaster, Step, TransferLookup};
use crate::error_bound::ErrorBound;
use crate::pace::{Lengths, cells_of_parts};
use crate::packet::level;
use crate::packet::{
    LabelEngine, PacketEngine, PatchEngine, PatchPickEngine, PickEngine, PointEngine, PointPickEngine,
};
use crate::render_tables::TablesByPrecision;
use crate::source::Source;
use crate::step_map::RangeSteps;

/// Engine that draws a scene.
pub(crate) enum Engine {
    /// Plain engine: one ray after another, under any settings.
    Plain(TablesByPrecision),
    /// Vector engine: sixteen rays at once, where it knows the scene and the settings.
    Packets(Box<PacketEngine>, TablesByPrecision),
    /// Vector engine for operators that pick a value.
    Picks(Box<PickEngine>, TablesByPrecision),
    /// Vector engine for volumes that are regular lattices patch by patch.
    Patches(Box<PatchEngine>, TablesByPrecision, Lengths),
    /// Vector engine for scattered points.
    Points(Box<PointEngine>, TablesByPrecision, Lengths),
    /// Vector engine for grids with labels.
    Labels(Box<LabelEngine>, TablesByPrecision, Lengths),
    /// Vector engine for operators that pick a value of such patches.
    PatchPicks(Box<PatchPickEngine>, TablesByPrecision, Lengths),
    /// Vector engine for operators that pick a value of scattered points.
    PointPicks(Box<PointPickEngine>, TablesByPrecision, Lengths),
    /// Plain engine for a field that is no grid's, with the lengths of its steps.
    Field(TablesByPrecision, Lengths),
    /// Engine whose steps keep a bound of the error.
    ErrorBound(Box<ErrorBound>),
}

impl Engine {
    /// Tables of the plain engine, where it may draw.
    pub(crate) fn kernel(&self) -> Option<&TablesByPrecision> {
        match self {
            Self::Plain(kernel)
            | Self::Packets(_, kernel)
            | Self::Picks(_, kernel)
            | Self::Patches(_, kernel, _)
            | Self::Points(_, kernel, _)
            | Self::Labels(_, kernel, _)
            | Self::PatchPicks(_, kernel, _)
            | Self::PointPicks(_, kernel, _)
            | Self::Field(kernel, _) => Some(kernel),
            Self::ErrorBound(_) => None,
        }
    }

    /// Lengths of steps in a field that is no grid's.
    pub(crate) fn lengths(&self) -> Option<&Lengths> {
        match self {
            Self::Patches(_, _, lengths)
            | Self::Points(_, _, lengths)
            | Self::Labels(_, _, lengths)
            | Self::PatchPicks(_, _, lengths)
            | Self::PointPicks(_, _, lengths)
            | Self::Field(_, lengths) => Some(lengths),
            Self::Plain(_) | Self::Packets(..) | Self::Picks(..) | Self::ErrorBound(_) => None,
        }
    }

    /// Makes the engine of a scene, and takes over from `last` what has not changed since.
    ///
    /// # Errors
    /// An error bound that cannot be kept; a table where the engine uses none.
    pub(crate) fn new(
        caster: &RayCaster,
        scene: &Scene,
        source: &Source,
        last: Option<(&Scene, &Self)>,
    ) -> Result<Self, RenderError> {
        if let Step::ErrorBound(error) = caster.step {
            let packets = level::of(caster.vector).filter(|_| caster.precision == Precision::F32);
            let error_bound = ErrorBound::new(error, scene, source, packets);
            return Ok(Self::ErrorBound(Box::new(error_bound)));
        }
        let Source::Grid(volume) = source else {
            let kernel = TablesByPrecision::of_field(scene, source.placement());
            let lengths = lengths(caster, scene, source.placement());
            if let Some(points) = PointEngine::new(caster, scene, source) {
                return Ok(Self::Points(Box::new(points), kernel, lengths));
            }
            if let Some(labels) = LabelEngine::new(caster, scene, source) {
                return Ok(Self::Labels(Box::new(labels), kernel, lengths));
            }
            if let Some(picks) = PointPickEngine::new(caster, scene, source) {
                return Ok(Self::PointPicks(Box::new(picks), kernel, lengths));
            }
            if let Some(picks) = PatchPickEngine::new(caster, scene, source, lengths.clone()) {
                return Ok(Self::PatchPicks(Box::new(picks), kernel, lengths));
            }
            return Ok(match PatchEngine::new(caster, scene, source, lengths.clone()) {
                Some(engine) => Self::Patches(Box::new(engine), kernel, lengths),
                None if caster.transfer_lookup == TransferLookup::Table => {
                    let what = format!(
                        "classification=table in volumes of the kind '{}' where rays go one by one, which evaluate the transfer function: auto or exact",
                        scene.volume.kind()
                    );
                    return Err(unsupported(Feature::Setting, what));
                }
                None => Self::Field(kernel, lengths),
            });
        };
        let last = match last {
            Some((scene, engine)) => engine.kernel().map(|kernel| (scene, kernel)),
            None => None,
        };
        let mut kernel = TablesByPrecision::new(caster, scene, volume, last);
        // Packets are rays of pixels.
        let by_packets = caster.image_sampling.casts_pixels();
        if let TablesByPrecision::F32(_) = kernel
            && by_packets
            && let Some(picks) = PickEngine::new(caster, scene, volume)
        {
            return Ok(Self::Picks(Box::new(picks), kernel));
        }
        let packets = match &kernel {
            TablesByPrecision::F32(tables) if by_packets => PacketEngine::new(caster, scene, volume, tables),
            TablesByPrecision::F32(_) | TablesByPrecision::F64(_) => None,
        };
        Ok(match packets {
            Some(packets) => Self::Packets(Box::new(packets), kernel),
            None => {
                kernel.find_empty_space(caster, scene, volume, last);
                Self::Plain(kernel)
            }
        })
    }
}

/// Returns the lengths of a caster's steps in a field that is no grid's.
pub(crate) fn lengths(caster: &RayCaster, scene: &Scene, placement: &Placement) -> Lengths {
    match (caster.step, cells_of_parts(&scene.volume), scene.volume.value_range()) {
        (Step::Local { error }, Some([edge, shortest]), Some(range)) => {
            Lengths::Local { steps: Arc::new(RangeSteps::new(scene, range, error)), edge, shortest }
        }
        _ => Lengths::Uniform { step: caster.world_step(placement), spacing: scene.volume.mean_spacing() },
    }
}

#[cfg(test)]
mod tests;
