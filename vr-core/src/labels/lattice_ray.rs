//! A ray in the index space of a lattice, and its crossings of the lattice's faces.

use glam::DVec3;

use super::label_map::LabelMap;
use crate::placement::Placement;
use crate::ray::Ray;

/// A ray in the index space of a lattice, with a bound on the rounding of its positions. Distances are world units behind an offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct LatticeRay {
    origin: DVec3,
    direction: DVec3,
    /// Bound on the error of each coordinate.
    error: DVec3,
}

/// A face that a ray crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossed {
    /// Distance.
    pub distance: f64,
    /// Bound on the error of the distance.
    pub error: f64,
    /// Axis that the face is across.
    pub axis: usize,
    /// Index coordinate of the face on that axis.
    pub at: f64,
}

impl LatticeRay {
    /// The ray in the index space of a placement; `offset` is the distance of its zero from the ray's own origin, and `farthest` the largest
    /// distance from there that is asked for.
    pub(super) fn new(ray: &Ray, placement: &Placement, offset: f64, farthest: f64) -> Self {
        let inverse = placement.inverse_axes();
        let base = (ray.origin - placement.origin()) + ray.direction * offset;
        let (origin, direction) = (inverse * base, inverse * ray.direction);
        // A few roundings each of the differences, of the products, and of the sum along the ray.
        let world = ray.origin.abs() + placement.origin().abs() + (2.0 * offset.abs() + farthest) * ray.direction.abs();
        let columns = [inverse.x_axis.abs(), inverse.y_axis.abs(), inverse.z_axis.abs()];
        let size = columns[0] * world.x + columns[1] * world.y + columns[2] * world.z;
        Self { origin, direction, error: 8.0 * f64::EPSILON * size }
    }

