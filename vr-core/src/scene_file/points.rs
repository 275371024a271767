//! What `[volume]` says of scattered points.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::ParameterError;
use crate::point_set::PointSet;
use crate::volume::Volume;

use super::VolumeSection;

/// `[volume] columns`: which columns or arrays of a file hold what. What is absent is found by the names that are commonly used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PointColumns {
    /// x, y and z; of text alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[String; 3]>,
    /// How far a kernel reaches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<String>,
    /// Half of that: h of smoothed particle hydrodynamics.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothing_length: Option<String>,
    /// Mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass: Option<String>,
    /// Mass per volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<String>,
    /// Weights, which are mass by density otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<String>,
}

/// The largest number of points that a scene file may hold inline.
pub const MOST_INLINE_POINTS: usize = 4096;

/// Position, radius, weight, value.
type Row = [f64; 6];

/// Writes points as numbers.
///
/// # Errors
/// More of them than a scene file may hold.
pub(super) fn inline_points(points: &PointSet) -> Result<VolumeSection, ParameterError> {
    if points.count() > MOST_INLINE_POINTS {
        let allowed = "at most 4096 points can be written into a scene file";
        return Err(ParameterError::new("volume.points", points.count(), allowed));
    }
    let row = |k: usize| -> Row {
        let p = points.positions()[k];
        [p.x, p.y, p.z, points.radii()[k].into(), points.weights()[k].into(), points.values()[k].into()]
    };
    Ok(VolumeSection {
        points: Some((0..points.count()).map(row).collect()),
        kernel: Some(points.kernel()),
        ..VolumeSection::default()
    })
}

impl VolumeSection {
    /// The volume of inline `points`.
    ///
    /// # Errors
    /// More points than a scene file may hold, or what [`PointSet::new`] refuses.
    pub fn inline_points(&self) -> Result<Volume, ParameterError> {
        let rows = self.points.as_deref().unwrap_or_default();
        if rows.len() > MOST_INLINE_POINTS {
            return Err(ParameterError::new("volume.points", rows.len(), "inline points are at most 4096"));
        }
        let column = |i: usize| rows.iter().map(|row| row[i] as f32).collect();
        let positions = rows.iter().map(|&[x, y, z, ..]| DVec3::new(x, y, z)).collect();
        let set = PointSet::new(positions, column(3), column(4), column(5), self.kernel.unwrap_or_default());
        set.map(Volume::from).map_err(|e| ParameterError {
            field: "volume.points".to_owned(),
            found: e.to_string(),
            allowed: "must be rows of x, y, z, radius, weight, value",
        })
    }

    /// The keys set that only scattered points have.
    pub fn keys_of_points(&self) -> impl Iterator<Item = &'static str> {
        let keys = [
            ("volume.kernel", self.kernel.is_some()),
            ("volume.radius", self.radius.is_some()),
            ("volume.radius_scale", self.radius_scale.is_some()),
            ("volume.value", self.value.is_some()),
            ("volume.columns", self.columns.is_some()),
            ("volume.count", self.count.is_some()),
        ];
        keys.into_iter().filter(|key| key.1).map(|key| key.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point_kernel::PointKernel;

    #[test]
    fn points_come_back_as_they_were() {
        let positions = vec![DVec3::new(0.1, 2.0 / 3.0, -1e6), DVec3::ZERO];
        let (radii, weights, values) = (vec![0.1f32, 3.0], vec![1.0 / 3.0, 2.0], vec![-1e-20, 7.5]);
        let set = PointSet::new(positions, radii, weights, values, PointKernel::Cone).unwrap();
        let back = inline_points(&set).unwrap().inline_points().unwrap();
        let back = back.points().unwrap();
        assert_eq!((back.positions(), back.radii(), back.kernel()), (set.positions(), set.radii(), set.kernel()));
        assert_eq!((back.weights(), back.values()), (set.weights(), set.values()));
    }

    #[test]
    fn nonsense_is_refused() {
        let section = |rows: Vec<Row>| VolumeSection { points: Some(rows), ..VolumeSection::default() };
        let error = section(vec![[0.0, 0.0, 0.0, -1.0, 1.0, 1.0]]).inline_points().unwrap_err().to_string();
        assert!(error.contains("point 0 has the radius -1"), "{error}");
        let error = section(vec![[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]; 4097]).inline_points().unwrap_err().to_string();
        assert!(error.contains("4097"), "{error}");
        assert!(section(Vec::new()).inline_points().is_err());
    }
}
