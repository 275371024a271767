//! Principal axes that a view needs, and the part of the picture that each of them draws.
//!
//! Parallel rays have one principal axis: the one along which their direction goes most, in index space, so that no slice is sheared by more
//! than a voxel. In perspective every ray has its own. The picture is split by it: each axis, and each way along it, draws the
//! rays that are its own, onto an image at the volume's far face; from inside the volume, too. So no slice is ever sheared by more than a
//! voxel, however wide the view. Where two parts meet, each is as far from the truth as slices are there; nothing is blended.
//!
//! Voxels are as large as texels in the middle of the volume, or further back where else the far face had more than [`MAX_PITCH`] of them to
//! a texel: so every slice is interpolated, none is sampled so coarsely that a voxel could be missed.

use glam::{DVec2, DVec3};
use vr_core::{Filter, GridVolume, RenderError};

use crate::factorization::{Factorization, IndexView, axes_of, permuted};
use crate::shear_warp::ShearWarp;

/// A part of the picture: those rays whose direction is mostly along one axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass {
    pub(crate) factorization: Factorization,
    /// First and last texel, in both directions, that the part of the picture sees; `None`: all.
    pub(crate) within: Option<[f64; 4]>,
}

/// Texels beyond what is seen, for the warp's filter.
const MARGIN: f64 = 2.0;
/// Most voxels to a texel, along either side, of any slice seen in perspective, in texels of a voxel: linear interpolation still meets each.
const MAX_PITCH: f64 = 1.25;
/// The largest intermediate image, in texels.
const MAX_TEXELS: u64 = 1 << 28;
/// A volume of fewer voxels across than this is still given as many texels, and so is what is seen, from the middle to 45°, from just before
/// the last slice.
const MIN_TEXELS: f64 = 8.0;

/// Lattice of the texels of intermediate images.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TexelLattice {
    /// Voxels to a texel, in the volume's middle.
    pub(crate) texel: f64,
    /// True if samples are values of the nearest voxels, which jump half way between voxels.
    pub(crate) nearest: bool,
}

impl TexelLattice {
    pub(crate) fn of(renderer: &ShearWarp, volume: &GridVolume) -> Self {
        Self { texel: renderer.texel, nearest: volume.filter() == Filter::Nearest }
    }
}

/// The passes of a view of the index box from `low` to `high`, of a volume whose last sample is `last`.
pub(crate) fn passes(
    view: &IndexView,
    [low, high]: [DVec3; 2],
    last: DVec3,
    lattice: TexelLattice,
) -> Result<Vec<Pass>, RenderError> {
    let mut passes = Vec::new();
    if view.is_perspective() {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                passes.extend(perspective_pass(view, axis, sign, [low, high], last, lattice));
            }
        }
        if let [only] = passes.as_mut_slice() {
            only.within = None;
        }
    } else {
        passes.extend(parallel_pass(view, [low, high], last, lattice));
    }
    for pass in &passes {
        let [width, height] = pass.factorization.size.map(|n| n as u64);
        let texels = width.saturating_mul(height);
        if texels > MAX_TEXELS {
            let limit = MAX_TEXELS * 16;
            return Err(RenderError::TooLarge { what: "intermediate image", bytes: texels.saturating_mul(16), limit });
        }
    }
    Ok(passes)
}

/// The axis along which a direction goes most; the first of equals.
pub(crate) fn principal_axis(direction: DVec3) -> usize {
    let d = direction.abs();
    if d.x >= d.y && d.x >= d.z {
        0
    } else if d.y >= d.z {
        1
    } else {
        2
    }
}

/// Voxels across a slice, where it is widest.
fn across(last: DVec3, axis: usize) -> f64 {
    permuted(last, axes_of(axis)).truncate().max_element()
}

fn parallel_pass(view: &IndexView, [low, high]: [DVec3; 2], last: DVec3, lattice: TexelLattice) -> Option<Pass> {
    let axis = principal_axis(view.ahead());
    let sign = if view.ahead()[axis] < 0.0 { -1.0 } else { 1.0 };
    let plane = if sign > 0.0 { high[axis] } else { low[axis] };
    let factorization = Factorization::new(view, axis, sign, plane);
    let [low, high] = [low, high].map(|v| permuted(v, axes_of(axis)));
    let mut shadow = Rectangle::NOTHING;
    for w in [low.z, high.z] {
        // Of an image whose texels lie at (u, v) themselves.
        let shift = factorization.slice(w).offset;
        shadow.add(DVec2::new(low.x, low.y) - shift);
        shadow.add(DVec2::new(high.x, high.y) - shift);
    }
    let mut seen = Rectangle::NOTHING;
    corners(view).into_iter().for_each(|c| seen.add((factorization.plane_of_screen() * c).truncate()));
    let spacing = (across(last, axis) / MIN_TEXELS).min(1.0) * lattice.texel;
    framed(factorization, shadow.and(seen), last, (spacing, lattice.nearest))
        .map(|factorization| Pass { factorization, within: None })
}

