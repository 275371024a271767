//! Places of a mesh on the screen.

use vr_core::View;

use crate::camera_space::CameraVertex;

/// A view's screen, in samples from its top left corner: sample (i, j) has its centre at (i + ½, j + ½).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Screen {
    pub(crate) perspective: bool,
    middle: [f64; 2],
    /// Samples for each world unit, at depth 1 in perspective.
    pub(crate) per_unit: f64,
    /// Depth in front of the eye from which on something can be projected.
    near: f64,
}

/// Part of a cell's size in front of the eye that cannot be projected.
const NEAR: f64 = 1e-9;

impl Screen {
    /// The screen of a view of a mesh whose cells have a size, with `per_pixel` samples along the edge of a pixel.
    pub(crate) fn new(view: &View, per_pixel: u32, spacing: f64) -> Self {
        let size = view.size.map(|n| n * per_pixel);
        let projection = view.camera.projection;
        let (perspective, per_unit) = (projection.is_perspective(), f64::from(size[1]) / projection.height());
        Self { perspective, middle: size.map(|n| 0.5 * f64::from(n)), per_unit, near: NEAR * spacing }
    }

    /// True if a depth lies ahead of the eye, so that it can be projected.
    pub(crate) fn is_ahead(&self, depth: f64) -> bool {
        !self.perspective || depth >= self.near
    }

    /// Projects a place that [`is_ahead`](Self::is_ahead).
    pub(crate) fn project(&self, [x, y, depth]: [f64; 3]) -> [f64; 2] {
        let scale = if self.perspective { self.per_unit / depth } else { self.per_unit };
        [self.middle[0] + x * scale, self.middle[1] - y * scale]
    }

    /// The smallest box around the part of a cell ahead of the eye, as lowest and highest corner; `None` if there is none.
    pub(crate) fn bounds<const N: usize>(&self, corners: &[&CameraVertex<N>; 4]) -> Option<[[f64; 2]; 2]> {
        if corners.iter().all(|c| c.at[2] < 0.0) {
            return None;
        }
        self.box_around(corners)
    }

    /// The smallest box around what can be projected of the hull of some vertices; `None` if nothing can.
    pub(crate) fn box_around<const N: usize>(&self, corners: &[&CameraVertex<N>]) -> Option<[[f64; 2]; 2]> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut take = |at: [f64; 3]| {
            let at = self.project(at);
            for a in 0..2 {
                (low[a], high[a]) = (low[a].min(at[a]), high[a].max(at[a]));
            }
        };
        for (i, a) in corners.iter().enumerate() {
            if self.is_ahead(a.at[2]) {
                take(a.at);
                continue;
            }
            // An edge that comes from behind the eye is projected from the nearest depth on.
            for (j, b) in corners.iter().enumerate() {
                if i != j && self.is_ahead(b.at[2]) {
                    let t = (self.near - a.at[2]) / (b.at[2] - a.at[2]);
                    let [x, y] = [0, 1].map(|c| a.at[c] + (b.at[c] - a.at[c]) * t);
                    take([x, y, self.near]);
                }
            }
        }
        (low[0] <= high[0]).then_some([low, high])
    }
}
