//! Volumes that stand in a scene file themselves.

use glam::{DMat3, DVec3};
use vr_core::{
    AnyGrid, GridError, GridVolume, ParameterError, PointError, PointKernel, PointMixing, PointSet, UniformGrid,
    Volume, Voxel, with_grid,
};

use crate::scalar::ScalarType;

use super::volume_section::{GridDescription, VolumeSource};

/// Largest number of voxels that a scene file may hold.
const MAX_SAMPLES: usize = 64 * 64 * 64;

/// Largest number of points that a scene file may hold.
const MAX_POINTS: usize = 4096;

/// Position, radius, weight, value.
type Row = [f64; 6];

/// Writes a volume as numbers.
///
/// # Errors
/// More of them than a scene file may hold.
pub(super) fn inline_volume(volume: &Volume) -> Result<VolumeSource, ParameterError> {
    match volume {
        Volume::Grid(u) => inline_grid(u),
        Volume::Points(p) => inline_points(p),
        Volume::Color(_) | Volume::Cells(_) | Volume::Rectilinear(_) | Volume::Amr(_) | Volume::Field(_) => {
            let allowed = "only uniform grids and points can be written into a scene file";
            Err(ParameterError { field: "volume".into(), found: volume.kind().to_string(), allowed })
        }
    }
}

fn inline_grid(u: &GridVolume) -> Result<VolumeSource, ParameterError> {
    if u.dims().iter().product::<usize>() > MAX_SAMPLES {
        let allowed = "only uniform grids of up to 64^3 voxels can be written into a scene file";
        return Err(ParameterError::new("volume.dims", u.dims(), allowed));
    }
    fn numbers<T: Voxel>(g: &UniformGrid<T>) -> Vec<f64> {
        g.samples().iter().map(|s| f64::from(s.to_f32())).collect()
    }
    let axes = u.placement().axes();
    let spacing = u.placement().spacing().to_array();
    let calibration = u.calibration();
    let unit = |c: DVec3, s: f64| (c / s).to_array();
    let direction = [unit(axes.x_axis, spacing[0]), unit(axes.y_axis, spacing[1]), unit(axes.z_axis, spacing[2])];
    let grid = GridDescription {
        dims: Some(u.dims()),
        scalar: Some(u.voxel_type().into()),
        spacing: Some(spacing),
        origin: Some(u.placement().origin().to_array()),
        direction: (direction != DMat3::IDENTITY.to_cols_array_2d()).then_some(direction),
        slope: (calibration.slope != 1.0).then_some(calibration.slope),
        intercept: (calibration.intercept != 0.0).then_some(calibration.intercept),
    };
    Ok(VolumeSource::Grid { data: with_grid!(u.values(), g => numbers(g)), grid })
}

fn inline_points(points: &PointSet) -> Result<VolumeSource, ParameterError> {
    if points.count() > MAX_POINTS {
        let allowed = "must be at most 4096 to be written into a scene file";
        return Err(ParameterError::new("volume.points", points.count(), allowed));
    }
    let row = |k: usize| -> Row {
        let p = points.positions()[k];
        [p.x, p.y, p.z, points.radii()[k].into(), points.weights()[k].into(), points.values()[k].into()]
    };
    Ok(VolumeSource::Points {
        points: (0..points.count()).map(row).collect(),
        kernel: Some(points.kernel()),
        mixing: Some(points.mixing()).filter(|mixing| *mixing != PointMixing::default()),
        colors: points.colors().map(|colors| colors.iter().map(|color| color.map(f64::from)).collect()),
    })
}

/// Makes a grid of inline voxels.
///
/// # Errors
/// No `dims`, a type that memory does not hold, a number that its type cannot hold, or what [`UniformGrid::new`] refuses.
pub(super) fn grid(data: &[f64], grid: &GridDescription) -> Result<Volume, ParameterError> {
    if data.len() > MAX_SAMPLES {
        return Err(ParameterError::new("volume.data", data.len(), "must be at most 64^3 inline numbers"));
    }
    Ok(match grid.scalar.unwrap_or(ScalarType::F32) {
        ScalarType::U8 => AnyGrid::from(typed_grid::<u8>(data, grid, |x| x as u8)?),
        ScalarType::I8 => AnyGrid::from(typed_grid::<i8>(data, grid, |x| x as i8)?),
        ScalarType::U16 => AnyGrid::from(typed_grid::<u16>(data, grid, |x| x as u16)?),
        ScalarType::I16 => AnyGrid::from(typed_grid::<i16>(data, grid, |x| x as i16)?),
        ScalarType::F32 => AnyGrid::from(typed_grid::<f32>(data, grid, |x| x as f32)?),
        wider => {
            let allowed = "must be, of inline data, one of u8, i8, u16, i16, f32";
            return Err(ParameterError::new("volume.type", wider.name(), allowed));
        }
    }
    .into())
}

