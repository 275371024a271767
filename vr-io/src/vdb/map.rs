//! The transform of a grid: from voxels to its world.

use glam::{DMat3, DVec3};

use crate::error::FileErrorKind;

use super::bytes::Bytes;

/// An affine map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Map {
    origin: DVec3,
    axes: DMat3,
}

impl Map {
    pub fn read(bytes: &mut Bytes<'_>) -> Result<Self, FileErrorKind> {
        let kind = bytes.text()?;
        let mut vector = || Ok::<_, FileErrorKind>(DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?));
        Ok(match kind.as_str() {
            "UniformScaleMap" | "ScaleMap" => {
                let scale = vector()?;
                // The size of a voxel, and inverses: nothing new.
                for _ in 0..4 {
                    vector()?;
                }
                Self { origin: DVec3::ZERO, axes: DMat3::from_diagonal(scale) }
            }
            "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
                let (origin, scale) = (vector()?, vector()?);
                for _ in 0..4 {
                    vector()?;
                }
                Self { origin, axes: DMat3::from_diagonal(scale) }
            }
            "TranslationMap" => Self { origin: vector()?, axes: DMat3::IDENTITY },
            "AffineMap" | "UnitaryMap" => {
                // Row vectors are multiplied from the left: each row is a step.
                let mut rows = [DVec3::ZERO; 4];
                for row in &mut rows {
                    *row = DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?);
                    bytes.f64()?;
                }
                Self { origin: rows[3], axes: DMat3::from_cols(rows[0], rows[1], rows[2]) }
            }
            other => {
                let allowed = "must be affine: scales, translations, AffineMap or UnitaryMap";
                return Err(FileErrorKind::field("transform", other, allowed));
            }
        })
    }

    pub fn to_world(self, index: [f64; 3]) -> DVec3 {
        self.origin + self.axes * DVec3::from_array(index)
    }

    /// Steps from voxel to voxel.
    pub fn axes(self) -> DMat3 {
        self.axes
    }
}
