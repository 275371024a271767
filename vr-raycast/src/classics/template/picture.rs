//! Picture on the base plane.

use vr_core::Counts;

use crate::tracer::RaySample;

/// Picture on the base plane: a ray for each of its pixels.
pub(crate) struct BasePicture {
    pub(crate) size: [usize; 2],
    /// Colours, and world distances from the plane to what is seen.
    pub(crate) rays: Vec<RaySample>,
    pub(crate) counts: Counts,
}

impl BasePicture {
    /// Returns the colour between pixels, bilinear; clear beyond the edges.
    pub(crate) fn between(&self, at: [f64; 2]) -> [f32; 4] {
        let whole = at.map(f64::floor);
        let [tu, tv] = [0, 1].map(|a| (at[a] - whole[a]) as f32);
        let pixel = |du: i64, dv: i64| self.pixel([whole[0] as i64 + du, whole[1] as i64 + dv]).rgba;
        let corners = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
        std::array::from_fn(|c| {
            let a = corners[0][c] + tu * (corners[1][c] - corners[0][c]);
            let b = corners[2][c] + tu * (corners[3][c] - corners[2][c]);
            a + tv * (b - a)
        })
    }

    /// Returns the depth of the nearest pixel: the mean of depths on two sides of an edge means nothing.
    pub(crate) fn nearest_depth(&self, at: [f64; 2]) -> f32 {
        self.pixel(at.map(|x| (x + 0.5).floor() as i64)).depth
    }

    fn pixel(&self, [u, v]: [i64; 2]) -> RaySample {
        let inside = (0..self.size[0] as i64).contains(&u) && (0..self.size[1] as i64).contains(&v);
        if inside { self.rays[v as usize * self.size[0] + u as usize] } else { RaySample::NOTHING }
    }
}