    /// Index-space position at a distance.
    #[inline]
    pub(super) fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }

    /// Middle of a stretch, and half its extent.
    pub(super) fn middle_and_half(&self, from: f64, to: f64) -> (DVec3, DVec3) {
        (self.at(0.5 * (from + to)), self.direction * (0.5 * (to - from)))
    }

    /// Bound on the sum of the errors of the three coordinates.
    pub(super) fn position_error(&self) -> f64 {
        self.error.element_sum()
    }

    fn crossed(&self, axis: usize, at: f64) -> Crossed {
        let rate = self.direction[axis];
        let distance = (at - self.origin[axis]) / rate;
        Crossed { distance, error: self.error[axis] / rate.abs() + f64::EPSILON * distance.abs(), axis, at }
    }

    /// Calls `each` with every face at a whole index coordinate, plus `shift`, that is crossed between two distances; axis by axis.
    pub(super) fn each_face(&self, shift: f64, [from, to]: [f64; 2], mut each: impl FnMut(Crossed)) {
        for axis in (0..3).filter(|&a| self.direction[a] != 0.0) {
            let place = |s: f64| self.origin[axis] + self.direction[axis] * s - shift;
            let (x0, x1) = (place(from), place(to));
            let (mut k, high) = (x0.min(x1).ceil(), x0.max(x1).floor());
            while k <= high {
                let face = self.crossed(axis, k + shift);
                if face.distance > from && face.distance < to {
                    each(face);
                }
                k += 1.0;
            }
        }
    }

    /// Bound on the error of the distance of the face, at whole index coordinates plus `shift`, that lies at a distance; 0 if none does.
    pub(super) fn face_error(&self, shift: f64, distance: f64) -> f64 {
        let mut largest = 0.0f64;
        for a in (0..3).filter(|&a| self.direction[a] != 0.0) {
            let (x, rounding) = (self.at(distance)[a] - shift, f64::EPSILON * distance.abs());
            let reach = 4.0 * (self.error[a] + self.direction[a].abs() * rounding);
            if (x - x.round()).abs() <= reach {
                largest = largest.max(self.error[a] / self.direction[a].abs() + rounding);
            }
        }
        largest
    }

    /// Calls `each` with index-space positions on both sides of every face between nearest voxels that the stretch runs along, to within its
    /// error: the voxels of either may be the nearest ones.
    pub(super) fn each_tie(&self, from: f64, to: f64, mut each: impl FnMut([DVec3; 2])) {
        let (middle, half) = self.middle_and_half(from, to);
        for a in 0..3 {
            let (off, x) = (self.error[a], middle[a] + 0.5);
            if half[a].abs() <= off && (x - x.round()).abs() <= off {
                let step = DVec3::AXES[a] * (2.0 * off);
                each([middle - step, middle + step]);
            }
        }
    }

    /// Calls `each` with every face between two voxels of a map at which the label's rank changes, between two distances and in order along the
    /// ray, with the ranks before and behind it.
    pub(super) fn each_change(&self, map: &LabelMap, [from, to]: [f64; 2], mut each: impl FnMut(Crossed, [u16; 2])) {
        // The part that lies among the voxels, which reach half a step beyond their lattice.
        let (mut start, mut end, mut entered) = (from, to, None);
        for a in 0..3 {
            let (low, high) = (-0.5, map.dims()[a] as f64 - 0.5);
            if self.direction[a] == 0.0 {
                if !(low..high).contains(&self.origin[a]) {
                    return;
                }
                continue;
            }
            let (near, far) = if self.direction[a] > 0.0 { (low, high) } else { (high, low) };
            let (near, far) = (self.crossed(a, near), self.crossed(a, far));
            if near.distance > start {
                (start, entered) = (near.distance, Some(near));
            }
            end = end.min(far.distance);
        }
        if start >= end {
            return;
        }
        // The voxel at the start, and on each axis the next face, its distance, and the number of voxels behind it. A distance that is multiplied and not divided
        // may be off in its last place: it orders faces, and no more.
        let (position, per_unit) = (self.at(start), self.direction.recip());
        let [nx, ny, _] = map.dims();
        let (mut voxel, mut face, mut next, mut behind) = ([0; 3], [0.0; 3], [f64::INFINITY; 3], [0; 3]);
        let forward = self.direction.to_array().map(|rate| rate > 0.0);
        for a in 0..3 {
            let last = map.dims()[a] - 1;
            voxel[a] = ((position[a] + 0.5).floor().max(0.0) as usize).min(last);
            if self.direction[a] != 0.0 {
                face[a] = voxel[a] as f64 + if forward[a] { 0.5 } else { -0.5 };
                next[a] = (face[a] - self.origin[a]) * per_unit[a];
                behind[a] = if forward[a] { last - voxel[a] } else { voxel[a] };
            }
        }
        let strides = [1, nx, nx * ny];
        let mut number = voxel[0] + strides[1] * voxel[1] + strides[2] * voxel[2];
        let mut rank = map.rank_of(number);
        if let Some(face) = entered
            && rank != map.background()
        {
            each(face, [map.background(), rank]);
        }
        // From voxel to voxel.
        loop {
            let axis = if next[0] <= next[1] { 0 } else { 1 };
            let axis = if next[2] < next[axis] { 2 } else { axis };
            if next[axis].is_nan() || next[axis] >= to {
                return;
            }
            let is_last = behind[axis] == 0;
            let last_rank = std::mem::replace(&mut rank, map.background());
            let at = face[axis];
            if !is_last {
                behind[axis] -= 1;
                if forward[axis] {
                    (number, face[axis]) = (number + strides[axis], at + 1.0);
                } else {
                    (number, face[axis]) = (number - strides[axis], at - 1.0);
                }
                next[axis] = (face[axis] - self.origin[axis]) * per_unit[axis];
                rank = map.rank_of(number);
            }
            if rank != last_rank {
                let crossed = self.crossed(axis, at);
                if crossed.distance > from && crossed.distance < to {
                    each(crossed, [last_rank, rank]);
                }
            }
            if is_last {
                return;
            }
        }
    }
}
