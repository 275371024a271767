//! Hashes of what volumes, pictures and files hold.

use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};
use vr_core::cells::CellValues;
use vr_core::{AmrGrid, CellMesh, GridVolume, PointMixing, PointSet, RectilinearGrid, Volume, parallel, with_grid};

use crate::error::FileError;
use crate::regular_file;

/// Bytes that are hashed by themselves, so that several threads can share the work.
const BLOCK: usize = 1 << 20;

/// Hash, in 64 hexadecimal digits, of what a volume is, wherever it comes from: of a grid its size, type, placement, calibration and
/// voxels; of a rectilinear grid its axes and values; of points their kernel, positions, radii, weights, values, mixing and colours. `None` for other volumes. The filter does not count. A grid keeps its
/// hash, so that it is found once.
///
/// It is the SHA-256 of a line of text and of the SHA-256 of each MiB, which takes as many threads as there are.
///
/// # Examples
/// ```
/// use vr_core::{Filter, Volume, phantom};
///
/// let [fog, blobs] = ["fog", "blobs"].map(|name| {
///     let phantom = phantom::by_name(name).unwrap();
///     Volume::from(phantom::sample::<f32>(phantom.as_ref(), [5; 3]).unwrap())
/// });
/// let hash = vr_io::volume_hash(&fog).unwrap();
/// assert_eq!(hash.len(), 64);
/// assert_eq!(vr_io::volume_hash(&fog.with_filter(Filter::Nearest)), Some(hash.clone()));
/// assert_ne!(vr_io::volume_hash(&blobs), Some(hash));
/// ```
pub fn volume_hash(volume: &Volume) -> Option<String> {
    match volume {
        Volume::Grid(grid) => Some(grid.derived().get((), || KeptHash(grid_hash("grid", grid, &[]))).0.clone()),
        Volume::Color(colors) => {
            let channels = colors.channels();
            let parts = channels.each_ref().map(|channel| bytemuck::cast_slice(channel.samples));
            Some(grid_hash("colours", colors.values(), &parts))
        }
        Volume::Points(points) => Some(points_hash(points)),
        Volume::Cells(mesh) => Some(cells_hash(mesh)),
        Volume::Rectilinear(grid) => Some(rectilinear_hash(grid)),
        Volume::Amr(grid) => Some(amr_hash(grid)),
        Volume::Field(_) => None,
    }
}

/// Hash that is kept with a grid.
struct KeptHash(String);

fn grid_hash(kind: &str, grid: &GridVolume, others: &[&[u8]]) -> String {
    let (placement, calibration) = (grid.placement(), grid.calibration());
    // The shortest digits that give a number back tell all of its bits.
    let header = format!(
        "{kind} {:?} {} {:?} {:?} {:?} {:?}",
        grid.dims(),
        grid.voxel_type(),
        placement.origin().to_array(),
        placement.axes().to_cols_array(),
        calibration.slope,
        calibration.intercept
    );
    with_grid!(grid.values(), voxels => {
        let values: &[u8] = bytemuck::cast_slice(voxels.samples());
        digest(&header, &[&[values], others].concat())
    })
}

fn points_hash(points: &PointSet) -> String {
    let positions: Vec<f64> = points.positions().iter().flat_map(|p| p.to_array()).collect();
    let columns = [points.radii(), points.weights(), points.values()].map(bytemuck::cast_slice);
    let mut header = format!("points {} {:?}", points.count(), points.kernel());
    let mut parts = vec![bytemuck::cast_slice(&positions), columns[0], columns[1], columns[2]];
    // Sums without colours keep the hash that they had before there were others.
    if points.mixing() != PointMixing::Sum {
        header += &format!(" {}", points.mixing());
    }
    if let Some(colors) = points.colors() {
        header += " colours";
        parts.push(bytemuck::cast_slice(colors));
    }
    digest(&header, &parts)
}

fn cells_hash(mesh: &CellMesh) -> String {
    let positions: Vec<f64> = mesh.vertices().iter().flat_map(|p| p.to_array()).collect();
    let (kind, values) = match mesh.values() {
        CellValues::Vertices(values) => ("vertices", values),
        CellValues::Cells(values) => ("cells", values),
    };
    let header = format!("mesh of {} cells, values of {kind}", mesh.cells().len());
    let cells = bytemuck::cast_slice(mesh.cells());
    digest(&header, &[bytemuck::cast_slice(&positions), cells, bytemuck::cast_slice(values)])
}

fn rectilinear_hash(grid: &RectilinearGrid) -> String {
    let axes = grid.axes().each_ref().map(|axis| bytemuck::cast_slice(axis.places()));
    let calibration = grid.lattice().calibration();
    let header = format!("rectilinear {:?} {:?} {:?}", grid.dims(), calibration.slope, calibration.intercept);
    with_grid!(grid.lattice().values(), values => {
        digest(&header, &[axes[0], axes[1], axes[2], bytemuck::cast_slice(values.samples())])
    })
}

