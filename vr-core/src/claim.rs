//! What a renderer documents of its convergence and of its errors.

use crate::options::Options;

/// A claim: as an option gets smaller, errors fall like a power of it.
///
/// Errors are against the canonical pixel, or against that of the renderer's own filter where it has one
/// ([`Model::Filtered`](crate::Model::Filtered)).
#[derive(Clone, Debug, PartialEq)]
pub struct OrderClaim {
    /// Short and unique within the renderer.
    pub name: String,
    /// Options held fixed: those that keep rounding, tables and early termination out of the way.
    pub options: Options,
    /// The option that is halved again and again: a length in voxels.
    pub key: &'static str,
    /// The value from which on it is halved.
    pub coarsest: f64,
    /// RMSE below which rounding decides, and no order can be seen.
    pub floor: f64,
    /// The exponents.
    pub orders: Orders,
}

/// How fast errors fall, by what is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders {
    /// In the option, where field and transfer function are continuous.
    pub smooth: f64,
    /// In the option, where the transfer function jumps.
    pub jumps: f64,
    /// In the spacing of the samples of a smooth field, the option being held fixed in voxels.
    pub grid: f64,
    /// In the size of a pixel: of the light that falls on a patch of the picture.
    pub pixels: f64,
}

/// The error that a renderer allows itself in a picture, relative to max(1, largest magnitude of the picture).
///
/// Where a wall or a shell decides between everything and nothing, the largest error says little: no picture can be off by more
/// than all. The root mean square does, since it says how many rays are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DocumentedError {
    /// Of every component of every pixel.
    Max(f64),
    /// Root mean square over all of them.
    Rmse(f64),
}

impl DocumentedError {
    /// The number, whatever it is of.
    pub fn value(self) -> f64 {
        match self {
            Self::Max(error) | Self::Rmse(error) => error,
        }
    }

    /// Of a picture's largest error and its RMSE, the one that this is about.
    pub fn choose(self, max: f64, rmse: f64) -> f64 {
        match self {
            Self::Max(_) => max,
            Self::Rmse(_) => rmse,
        }
    }
}

/// A bound of the largest error.
impl From<f64> for DocumentedError {
    fn from(error: f64) -> Self {
        Self::Max(error)
    }
}
