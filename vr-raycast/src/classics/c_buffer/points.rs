//! Points that the rays of a picture met first, and where they land in the next one.

use glam::DVec3;
use vr_core::{GridVolume, ParameterError, Rays, View};

use crate::projection::Projection;

/// Points that the rays of a picture met first, pixel by pixel, in index space.
pub(crate) struct Points {
    view: View,
    points: Vec<Option<[f32; 3]>>,
}

/// Place of a projected point: its pixel, and its depth along the view.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Landed {
    at: [i64; 2],
    depth: f64,
}

impl Points {
    pub(super) fn new(view: &View, points: Vec<Option<[f32; 3]>>) -> Self {
        Self { view: view.clone(), points }
    }

    /// Returns for each pixel of a view the depth at which its rays may begin, by what the points tell; 0 where they tell nothing.
    ///
    /// 1. All points are projected.
    /// 2. *Hidden points* are removed by their order along the lines of the old picture, as in [`visible_in_order`]. A test of depths alone cannot
    ///    find them: rounded to pixels, points of two surfaces seldom land in one pixel, and the far ones show through the gaps between the near ones.
    /// 3. Of the points of several lines that land in one pixel, the nearest stays.
    /// 4. *Holes* take the nearest depth of the eight pixels around them.
    ///
    /// # Errors
    /// Same as for [`vr_core::Camera::frame`].
    pub(super) fn claims(&self, view: &View, volume: &GridVolume) -> Result<Vec<f64>, ParameterError> {
        let projection = Projection::new(view, volume.placement())?;
        let land = |p: DVec3| {
            let (at, depth) = projection.point(p)?;
            // `as` saturates.
            Some(Landed { at: at.map(|x| x.floor() as i64), depth })
        };
        let mut landed: Vec<Option<Landed>> =
            self.points.iter().map(|point| point.and_then(|p| land(DVec3::from_array(p.map(f64::from))))).collect();
        let turn = self.turn(&projection, volume)?;
        let axis = usize::from(turn[1].abs() > turn[0].abs());
        let [w, h] = self.view.size.map(|n| n as usize);
        let (lines, length) = if axis == 0 { (h, w) } else { (w, h) };
        if turn[axis] != 0.0 {
            for line in 0..lines {
                let index = |i: usize| {
                    let i = if turn[axis] > 0.0 { i } else { length - 1 - i };
                    if axis == 0 { line * w + i } else { i * w + line }
                };
                let places = (0..length)
                    .map(|i| landed[index(i)].map(|l| if turn[axis] > 0.0 { l.at[axis] } else { -l.at[axis] }));
                let visible = visible_in_order(places);
                visible
                    .into_iter()
                    .enumerate()
                    .filter(|&(_, visible)| !visible)
                    .for_each(|(i, _)| landed[index(i)] = None);
            }
        }
        let [w, h] = view.size.map(i64::from);
        let mut depths = vec![0.0f64; (w * h) as usize];
        for Landed { at: [x, y], depth } in landed.into_iter().flatten() {
            if (0..w).contains(&x) && (0..h).contains(&y) {
                let claim = &mut depths[(y * w + x) as usize];
                *claim = if *claim == 0.0 { depth } else { claim.min(depth) };
            }
        }
        Ok((0..w * h).map(|i| filled(&depths, [w, h], [i % w, i / w])).collect())
    }

    /// Returns how much farther along x and y of the new picture the near points in the middle of the old one move than the far ones.
    fn turn(&self, projection: &Projection, volume: &GridVolume) -> Result<[f64; 2], ParameterError> {
        let [w, h] = self.view.size.map(f64::from);
        let ray = Rays::new(&self.view)?.at(0.5 * w, 0.5 * h);
        let placement = volume.placement();
        let last = DVec3::from_array(volume.dims().map(|n| (n - 1) as f64));
        let (middle, corner) = (placement.to_world(0.5 * last), placement.to_world(last));
        let (distance, reach) = ((middle - ray.origin).dot(ray.direction), 0.5 * middle.distance(corner));
        let at = |s: f64| projection.point(placement.to_index(ray.origin + s * ray.direction)).map(|(at, _)| at);
        let (near, far) = (at((distance - reach).max(0.1 * reach)), at((distance + reach).max(0.2 * reach)));
        Ok(near.zip(far).map_or([0.0; 2], |(near, far)| [0, 1].map(|a| near[a] - far[a])))
    }
}

/// Tells which points of a line can still be seen, by Yagel and Shi's order: of two points j before k along the line, in the direction in
/// which near points move farther, k may be hidden where j lands at it or beyond it, j′ ≥ k′, for only what is nearer can have overtaken it.
/// `places` are where the points land along that direction; `None` counts for nothing.
fn visible_in_order(places: impl Iterator<Item = Option<i64>>) -> Vec<bool> {
    let mut farthest = i64::MIN;
    places
        .map(|place| {
            let visible = place.is_some_and(|place| place > farthest);
            farthest = place.map_or(farthest, |place| place.max(farthest));
            visible
        })
        .collect()
}

/// Returns the depth of a pixel, or of the nearest of those around it where it has none.
fn filled(depths: &[f64], [w, h]: [i64; 2], [x, y]: [i64; 2]) -> f64 {
    let own = depths[(y * w + x) as usize];
    if own > 0.0 {
        return own;
    }
    let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
    let inside = around.filter(|&[x, y]| (0..w).contains(&x) && (0..h).contains(&y));
    let nearest = inside.map(|[x, y]| depths[(y * w + x) as usize]).filter(|&d| d > 0.0).fold(f64::INFINITY, f64::min);
    if nearest < f64::INFINITY { nearest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_overtaken_is_hidden() {
        let order = |places: &[i64]| visible_in_order(places.iter().map(|&p| (p >= 0).then_some(p)));
        assert_eq!(order(&[1, 2, 5, 6]), [true; 4]);
        // The near point from pixel 1 lands at 5, beyond those from pixels 2 and 3; the one from pixel 4 is clear of it.
        assert_eq!(order(&[0, 5, 3, 4, 6]), [true, true, false, false, true]);
        // j′ = k′: in one pixel, the earlier stands in front. Pixels without a point hide nothing.
        assert_eq!(order(&[2, 2, -1, 3]), [true, false, false, true]);
    }

    #[test]
    fn holes_take_the_nearest_around() {
        let depths = [0.0, 4.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0];
        assert_eq!(filled(&depths, [4, 2], [1, 1]), 3.0);
        assert_eq!(filled(&depths, [4, 2], [2, 1]), 4.0);
        assert_eq!(filled(&depths, [4, 2], [0, 1]), 3.0);
        assert_eq!(filled(&depths, [4, 2], [0, 0]), 3.0);
        assert_eq!(filled(&depths, [4, 2], [3, 1]), 0.0);
    }
}