fn amr_hash(grid: &AmrGrid) -> String {
    let ratios: Vec<_> = (0..grid.levels()).map(|level| grid.ratio_of(level)).collect();
    let (origin, spacing) = (grid.origin().to_array(), grid.spacing_of(0).to_array());
    let centring = grid.centring().name();
    let header = format!("adaptive mesh, values of {centring} {origin:?} {spacing:?} {ratios:?}");
    let blocks = grid.blocks();
    let places: Vec<i64> =
        blocks.iter().flat_map(|b| [&[b.level as i64][..], &b.first, &b.dims.map(|n| n as i64)].concat()).collect();
    let values = blocks.iter().map(|b| bytemuck::cast_slice(&b.values));
    let parts: Vec<&[u8]> = std::iter::once(bytemuck::cast_slice(&places)).chain(values).collect();
    digest(&header, &parts)
}

/// SHA-256 of a file's bytes, in 64 hexadecimal digits, as `sha256sum` prints it.
///
/// # Errors
/// A [`FileError`] naming a file that cannot be read.
pub fn file_hash(path: impl AsRef<Path>) -> Result<String, FileError> {
    let path = path.as_ref();
    let hash = || -> io::Result<String> {
        let (mut file, mut hash, mut block) = (regular_file::open(path)?, Sha256::new(), vec![0; BLOCK]);
        loop {
            match file.read(&mut block)? {
                0 => return Ok(hexadecimal(&hash.finalize())),
                read => hash.update(&block[..read]),
            }
        }
    };
    hash().map_err(|e| FileError::new(path, e))
}

/// Returns the SHA-256 of a text and, for each part, of its length and the SHA-256 of each of its blocks.
pub(crate) fn digest(header: &str, parts: &[&[u8]]) -> String {
    let mut hash = Sha256::new();
    hash.update((header.len() as u64).to_le_bytes());
    hash.update(header);
    for part in parts {
        let blocks: Vec<&[u8]> = part.chunks(BLOCK).collect();
        hash.update((part.len() as u64).to_le_bytes());
        for block in parallel::collect(blocks.len(), |i| <[u8; 32]>::from(Sha256::digest(blocks[i]))) {
            hash.update(block);
        }
    }
    hexadecimal(&hash.finalize())
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::{Calibration, Placement, PointKernel, UniformGrid};

    use super::*;

    fn grid(change: impl Fn(&mut [i16], &mut [f64; 3], &mut Calibration)) -> String {
        let (mut voxels, mut spacing, mut calibration) = (vec![3i16; 24], [1.0; 3], Calibration::default());
        change(&mut voxels, &mut spacing, &mut calibration);
        let placement = Placement::from_spacing(spacing).unwrap();
        let grid = UniformGrid::new([4, 3, 2], voxels, placement, calibration).unwrap();
        volume_hash(&grid.into()).unwrap()
    }

    #[test]
    fn whatever_a_grid_is_counts() {
        let own = grid(|_, _, _| {});
        assert_eq!(own, grid(|_, _, _| {}));
        assert_ne!(own, grid(|voxels, _, _| voxels[23] = 4));
        assert_ne!(own, grid(|_, spacing, _| spacing[2] = 1.0 + f64::EPSILON));
        assert_ne!(own, grid(|_, _, calibration| calibration.intercept = 1.0));
        let unsigned = UniformGrid::new(
            [4, 3, 2],
            vec![3u16; 24],
            Placement::from_spacing([1.0; 3]).unwrap(),
            Calibration::default(),
        );
        assert_ne!(Some(own), volume_hash(&unsigned.unwrap().into()));
    }

    #[test]
    fn whatever_points_are_counts() {
        let hash = |weight: f32, kernel| {
            let set = PointSet::new(vec![DVec3::ONE], vec![1.0], vec![weight], vec![2.0], kernel).unwrap();
            volume_hash(&set.into()).unwrap()
        };
        let own = hash(1.0, PointKernel::Cone);
        assert_eq!(own, hash(1.0, PointKernel::Cone));
        assert_ne!(own, hash(1.5, PointKernel::Cone));
        assert_ne!(own, hash(1.0, PointKernel::Gaussian));
    }

    #[test]
    fn files_have_the_usual_sum() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        std::fs::write(&path, "abc").unwrap();
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(file_hash(&path).unwrap(), sum);
        assert!(file_hash(folder.path().join("y")).unwrap_err().to_string().contains("y: "));
    }

    #[test]
    fn blocks_and_parts_have_their_places() {
        let bytes: Vec<u8> = (0..3 * BLOCK / 2).map(|i| (i % 251) as u8).collect();
        let (a, b) = bytes.split_at(BLOCK);
        let all = [digest("x", &[&bytes]), digest("x", &[a, b]), digest("x", &[b, a]), digest("y", &[&bytes])];
        assert!((0..4).all(|i| (0..i).all(|j| all[i] != all[j])));
    }
}
