//! Coloured grid of the components of an image: red, green, blue, and opacity where there is a fourth.

use super::ColorGrid;
use crate::any_grid::AnyGrid;
use crate::error::GridError;
use crate::filter::Filter;
use crate::grid::{Calibration, UniformGrid, sample_count};
use crate::grid_volume::GridVolume;
use crate::parallel;
use crate::placement::Placement;
use crate::transfer::srgb_to_linear;
use crate::voxel::{Voxel, VoxelType};

/// Source of the values of a coloured grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ColorValue {
    /// Values that were given beside the colours.
    OfItsOwn,
    /// The fourth component.
    Opacity,
    /// The largest of red, green and blue.
    Largest,
    /// White less the smallest of red, green and blue: the distance from a white background.
    Darkness,
}

impl ColorValue {
    /// The source in words: `the largest component`.
    pub fn name(self) -> &'static str {
        match self {
            Self::OfItsOwn => "a value of its own",
            Self::Opacity => "the opacity",
            Self::Largest => "the largest component",
            Self::Darkness => "white less the smallest component",
        }
    }
}

/// A background is white where its smallest component is at least this part of white.
const WHITE_FROM: f32 = 0.7;

impl ColorGrid {
    /// The colours of an image, red, green and blue of the first voxel first, x fastest, and of four components the last one opacity. Integers are
    /// sRGB, of which the largest of their type is white; floats are linear light from 0 to 1, and what lies beyond counts as 0 or 1.
    ///
    /// The value of a voxel, in the numbers of the components, is its opacity where that differs between voxels; else its largest
    /// component, or white less its smallest one where most voxels at the faces of the box are nearly white.
    ///
    /// Red, green and blue do not contain the opacity (it is not premultiplied). A voxel of opacity 0 has no colour that could be seen:
    /// it gets the mean of its visible neighbours', so that no dark seam comes from it.
    ///
    /// # Errors
    /// [`GridError`] for dims that make no grid, and [`GridError::Length`] where the components are not `count`, 3 or 4, for each voxel.
    pub fn from_components<T: Voxel>(
        dims: [usize; 3],
        components: &[T],
        count: usize,
        placement: Placement,
    ) -> Result<Self, GridError>
    where
        AnyGrid: From<UniformGrid<T>>,
    {
        let voxels = sample_count(dims)?;
        if !(3..=4).contains(&count) || voxels.checked_mul(count) != Some(components.len()) {
            let expected = voxels.saturating_mul(count.clamp(3, 4));
            return Err(GridError::Length { dims, expected, found: components.len() });
        }
        // Choose the value: opacity says nothing where it is the same everywhere.
        let alpha = |i: usize| components[count * i + 3];
        let value = if count == 4 && (1..voxels).any(|i| alpha(i) != alpha(0)) {
            ColorValue::Opacity
        } else if has_white_faces(dims, components, count) {
            ColorValue::Darkness
        } else {
            ColorValue::Largest
        };
        let white = white_of::<T>();
        let of_voxel = |i: usize| -> T {
            let rgb = &components[count * i..][..3];
            let pick = |better: fn(&T, &T) -> bool| {
                rgb[1..].iter().fold(rgb[0], |best, c| if better(c, &best) { *c } else { best })
            };
            match value {
                ColorValue::Opacity => alpha(i),
                ColorValue::Darkness => pick(|a, b| a < b),
                ColorValue::Largest | ColorValue::OfItsOwn => pick(|a, b| a > b),
            }
        };
        let calibration = match value {
            // Stored as it is: white less it is a calibration.
            ColorValue::Darkness => Calibration { slope: -1.0, intercept: f64::from(white) },
            _ => Calibration::default(),
        };
        let values: Vec<T> = parallel::collect(voxels, of_voxel);
        let grid = UniformGrid::new(dims, values, placement, calibration)?;
        // Bring each channel to linear light.
        let encoding = Encoding::new::<T>();
        let mut channels: [Vec<u16>; 3] =
            std::array::from_fn(|c| parallel::collect(voxels, |i| encoding.linear(components[count * i + c])));
        if value == ColorValue::Opacity {
            bleed(dims, &mut channels, &|i| alpha(i).to_f32().max(0.0));
        }
        let colors = Self::new(GridVolume::new(grid.into(), Filter::default()), channels)?;
        Ok(Self { value, ..colors })
    }
}

/// Stored number of white.
fn white_of<T: Voxel>() -> f32 {
    match T::TYPE {
        VoxelType::U8 => 255.0,
        VoxelType::I8 => 127.0,
        VoxelType::U16 => 65535.0,
        VoxelType::I16 => 32767.0,
        VoxelType::F32 => 1.0,
    }
}

/// True if more than half of the voxels at the faces of the box are nearly white.
fn has_white_faces<T: Voxel>(dims: [usize; 3], components: &[T], count: usize) -> bool {
    let limit = WHITE_FROM * white_of::<T>();
    let (mut faces, mut bright) = (0usize, 0usize);
    let [nx, ny, nz] = dims;
    for z in 0..nz {
        for y in 0..ny {
            let inner = z > 0 && z + 1 < nz && y > 0 && y + 1 < ny;
            for x in (0..nx).step_by(if inner { nx - 1 } else { 1 }) {
                let rgb = &components[count * ((z * ny + y) * nx + x)..][..3];
                faces += 1;
                bright += usize::from(rgb.iter().all(|c| c.to_f32() >= limit));
            }
        }
    }
    2 * bright > faces
}

/// Map from a stored component to linear light.
enum Encoding {
    /// Light of each number that an integer type has, from its smallest on.
    Table(Vec<u16>, f32),
    Linear,
}

