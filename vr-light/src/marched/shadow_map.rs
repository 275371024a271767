//! Light of a lamp at infinity that gets to each place.

use std::sync::Mutex;

use glam::DVec3;
use vr_core::parallel::{locked, try_each};
use vr_core::{Control, RenderError};

use crate::medium::Medium;

/// Largest number of places along an axis of the map.
const MAX_PLACES: usize = 384;
/// Smallest number along its longest axis: the faces of the volume's box, at which depths bend, must not be blurred, however few voxels there are.
const MIN_PLACES: usize = 160;
/// Places of a column that the medium is asked for at once.
const BATCH: usize = 64;

/// Optical depth between each place of a lattice and a lamp at infinity (Kniss et al., "Interactive volume rendering using multi-dimensional transfer
/// functions and direct manipulation widgets", 2002, keep slices of it; here it is whole).
///
/// The lattice is turned so that one axis points towards the lamp; between its places depths are interpolated.
#[derive(Clone, Debug)]
pub struct ShadowMap {
    /// Unit vectors of the lattice; the last one points towards the lamp.
    axes: [DVec3; 3],
    /// Place of the first entry, along the axes.
    low: DVec3,
    step: DVec3,
    size: [usize; 3],
    /// Depths, the axis towards the lamp fastest.
    depths: Vec<f32>,
}

impl ShadowMap {
    /// The map of a medium in a box for a lamp in a unit direction, its places about a spacing apart, or closer.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub fn new(medium: &dyn Medium, towards: DVec3, spacing: f64, control: &Control) -> Result<Self, RenderError> {
        // A box along the axes around the medium.
        let (a, b) = towards.any_orthonormal_pair();
        let axes = [a, b, towards];
        let (low, high) = medium.bounds();
        let corners = (0..8).map(|i| DVec3::select(glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high));
        let along = |corner: DVec3| DVec3::from_array(axes.map(|axis| axis.dot(corner)));
        let (first, last) = corners
            .map(along)
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
        let extent = last - first;
        let spacing = spacing.min(extent.max_element() / MIN_PLACES as f64);
        let size: [usize; 3] =
            std::array::from_fn(|i| ((extent[i] / spacing).ceil() as usize).clamp(1, MAX_PLACES) + 1);
        let step = extent / DVec3::from_array(size.map(|n| (n - 1) as f64));
        // Each column is summed up from the lamp on, by the extinction in the middle between two places.
        let mut depths = vec![0f32; size.iter().product()];
        let columns: Vec<_> = depths.chunks_mut(size[2]).map(Mutex::new).collect();
        let fill = |column: usize| {
            control.check()?;
            let (i, j) = (column / size[1], column % size[1]);
            let foot = axes[0] * (first.x + step.x * i as f64) + axes[1] * (first.y + step.y * j as f64);
            let mut depths = locked(&columns[column]);
            let place = |k: usize| foot + towards * (first.z + step.z * (k as f64 + 0.5));
            let inside = places_inside(foot, towards, (low, high), |z| (z - first.z) / step.z - 0.5, size[2] - 1);
            let (mut places, mut extinctions) = ([DVec3::ZERO; BATCH], [0.0; BATCH]);
            let mut sum = 0.0;
            let mut end = inside.end;
            while end > inside.start {
                let from = inside.start.max(end.saturating_sub(BATCH));
                let count = end - from;
                (from..end).zip(&mut places).for_each(|(k, at)| *at = place(k));
                medium.extinctions(&places[..count], -towards, 0, &mut extinctions[..count]);
                for (k, extinction) in (from..end).zip(extinctions).rev() {
                    sum += extinction * step.z;
                    depths[k] = sum as f32;
                }
                end = from;
            }
            // Behind the medium.
            depths[..inside.start].fill(sum as f32);
            Ok(())
        };
        control.run(|| try_each(columns.len(), &fill))?;
        drop(columns);
        Ok(Self { axes, low: first, step, size, depths })
    }

    /// Optical depth between a place and the lamp: 0 where its light passes by the box, that of the whole way through it behind the box.
    #[inline]
    pub fn depth(&self, at: DVec3) -> f64 {
        let places: [f64; 3] = std::array::from_fn(|i| (self.axes[i].dot(at) - self.low[i]) / self.step[i]);
        if (0..2).any(|i| is_beside(places[i], self.size[i])) {
            return 0.0;
        }
        let [x, y, z]: [(usize, f32); 3] = std::array::from_fn(|i| {
            let place = places[i].clamp(0.0, (self.size[i] - 1) as f64);
            let cell = (place as usize).min(self.size[i] - 2);
            (cell, (place - cell as f64) as f32)
        });
        let column = |i: usize, j: usize| {
            let first = (i * self.size[1] + j) * self.size[2] + z.0;
            let [near, far] = [self.depths[first], self.depths[first + 1]];
            near + z.1 * (far - near)
        };
        let row = |i: usize| {
            let (near, far) = (column(i, y.0), column(i, y.0 + 1));
            near + y.1 * (far - near)
        };
        let (near, far) = (row(x.0), row(x.0 + 1));
        f64::from(near + x.1 * (far - near))
    }
}

