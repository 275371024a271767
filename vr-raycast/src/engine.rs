//! Engines that draw a scene.

use vr_core::{RenderError, Scene};

use crate::caster::{RayCaster, Step};
use crate::instruments::Kernel;
use crate::packet::PacketEngine;
use crate::source::Source;
use crate::tolerance::Promise;

/// Engine that draws a scene.
pub(crate) enum Engine {
    /// One ray after another, by any settings.
    Plain(Kernel),
    /// Sixteen rays at once, where vector code knows the scene and the settings.
    Packets(Box<PacketEngine>, Kernel),
    /// In steps that a promised error asks for.
    Promise(Box<Promise>),
}

impl Engine {
    /// Tables of the plain engine, where it may draw.
    pub(crate) fn kernel(&self) -> Option<&Kernel> {
        match self {
            Self::Plain(kernel) | Self::Packets(_, kernel) => Some(kernel),
            Self::Promise(_) => None,
        }
    }

    /// Makes what the scene needs, and takes over from `last` what has not changed since.
    ///
    /// # Errors
    /// A promised error that cannot be kept.
    pub(crate) fn new(
        caster: &RayCaster,
        scene: &Scene,
        source: &Source,
        last: Option<(&Scene, &Self)>,
    ) -> Result<Self, RenderError> {
        let Source::Grid(volume) = source else { return Ok(Self::Plain(Kernel::of_field(scene, source.placement()))) };
        if let Step::Tolerance(error) = caster.step {
            let promise = Promise::new(error, scene, volume)?;
            return Ok(Self::Promise(Box::new(promise)));
        }
        let last = match last {
            Some((scene, engine)) => engine.kernel().map(|kernel| (scene, kernel)),
            None => None,
        };
        let mut kernel = Kernel::new(caster, scene, volume, last);
        let packets = match &kernel {
            Kernel::F32(instruments) => PacketEngine::new(caster, scene, volume, instruments),
            Kernel::F64(_) => None,
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