impl Encoding {
    fn new<T: Voxel>() -> Self {
        let (first, white) = match T::TYPE {
            VoxelType::F32 => return Self::Linear,
            VoxelType::U8 | VoxelType::U16 => (0.0, white_of::<T>()),
            VoxelType::I8 | VoxelType::I16 => (-white_of::<T>() - 1.0, white_of::<T>()),
        };
        let light = |k: usize| stored(srgb_to_linear(f64::from(((first + k as f32) / white).max(0.0))));
        Self::Table((0..=(white - first) as usize).map(light).collect(), first)
    }

    fn linear<T: Voxel>(&self, component: T) -> u16 {
        match self {
            Self::Table(light, first) => light[(component.to_f32() - first) as usize],
            Self::Linear => stored(f64::from(component.to_f32())),
        }
    }
}

/// Stored number of linear light: 0 for NaN.
fn stored(light: f64) -> u16 {
    (light.clamp(0.0, 1.0) * f64::from(ColorGrid::WHITE)).round() as u16
}

/// Gives each voxel of no opacity the mean colour of its visible neighbours, weighted by their opacity. Neighbours are all that share a cell with it: no
/// cell in which something is visible has a corner without a colour then.
fn bleed(dims: [usize; 3], channels: &mut [Vec<u16>; 3], opacity: &(dyn Fn(usize) -> f32 + Sync)) {
    let [nx, ny, nz] = dims;
    let around = |k: usize, n: usize| k.saturating_sub(1)..(k + 2).min(n);
    let mean = |i: usize| -> Option<[u16; 3]> {
        if opacity(i) > 0.0 {
            return None;
        }
        let (x, y, z) = (i % nx, i / nx % ny, i / (nx * ny));
        let (mut total, mut sums) = (0.0, [0.0; 3]);
        for z in around(z, nz) {
            for y in around(y, ny) {
                for j in around(x, nx).map(|x| (z * ny + y) * nx + x) {
                    let weight = f64::from(opacity(j));
                    total += weight;
                    for (sum, channel) in sums.iter_mut().zip(&*channels) {
                        *sum += weight * f64::from(channel[j]);
                    }
                }
            }
        }
        (total > 0.0).then(|| sums.map(|sum| (sum / total).round() as u16))
    };
    let means = parallel::collect(nx * ny * nz, mean);
    for (i, mean) in means.into_iter().enumerate() {
        if let Some(mean) = mean {
            (0..3).for_each(|c| channels[c][i] = mean[c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid<T: Voxel>(components: &[T], count: usize) -> ColorGrid
    where
        AnyGrid: From<UniformGrid<T>>,
    {
        ColorGrid::from_components([3, 2, 2], components, count, Placement::from_spacing([1.0; 3]).unwrap()).unwrap()
    }

    #[test]
    fn integers_are_srgb_and_floats_are_light() {
        let middle = |grid: ColorGrid| grid.color([0.0f64; 3])[1];
        // Within half a stored number.
        let close = |a: f64, b: f64| (a - b).abs() <= 0.5 / f64::from(ColorGrid::WHITE);
        let bytes: Vec<u8> = [10, 128, 0].repeat(12);
        assert!(close(middle(grid(&bytes, 3)), srgb_to_linear(128.0 / 255.0)));
        let words: Vec<u16> = [10, 40000, 0].repeat(12);
        assert!(close(middle(grid(&words, 3)), srgb_to_linear(40000.0 / 65535.0)));
        let floats: Vec<f32> = [0.1, 0.25, f32::NAN].repeat(12);
        assert!(close(middle(grid(&floats, 3)), 0.25));
        let beyond: Vec<f32> = [7.0, f32::INFINITY, -3.0].repeat(12);
        assert_eq!(grid(&beyond, 3).color([0.5f64; 3]), [1.0, 1.0, 0.0]);
        let signed: Vec<i16> = [-5, 32767, 0].repeat(12);
        assert_eq!(grid(&signed, 3).color([0.5f64; 3]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn the_value_is_what_tells_things_from_the_background() {
        let at = |i: usize, background: u8| if i == 5 { [200, 40, 90] } else { [background; 3] };
        let image = |background: u8| (0..12).flat_map(|i| at(i, background)).collect::<Vec<u8>>();
        let dark = grid(&image(0), 3);
        assert_eq!((dark.value_source(), dark.values().value_range()), (ColorValue::Largest, Some((0.0, 200.0))));
        let bright = grid(&image(250), 3);
        assert_eq!((bright.value_source(), bright.values().value_range()), (ColorValue::Darkness, Some((5.0, 215.0))));
        // An opacity that is the same everywhere says nothing.
        let opaque: Vec<u8> = (0..12).flat_map(|i| at(i, 0).into_iter().chain([255])).collect();
        assert_eq!(grid(&opaque, 4).value_source(), ColorValue::Largest);
        let wrong = ColorGrid::from_components([3, 2, 2], &opaque, 3, Placement::from_spacing([1.0; 3]).unwrap());
        assert!(matches!(wrong, Err(GridError::Length { expected: 36, found: 48, .. })));
    }

    #[test]
    fn what_is_clear_takes_its_neighbours_colour() {
        let at = |i: usize| if i.is_multiple_of(3) { [255, 0, 0, 90] } else { [0, 0, 0, 0] };
        let grid = grid(&(0..12).flat_map(at).collect::<Vec<u8>>(), 4);
        assert_eq!((grid.value_source(), grid.values().value_range()), (ColorValue::Opacity, Some((0.0, 90.0))));
        assert_eq!(grid.color([0.7f64, 0.5, 0.5]), [1.0, 0.0, 0.0], "beside what is red");
        assert_eq!(grid.color([2.0f64, 0.5, 0.5]), [0.0; 3], "far from it");
    }
}
