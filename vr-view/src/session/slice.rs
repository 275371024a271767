//! Slice: the values of a scene's field on a plane across an axis of the world, and the labels there.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use vr_core::{Control, ParameterError, RenderError, Volume};

use super::label_look::LabelLooks;
use super::value_at::fill_values;

/// Most pixels along a side of a slice.
pub const MAX_SLICE_SIDE: u32 = 1024;

/// Slice that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SliceQuery {
    /// Axis that the slice lies across: 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// World coordinate of the slice on that axis.
    pub at: f64,
    /// Pixels along the longer side.
    pub side: u32,
}

/// Values of a plane, sampled at the centres of square pixels, as nearly as the volume's box allows.
#[derive(Clone, Debug, Serialize)]
pub struct Slice {
    /// Axis that it lies across.
    pub axis: usize,
    /// World coordinate on that axis.
    pub at: f64,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// World position of the upper left corner.
    pub corner: DVec3,
    /// World vector from the left edge to the right one: a patient's left is on the right, and so is the back.
    pub right: DVec3,
    /// World vector from the upper edge to the lower one.
    pub down: DVec3,
    /// The labels that occur, in the order of [`Self::label_indices`].
    pub labels: Vec<PlaceLabel>,
    /// Values of the pixels, row by row from the top; NaN in vacuum.
    #[serde(skip)]
    pub values: Vec<f64>,
    /// For each pixel, the number of its label among [`Self::labels`], from 1; 0 where there is none. Empty without labels.
    #[serde(skip)]
    pub label_indices: Vec<u16>,
}

/// A label, as it is told at a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceLabel {
    /// The label.
    pub number: i32,
    /// Its name, if a file gives one.
    pub name: Option<String>,
    /// Linear RGB.
    pub color: [f64; 3],
}

/// Field and labels at one place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// World position.
    pub at: DVec3,
    /// The value; `None` in vacuum.
    pub value: Option<f64>,
    /// The label, if there are labels, and it is not the background.
    pub label: Option<PlaceLabel>,
}

/// Directions to the right and up in slices across an axis.
fn directions(axis: usize, patient: bool) -> (DVec3, DVec3) {
    let side = |axis: DVec3| if patient { -axis } else { axis };
    match axis {
        0 => (side(DVec3::Y), DVec3::Z),
        1 => (side(DVec3::X), DVec3::Z),
        _ => (side(DVec3::X), DVec3::Y),
    }
}

impl Slice {
    /// Samples a volume, row by row, until it is cancelled.
    pub(super) fn of(
        volume: &Volume,
        labels: Option<LabelLooks<'_>>,
        patient: bool,
        &SliceQuery { axis, at, side }: &SliceQuery,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let wrong = |field: &str, found: String, allowed| ParameterError { field: field.to_owned(), found, allowed };
        if axis > 2 {
            return Err(wrong("slice.axis", axis.to_string(), "must be 0, 1 or 2").into());
        }
        if !at.is_finite() {
            return Err(wrong("slice.at", at.to_string(), "must be finite").into());
        }
        if !(1..=MAX_SLICE_SIDE).contains(&side) {
            return Err(wrong("slice.side", side.to_string(), "must be 1 to 1024 pixels").into());
        }
        // Cover the box by pixels that are as square as whole numbers of them can be.
        let (low, high) = volume.bounds();
        let (right, up) = directions(axis, patient);
        let extents = [right, up].map(|way| (high - low).dot(way.abs()));
        let pixel = extents[0].max(extents[1]) / f64::from(side);
        let size =
            extents.map(|extent| if pixel > 0.0 { (extent / pixel).round().clamp(1.0, f64::from(side)) } else { 1.0 });
        let size = size.map(|n| n as u32);
        // Begin at the upper left.
        let mut corner = DVec3::ZERO;
        for way in [right, -up] {
            let axis = way.abs().max_position();
            corner[axis] = if way[axis] > 0.0 { low[axis] } else { high[axis] };
        }
        corner[axis] = at;
        let (right, down) = (right * extents[0], -up * extents[1]);
        // Sample row by row.
        let [width, height] = size.map(|n| n as usize);
        let mut slice = Self {
            axis,
            at,
            size,
            corner,
            right,
            down,
            labels: Vec::new(),
            values: vec![f64::NAN; width * height],
            label_indices: Vec::new(),
        };
        let mut places = vec![DVec3::ZERO; width];
        for (y, row) in slice.values.chunks_mut(width).enumerate() {
            control.check()?;
            let start = corner + down * ((y as f64 + 0.5) / height as f64);
            for (x, place) in places.iter_mut().enumerate() {
                *place = start + right * ((x as f64 + 0.5) / width as f64);
            }
            fill_values(volume, &places, row);
            if let Some(looks) = labels {
                for &place in &places {
                    let Some(number) = looks.number_at(place) else {
                        slice.label_indices.push(0);
                        continue;
                    };
                    let known = slice.labels.iter().position(|known| known.number == number);
                    let index = known.unwrap_or_else(|| {
                        slice.labels.extend(looks.look(number));
                        slice.labels.len() - 1
                    });
                    slice.label_indices.push(index as u16 + 1);
                }
            }
        }
        Ok(slice)
    }

    /// World position of a pixel's centre.
    pub fn place(&self, [x, y]: [u32; 2]) -> DVec3 {
        let [width, height] = self.size.map(f64::from);
        self.corner + self.right * ((f64::from(x) + 0.5) / width) + self.down * ((f64::from(y) + 0.5) / height)
    }
}
