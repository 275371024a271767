//! Engines that draw a scene.

use vr_core::{RenderError, Scene};

use crate::caster::{RayCaster, Step};
use crate::error_bound::ErrorBound;
use crate::packet::PacketEngine;
use crate::render_tables::TablesByPrecision;
use crate::source::Source;

/// Engine that draws a scene.
pub(crate) enum Engine {
    /// Plain engine: one ray after another, under any settings.
    Plain(TablesByPrecision),
    /// Vector engine: sixteen rays at once, where it knows the scene and the settings.
    Packets(Box<PacketEngine>, TablesByPrecision),
    /// Engine whose steps keep a bound of the error.
    ErrorBound(Box<ErrorBound>),
}

impl Engine {
    /// Tables of the plain engine, where it may draw.
    pub(crate) fn kernel(&self) -> Option<&TablesByPrecision> {
        match self {
            Self::Plain(kernel) | Self::Packets(_, kernel) => Some(kernel),
            Self::ErrorBound(_) => None,
        }
    }

    /// Makes the engine of a scene, and takes over from `last` what has not changed since.
    ///
    /// # Errors
    /// An error bound that cannot be kept.
    pub(crate) fn new(
        caster: &RayCaster,
        scene: &Scene,
        source: &Source,
        last: Option<(&Scene, &Self)>,
    ) -> Result<Self, RenderError> {
        let Source::Grid(volume) = source else {
            return Ok(Self::Plain(TablesByPrecision::of_field(scene, source.placement())));
        };
        if let Step::ErrorBound(error) = caster.step {
            let error_bound = ErrorBound::new(error, scene, volume)?;
            return Ok(Self::ErrorBound(Box::new(error_bound)));
        }
        let last = match last {
            Some((scene, engine)) => engine.kernel().map(|kernel| (scene, kernel)),
            None => None,
        };
        let mut kernel = TablesByPrecision::new(caster, scene, volume, last);
        let packets = match &kernel {
            // Packets know nothing of colours that voxels have.
            _ if scene.volume.colors().is_some() => None,
            TablesByPrecision::F32(tables) => PacketEngine::new(caster, scene, volume, tables),
            TablesByPrecision::F64(_) => None,
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