fn perspective_pass(
    view: &IndexView,
    axis: usize,
    sign: f64,
    [low, high]: [DVec3; 2],
    last: DVec3,
    lattice: TexelLattice,
) -> Option<Pass> {
    let plane = if sign > 0.0 { high[axis] } else { low[axis] };
    let depth = (plane - view.eye[axis]) * sign;
    if depth <= 0.0 {
        return None;
    }
    let factorization = Factorization::new(view, axis, sign, plane);
    // Of the picture, the polygon whose rays go mostly along this axis, this way.
    let directions = view.directions().transpose();
    let axes = axes_of(axis);
    let along = directions.col(axis) * sign;
    let mut polygon = corners(view).to_vec();
    for across in [directions.col(axes[0]), directions.col(axes[1])] {
        polygon = clipped(&polygon, along - across);
        polygon = clipped(&polygon, along + across);
    }
    let mut seen = Rectangle::NOTHING;
    for corner in polygon {
        let p = factorization.plane_of_screen() * corner;
        if p.z > 0.0 {
            seen.add(p.truncate() / p.z);
        }
    }
    let [low, high, eye] = [low, high, view.eye].map(|v| permuted(v, axes));
    let eye_uv = eye.truncate();
    let mine = Rectangle { low: eye_uv - depth, high: eye_uv + depth };
    let mut shadow = Rectangle::NOTHING;
    for w in [low.z, high.z] {
        let near = (w - eye.z) / (plane - eye.z);
        if near <= 0.0 {
            // The eye is between the slices: the box fills all of its view.
            shadow = mine;
            break;
        }
        shadow.add(eye_uv + (low.truncate() - eye_uv) / near);
        shadow.add(eye_uv + (high.truncate() - eye_uv) / near);
    }
    let near = ((if sign > 0.0 { low.z } else { high.z } - eye.z) * sign).max(0.0);
    let pitch = (2.0 * depth / (near + depth)).min(MAX_PITCH);
    let spacing = (depth.min(across(last, axis)) / MIN_TEXELS).min(pitch) * lattice.texel;
    let factorization = framed(factorization, shadow.and(seen).and(mine), last, (spacing, lattice.nearest))?;
    let texel = |p: DVec2| (p - factorization.origin) / spacing;
    let (first, last) = (texel(mine.low), texel(mine.high));
    // The parts of two axes meet to the last bit or overlap: no pixel falls between them.
    const SEAM: f64 = 1e-9;
    let within = [first.x - SEAM, first.y - SEAM, last.x + SEAM, last.y + SEAM];
    Some(Pass { factorization, within: Some(within) })
}

/// The four corners of the picture, homogeneous.
fn corners(view: &IndexView) -> [DVec3; 4] {
    let [w, h] = view.size().map(f64::from);
    [DVec3::Z, DVec3::new(w, 0.0, 1.0), DVec3::new(w, h, 1.0), DVec3::new(0.0, h, 1.0)]
}

/// The part of a convex polygon where a linear function is not negative (Sutherland & Hodgman 1974, *Reentrant polygon clipping*).
fn clipped(polygon: &[DVec3], function: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &p) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()];
        let (here, there) = (function.dot(p), function.dot(next));
        if here >= 0.0 {
            kept.push(p);
        }
        if (here < 0.0) != (there < 0.0) {
            kept.push(p + (next - p) * (here / (here - there)));
        }
    }
    kept
}

/// Gives a factorization an image of a part of its plane; none where there is nothing to be seen.
///
/// Texels stand on a lattice that does not move with what part is seen, and looks the same from either end of the volume, so that turned
/// data give turned pictures. With 1/n voxels to a texel, the volume's faces lie half way between two texels: what is interpolated from the
/// last one inside to nothing is neither too wide nor too narrow. And views along an axis, where every slice lies like the last one, see
/// what views from the side see on average: a turning volume does not flash. But values of the nearest voxels jump half way between
/// voxels, and where n is odd some of those texels would stand there: then texels stand on the faces.
fn framed(
    factorization: Factorization,
    part: Rectangle,
    last: DVec3,
    (spacing, nearest): (f64, bool),
) -> Option<Factorization> {
    if !(part.low.cmple(part.high).all() && part.low.is_finite() && part.high.is_finite()) {
        return None;
    }
    let last = permuted(last, factorization.axes).truncate();
    let on_faces = nearest && (1.0 / spacing).round() % 2.0 == 1.0;
    let beside = if on_faces { 0.0 } else { spacing };
    let first = 0.5 * (last - (last / spacing + 1e-9).floor() * spacing + beside);
    let low = first + (((part.low - first) / spacing).floor() - MARGIN) * spacing;
    Some(factorization.framed(low, part.high + MARGIN * spacing, spacing))
}

