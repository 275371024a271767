//! Colours of voxels at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::{ColorGrid, Filter};
use vr_kernels::vector::{Field, Lanes, Stage};

use super::cells_of;

/// Colours of voxels, as packets read them.
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketColors<'a> {
    channels: [Field<'a, u16>; 3],
    is_nearest: bool,
}

impl<'a> PacketColors<'a> {
    pub(super) fn new(colors: &'a ColorGrid) -> Self {
        let channels = colors.channels();
        Self { channels: channels.each_ref().map(Field::new), is_nearest: colors.color_filter() == Filter::Nearest }
    }

    /// Multiplies light by the colours of its places.
    ///
    /// Its own function: most packets have none.
    #[inline(never)]
    pub(super) fn tint<S: Simd>(
        &self,
        simd: S,
        place: &[[Lanes; 3]; 2],
        light: &mut [Lanes; 4],
        stage: &mut Stage<u16>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let at = &cells_of(simd, place);
                for c in 0..3 {
                    let channel = &self.channels[c];
                    let stored = if self.is_nearest {
                        f32x16::load_array(simd, channel.nearest(simd, at))
                    } else {
                        channel.fetch(simd, at, stage);
                        channel.value(simd, at, stage)
                    };
                    let color = stored * (1.0 / f32::from(ColorGrid::WHITE));
                    light[c] = Lanes::new(light[c].load(simd) * color);
                }
            },
        );
    }
}
