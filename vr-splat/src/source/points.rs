//! Scattered points as splats.

use vr_core::PointSet;

use crate::projection::SplatView;
use crate::source::Source;
use crate::splat::Splat;

/// Points, in a view.
pub(crate) struct PointSplats<'a> {
    pub(crate) points: &'a PointSet,
    /// Indices of the points that can be seen.
    pub(crate) visible: &'a [u32],
    pub(crate) view: &'a SplatView,
    pub(crate) low_pass: f64,
    /// True if splats carry their numbers among the visible points in the place of values.
    pub(crate) numbered: bool,
}

/// Points to a chunk.
const CHUNK: usize = 1 << 15;

impl Source for PointSplats<'_> {
    fn chunks(&self) -> usize {
        self.visible.len().div_ceil(CHUNK)
    }

    fn count(&self) -> u64 {
        self.visible.len() as u64
    }

    fn splats(&self, chunk: usize, emit: &mut dyn FnMut(Splat, u32)) {
        let last = ((chunk + 1) * CHUNK).min(self.visible.len());
        for i in chunk * CHUNK..last {
            let k = self.visible[i] as usize;
            let place = self.view.place(self.points.positions()[k]);
            let mut radius = f64::from(self.points.radii()[k]);
            if self.low_pass > 0.0 {
                radius = radius.hypot(self.low_pass * self.view.pixel_at(place.z) * self.view.unit);
            }
            emit(
                Splat {
                    place: place.as_vec3().to_array(),
                    scale: (self.view.unit / radius) as f32,
                    weight: (f64::from(self.points.weights()[k]) / (radius * radius * radius)) as f32,
                    value: if self.numbered { f32::from_bits(i as u32) } else { self.points.values()[k] },
                },
                0,
            );
        }
    }
}