/// A rectangle of a plane.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

impl Rectangle {
    const NOTHING: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };

    fn add(&mut self, p: DVec2) {
        (self.low, self.high) = (self.low.min(p), self.high.max(p));
    }

    fn and(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{Camera, Placement, Projection, View};

    use super::*;

    const fn lattice(texel: f64) -> TexelLattice {
        TexelLattice { texel, nearest: false }
    }

    fn view(eye: DVec3, target: DVec3, projection: Projection) -> IndexView {
        let camera = Camera { eye, target, up: DVec3::new(0.12, 0.99, 0.2), projection };
        IndexView::new(&View::new(camera, [64, 48]), &Placement::from_spacing([1.0; 3]).unwrap()).unwrap()
    }

    const BOX: [DVec3; 2] = [DVec3::ZERO, DVec3::new(20.0, 30.0, 40.0)];

    #[test]
    fn parallel_rays_have_one_axis() {
        let all = |d: DVec3| {
            let middle = DVec3::new(10.0, 15.0, 20.0);
            passes(
                &view(middle - 100.0 * d, middle, Projection::Orthographic { height: 60.0 }),
                BOX,
                BOX[1],
                lattice(1.0),
            )
            .unwrap()
        };
        let near_x = all(DVec3::new(-1.0, 0.3, 0.4));
        assert_eq!((near_x.len(), near_x[0].factorization.axes, near_x[0].factorization.sign), (1, [1, 2, 0], -1.0));
        assert_eq!(near_x[0].factorization.plane, 0.0);
        // The image holds the box's shadow and the margins, no more.
        let size = near_x[0].factorization.size;
        assert!(size[0] <= 30 + 6 + 7 && size[1] <= 40 + 8 + 7, "{size:?}");
    }

    #[test]
    fn every_ray_that_meets_the_box_belongs_to_a_pass() {
        let perspective = Projection::Perspective { fov: 110.0 };
        let eyes = [DVec3::new(10.0, 15.0, 20.0), DVec3::new(-3.0, 14.0, 19.0), DVec3::new(25.0, 35.0, 45.0), BOX[0]];
        for eye in eyes {
            let target = DVec3::new(12.0, 11.0, 17.0);
            let index = view(eye, target, perspective);
            let passes = passes(&index, BOX, BOX[1], lattice(1.0)).unwrap();
            let directions = index.directions();
            for y in 0..48 {
                for x in 0..64 {
                    let d = directions * DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
                    // Far enough along it to be beyond the box.
                    let meets = (1..2000).any(|i| {
                        let p = eye + d.normalize() * (f64::from(i) * 0.05);
                        p.cmpge(BOX[0]).all() && p.cmple(BOX[1]).all()
                    });
                    let owners = passes.iter().filter(|p| {
                        let t = p.factorization.texels_of_screen()
                            * DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 1.0);
                        let at = t.truncate() / t.z;
                        let [w, h] = p.factorization.size.map(|n| n as f64);
                        let [x0, y0, x1, y1] = p.within.unwrap_or([0.0, 0.0, w, h]);
                        t.z > 0.0 && at.x >= x0 && at.x <= x1 && at.y >= y0 && at.y <= y1 && {
                            // Inside the image with room for a filter of four taps.
                            at.x >= 1.0 && at.y >= 1.0 && at.x <= w - 2.0 && at.y <= h - 2.0
                        }
                    });
                    assert!(!meets || owners.count() == 1, "{eye} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_seen_behind_the_eye() {
        let away =
            view(DVec3::new(10.0, 15.0, 60.0), DVec3::new(10.0, 15.0, 90.0), Projection::Perspective { fov: 30.0 });
        assert!(passes(&away, BOX, BOX[1], lattice(1.0)).unwrap().is_empty());
    }

    #[test]
    fn huge_images_are_refused() {
        let wide = view(
            DVec3::new(10.0, 15.0, 100.0),
            DVec3::new(10.0, 15.0, 20.0),
            Projection::Orthographic { height: 60.0 },
        );
        let big = [DVec3::ZERO, DVec3::new(1e6, 1e6, 10.0)];
        let far =
            view(DVec3::new(5e5, 5e5, 100.0), DVec3::new(5e5, 5e5, 0.0), Projection::Orthographic { height: 1e6 });
        assert!(passes(&wide, BOX, BOX[1], lattice(0.25)).is_ok());
        assert!(matches!(passes(&far, big, big[1], lattice(0.25)), Err(RenderError::TooLarge { .. })));
    }
}