fn typed_grid<T: Voxel>(
    data: &[f64],
    grid: &GridDescription,
    cast: fn(f64) -> T,
) -> Result<UniformGrid<T>, ParameterError> {
    let missing =
        || ParameterError { field: "volume.dims".into(), found: "nothing".into(), allowed: "inline data need dims" };
    let dims = grid.dims.ok_or_else(missing)?;
    let convert = |(i, &x): (usize, &f64)| {
        let t = cast(x);
        // Integers must be exact; f32 rounds, as any file would, and is not to make an infinity of a number.
        let held = f64::from(t.to_f32());
        if T::TYPE.is_integer() && held != x || x.is_finite() && !held.is_finite() {
            let allowed = "must be a number that volume.type can hold";
            return Err(ParameterError::new(format!("volume.data[{i}]"), x, allowed));
        }
        Ok(t)
    };
    let samples = data.iter().enumerate().map(convert).collect::<Result<Vec<T>, _>>()?;
    let grid_error = |e: GridError| ParameterError {
        field: "volume".to_owned(),
        found: e.to_string(),
        allowed: "must describe a grid that can be",
    };
    UniformGrid::new(dims, samples, grid.placement().map_err(grid_error)?, grid.calibration()).map_err(grid_error)
}

/// Makes a volume of points.
///
/// # Errors
/// More points than a scene file may hold, or what [`PointSet::new`] refuses.
pub(super) fn points(
    rows: &[Row],
    kernel: PointKernel,
    mixing: PointMixing,
    colors: Option<&[[f64; 3]]>,
) -> Result<Volume, ParameterError> {
    if rows.len() > MAX_POINTS {
        return Err(ParameterError::new("volume.points", rows.len(), "must be at most 4096 inline points"));
    }
    let column = |i: usize| rows.iter().map(|row| row[i] as f32).collect();
    let positions = rows.iter().map(|&[x, y, z, ..]| DVec3::new(x, y, z)).collect();
    let wrong = |key: &str, allowed| {
        let field = format!("volume.{key}");
        move |e: PointError| ParameterError { field, found: e.to_string(), allowed }
    };
    let rows = "must be rows of x, y, z, radius, weight, value";
    let set = PointSet::new(positions, column(3), column(4), column(5), kernel).map_err(wrong("points", rows))?;
    let set = set.with_mixing(mixing).map_err(wrong("points", rows))?;
    match colors {
        None => Ok(set.into()),
        Some(colors) => {
            let colors = colors.iter().map(|color| color.map(|c| c as f32)).collect();
            let allowed = "must be a list of one [red, green, blue] for each point, in linear light";
            set.with_colors(colors).map(Volume::from).map_err(wrong("point_colors", allowed))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_as_they_were() {
        let positions = vec![DVec3::new(0.1, 2.0 / 3.0, -1e6), DVec3::ZERO];
        let (radii, weights, values) = (vec![0.1f32, 3.0], vec![1.0 / 3.0, 2.0], vec![-1e-20, 7.5]);
        let set = PointSet::new(positions, radii, weights, values, PointKernel::Cone).unwrap();
        let set =
            set.with_mixing(PointMixing::Mean).unwrap().with_colors(vec![[0.1, 0.0, 1.0], [1.0 / 3.0; 3]]).unwrap();
        let VolumeSource::Points { points: rows, kernel, mixing, colors } = inline_points(&set).unwrap() else {
            panic!("points")
        };
        let back = points(&rows, kernel.unwrap(), mixing.unwrap(), colors.as_deref()).unwrap();
        let back = back.points().unwrap();
        assert_eq!((back.positions(), back.radii(), back.kernel()), (set.positions(), set.radii(), set.kernel()));
        assert_eq!((back.weights(), back.values()), (set.weights(), set.values()));
        assert_eq!((back.mixing(), back.colors()), (set.mixing(), set.colors()));
    }

    #[test]
    fn nonsense_is_refused() {
        let all =
            |rows: &[Row], mixing, colors: Option<&[[f64; 3]]>| points(rows, PointKernel::default(), mixing, colors);
        let error = |rows: &[Row]| all(rows, PointMixing::Sum, None).unwrap_err().to_string();
        let message = error(&[[0.0, 0.0, 0.0, -1.0, 1.0, 1.0]]);
        assert!(message.contains("point 0: found the radius -1"), "{message}");
        let message = error(&[[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]; 4097]);
        assert!(message.contains("4097"), "{message}");
        assert!(error(&[]).contains("no point"));
        let row = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let message = all(&[row], PointMixing::Sum, Some(&[])).unwrap_err().to_string();
        assert!(message.contains("volume.point_colors") && message.contains("0 colours for 1 points"), "{message}");
        let weightless = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        let message = all(&[weightless], PointMixing::Mean, None).unwrap_err().to_string();
        assert!(message.contains("point 0: found the weight 0"), "{message}");
    }
}