/// Numbers of the places of a column, of so many, that may lie in a box: all that do, and a few near its faces. `number_at` tells the number at a distance
/// from the foot of the column.
fn places_inside(
    foot: DVec3,
    towards: DVec3,
    (low, high): (DVec3, DVec3),
    number_at: impl Fn(f64) -> f64,
    count: usize,
) -> std::ops::Range<usize> {
    // Places are rounded: a column in a face is inside.
    let slack = (high - low).abs() * 1e-9;
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let [a, b] = [low - slack, high + slack].map(|corner| (corner[axis] - foot[axis]) / towards[axis]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    let [first, last] =
        [number_at(near) - 1.0, number_at(far) + 2.0].map(|number| number.clamp(0.0, count as f64) as usize);
    first..last.max(first)
}

/// True if a coordinate, in steps of a lattice of so many places, is outside of it by more than rounding.
pub(crate) fn is_beside(place: f64, size: usize) -> bool {
    !(-1e-6..=(size - 1) as f64 + 1e-6).contains(&place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::SceneMedium;
    use vr_core::scattering::Scattering;
    use vr_core::{Clip, ControlPoint, OpacityRule, Placement, Plane, Scene, TransferFunction, UniformGrid};

    /// Depths summed place by place, through all of the map's box.
    fn summed(map: &ShadowMap, medium: &dyn Medium) -> Vec<f32> {
        let [a, b, towards] = map.axes;
        let mut depths = Vec::new();
        for column in 0..map.size[0] * map.size[1] {
            let (i, j) = (column / map.size[1], column % map.size[1]);
            let foot = a * (map.low.x + map.step.x * i as f64) + b * (map.low.y + map.step.y * j as f64);
            let mut sums = vec![0.0f64];
            for k in (0..map.size[2] - 1).rev() {
                let at = foot + towards * (map.low.z + map.step.z * (k as f64 + 0.5));
                sums.push(sums[sums.len() - 1] + medium.extinction(at, -towards, 0) * map.step.z);
            }
            depths.extend(sums.iter().rev().map(|&sum| sum as f32));
        }
        depths
    }

    #[test]
    fn columns_are_sums_of_all_their_places() {
        let samples: Vec<u8> = (0..60).map(|i| (i * 7919 % 256) as u8).collect();
        let placement = Placement::from_spacing([0.5, 0.75, 1.0]).unwrap();
        let grid = UniformGrid::new([3, 4, 5], samples, placement, Default::default()).unwrap();
        let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.1), ControlPoint::new(255.0, [1.0; 3], 0.9)];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let scene = Scene::new(grid.into(), transfer);
        let cut = Clip {
            crop: Some((DVec3::splat(0.2), DVec3::new(0.8, 9.0, 9.0))),
            planes: vec![Plane { normal: DVec3::Y, offset: 0.7 }],
        };
        // Along axes, in both senses, nearly so, and across all of them.
        let directions = [DVec3::X, -DVec3::Y, DVec3::Z, DVec3::new(1e-9, 1.0, -1e-17), DVec3::new(0.3, 1.0, 0.5)];
        for clip in [Clip::default(), cut] {
            let medium = SceneMedium::new(&scene, &clip, &Scattering::default()).unwrap();
            for towards in directions.map(DVec3::normalize) {
                let map = ShadowMap::new(&medium, towards, 0.25, &Control::default()).unwrap();
                let want = summed(&map, &medium);
                assert!(want.iter().any(|&depth| depth > 0.5), "{towards}: a map of nothing");
                let differing = want.iter().zip(&map.depths).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
                assert_eq!((differing, map.depths.len()), (0, want.len()), "{towards}");
            }
        }
    }
}
