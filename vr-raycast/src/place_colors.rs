//! Colours of the places of a volume, by which the light of the transfer function is multiplied.

use vr_core::{ColorGrid, Real, Volume};

use crate::source::{FieldBox, Source};

/// Colours of places.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PlaceColors<'a> {
    /// Those of the voxels of a grid.
    Grid(&'a ColorGrid),
    /// Those of a field.
    Field(&'a FieldBox),
}

impl<'a> PlaceColors<'a> {
    /// Returns the colours of a volume and its field; `None` where all is as the transfer function has it.
    pub(crate) fn of(volume: &'a Volume, source: &'a Source) -> Option<Self> {
        match (volume.colors(), source) {
            (Some(colors), _) => Some(Self::Grid(colors)),
            (None, Source::Other(field)) if volume.has_colors() => Some(Self::Field(field)),
            (None, _) => None,
        }
    }

    /// Returns the colour of a place in index space; white in vacuum, where nothing shows it.
    pub(crate) fn at<R: Real>(&self, position: [R; 3]) -> [R; 3] {
        match self {
            Self::Grid(colors) => colors.color(position),
            Self::Field(field) => field.color(position).map_or([R::ONE; 3], |color| color.map(R::from_f64)),
        }
    }
}
