//! Selection of a volume from a file: one frame and one component of an array of any number of axes.

use std::path::Path;

use vr_core::{GridError, sample_count};

use crate::error::{FieldError, FileError};
use crate::read::ReadOptions;
use crate::scalar::ScalarType;

/// Role of an axis of a file: what its index counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Space,
    Frame,
    Component,
    /// Components that are red, green, blue and, of four, opacity.
    Color,
}

impl Role {
    /// Role of the components of a voxel in a format that has no word for colours: three or four bytes are one, as every program keeps pictures.
    pub fn of_components(count: usize, scalar: ScalarType) -> Self {
        if scalar == ScalarType::U8 && (3..=4).contains(&count) { Self::Color } else { Self::Component }
    }
}

/// An axis of the array in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    pub size: usize,
    pub role: Role,
}

/// The chosen numbers: `offset + x·strides[0] + y·strides[1] + z·strides[2]` of `total`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layout {
    pub dims: [usize; 3],
    pub strides: [usize; 3],
    pub offset: usize,
    /// Numbers in the file, all frames and components.
    pub total: usize,
    pub frames: usize,
    pub components: usize,
    /// True if the components of a voxel are a colour.
    pub is_color: bool,
}

impl Layout {
    /// Lays out the axes of a file, fastest first; exactly three of them run over space.
    pub fn new(path: &Path, axes: &[Axis], options: &ReadOptions) -> Result<Self, FileError> {
        let space: Vec<usize> = axes.iter().filter(|a| a.role == Role::Space).map(|a| a.size).collect();
        let dims: [usize; 3] = space.as_slice().try_into().map_err(|_| {
            FieldError::new("dimension", format_args!("{} axes of space", space.len()), "a volume has three")
                .in_file(path)
        })?;
        sample_count(dims).map_err(|e| FileError::new(path, e))?;
        let too_large = || FileError::new(path, GridError::Dims { dims });
        let total = axes.iter().try_fold(1usize, |n, a| n.checked_mul(a.size)).ok_or_else(too_large)?;

        let count = |role| axes.iter().filter(|a| a.role == role).map(|a| a.size).product::<usize>();
        let (frames, others) = (count(Role::Frame), count(Role::Component));
        let colors = count(Role::Color);
        let is_color = others == 1 && (3..=4).contains(&colors);
        let components = others.checked_mul(colors).ok_or_else(too_large)?;
        let mut frame = pick(path, "frame", options.frame, frames)?;
        let mut component = pick(path, "component", options.component, components)?;

        // An index over several axes of one role is taken apart, fastest axis first.
        let (mut strides, mut offset, mut stride, mut axis_of_space) = ([0; 3], 0, 1, 0);
        for axis in axes {
            match axis.role {
                Role::Space => {
                    strides[axis_of_space] = stride;
                    axis_of_space += 1;
                }
                Role::Frame => {
                    offset += frame % axis.size * stride;
                    frame /= axis.size;
                }
                Role::Component | Role::Color => {
                    offset += component % axis.size * stride;
                    component /= axis.size;
                }
            }
            stride *= axis.size;
        }
        Ok(Self { dims, strides, offset, total, frames, components, is_color })
    }

    /// Index of the first voxel along each axis of an array of that shape, the slowest first: 0 along those of space, and the chosen frame
    /// and component along the others.
    pub fn first_index(&self, shape: &[usize]) -> Vec<usize> {
        let mut rest = self.offset;
        let mut index: Vec<usize> = shape
            .iter()
            .rev()
            .map(|&size| {
                let at = rest % size;
                rest /= size;
                at
            })
            .collect();
        index.reverse();
        index
    }

    /// The same numbers with the axes of space in reverse: for files in which the last of the axes that they name is the fastest.
    pub fn reversed(self) -> Self {
        let reverse = |[a, b, c]: [usize; 3]| [c, b, a];
        Self { dims: reverse(self.dims), strides: reverse(self.strides), ..self }
    }

    /// The rows of all components together, where these are next to each other: as a volume that many times as wide.
    pub fn interleaved(self) -> Option<Self> {
        let ([nx, ny, nz], n) = (self.dims, self.components);
        let together = self.strides == [n, n * nx, n * nx * ny];
        together.then_some(Self { dims: [n * nx, ny, nz], strides: [1, n * nx, n * nx * ny], ..self })
    }

    /// Voxels of the volume.
    pub fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// The same volume where a decoder gives the chosen numbers alone, x fastest.
    pub fn dense(self) -> Self {
        let [nx, ny, _] = self.dims;
        Self { strides: [1, nx, nx * ny], offset: 0, total: self.count(), ..self }
    }

    /// True if the volume is one run of numbers, from `offset` on.
    pub fn is_contiguous(&self) -> bool {
        self.strides == [1, self.dims[0], self.dims[0] * self.dims[1]]
    }

    /// Picks the chosen numbers out of all of them.
    pub fn pick<T: Copy>(&self, all: &[T]) -> Vec<T> {
        let [nx, ny, nz] = self.dims;
        let [sx, sy, sz] = self.strides;
        let row = |z, y| all[self.offset + z * sz + y * sy..].iter().step_by(sx).take(nx).copied();
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| row(z, y))).collect()
    }
}

fn pick(path: &Path, what: &'static str, chosen: Option<usize>, count: usize) -> Result<usize, FileError> {
    match chosen {
        _ if count == 0 => Err(FieldError::new(format!("number of {what}s"), 0, "must be at least 1").in_file(path)),
        // The first of several, which the reader says.
        None => Ok(0),
        Some(i) if i < count => Ok(i),
        Some(i) => {
            Err(FieldError::new(what, i, format!("the file has {count} {what}(s), 0 to {}", count - 1)).in_file(path))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(list: &[(usize, Role)]) -> Vec<Axis> {
        list.iter().map(|&(size, role)| Axis { size, role }).collect()
    }

    #[test]
    fn picks_frame_and_component() {
        let axes =
            axes(&[(3, Role::Component), (2, Role::Space), (2, Role::Space), (2, Role::Space), (2, Role::Frame)]);
        let all: Vec<usize> = (0..48).collect();
        let o = ReadOptions { frame: Some(1), component: Some(2), ..Default::default() };
        let l = Layout::new(Path::new("x"), &axes, &o).unwrap();
        assert!(!l.is_contiguous());
        assert_eq!(l.pick(&all), (0..8).map(|i| 24 + 2 + 3 * i).collect::<Vec<_>>());
    }

    #[test]
    fn reversed_axes_pick_the_same_numbers_in_another_order() {
        // z runs fastest: 2 of them, then 3 of y, then 4 of x.
        let axes = axes(&[(2, Role::Space), (3, Role::Space), (4, Role::Space)]);
        let l = Layout::new(Path::new("x"), &axes, &ReadOptions::default()).unwrap().reversed();
        assert_eq!(l.dims, [4, 3, 2]);
        let picked = l.pick(&(0..24).collect::<Vec<_>>());
        let at = |x: usize, y: usize, z: usize| picked[x + 4 * (y + 3 * z)];
        assert_eq!((at(0, 0, 1), at(0, 1, 0), at(1, 0, 0), at(3, 2, 1)), (1, 2, 6, 23));
    }

    #[test]
    fn takes_the_first_of_several() {
        let axes = axes(&[(2, Role::Space), (2, Role::Space), (2, Role::Space), (5, Role::Frame)]);
        let at = |frame| Layout::new(Path::new("x"), &axes, &ReadOptions { frame, ..Default::default() });
        assert_eq!(at(None).unwrap().offset, 0);
        let message = at(Some(5)).unwrap_err().to_string();
        assert!(message.contains("5 frame(s), 0 to 4"), "{message}");
        let last = at(Some(4)).unwrap();
        assert!(last.is_contiguous());
        assert_eq!(last.offset, 32);
    }

    #[test]
    fn refuses_products_that_overflow() {
        let axes =
            axes(&[(2, Role::Space), (2, Role::Space), (2, Role::Space), (usize::MAX, Role::Frame), (4, Role::Frame)]);
        assert!(Layout::new(Path::new("x"), &axes, &ReadOptions::default()).is_err());
    }
}
