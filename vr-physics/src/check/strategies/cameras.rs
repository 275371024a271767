//! Random cameras and clips. They are placed in the volume's own box: 0 to 1 along each axis of the grid, or of the bounds of other volumes.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{Camera, Clip, Plane, Projection, Volume};

/// A camera apart from the volume that it looks at.
#[derive(Clone, Debug)]
pub(super) enum Viewpoint {
    /// A view, orthographic or perspective, from one place in the box's coordinates towards another.
    Generic { eye: [f64; 3], target: [f64; 3], up: usize, fov: Option<f64>, zoom: f64 },
    /// A view from ten to a million diagonals away, the volume filling the picture.
    Far { direction: [f64; 3], decades: f64, perspective: bool, zoom: f64 },
    /// An orthographic view along an axis of a lattice, the image centre on a lattice line, two pixels a voxel.
    AlongAxis { axis: usize, backwards: bool, rows: u32 },
    /// An orthographic view, nearly parallel to a face of the box and in it.
    Grazing { axis: usize, tilt: f64, upper: bool },
    /// A view along an axis of the world, straight at the first of scattered points.
    AtPoint { axis: usize, backwards: bool, perspective: bool },
}

impl Viewpoint {
    /// `rows` of pixels are given so that rays meet lattice lines.
    pub fn camera(&self, volume: &Volume, rows: u32) -> Camera {
        match *self {
            Self::Generic { eye, target, up, fov, zoom } => {
                let world = |p: [f64; 3]| place(volume, p.into());
                let diagonal = diagonal(volume);
                let (eye, target) = (world(eye), world(target));
                // Degenerate draws (an eye on its target) look from a corner instead.
                let eye = if (eye - target).length() > 1e-3 * diagonal { eye } else { target + DVec3::ONE * diagonal };
                let projection = match fov {
                    Some(fov) => Projection::Perspective { fov },
                    None => Projection::Orthographic { height: zoom * diagonal },
                };
                Camera { eye, target, up: upright(target - eye, up), projection }
            }
            Self::Far { direction, decades, perspective, zoom } => {
                let (target, diagonal) = (place(volume, DVec3::splat(0.5)), diagonal(volume));
                let distance = libm::pow(10.0, decades);
                let direction = DVec3::from(direction).normalize();
                let projection = if perspective {
                    Projection::Perspective { fov: (2.0 * libm::atan(0.5 * zoom / distance)).to_degrees() }
                } else {
                    Projection::Orthographic { height: zoom * diagonal }
                };
                let eye = target - direction * (distance * diagonal);
                Camera { eye, target, up: upright(direction, 0), projection }
            }
            Self::AlongAxis { axis, backwards, .. } => {
                let (target, columns) = lattice(volume);
                let along = columns[axis] * if backwards { -10.0 } else { 10.0 };
                let up = columns[(axis + 1) % 3];
                let projection = Projection::Orthographic { height: 0.5 * f64::from(rows) * up.length() };
                Camera { eye: target - along, target, up, projection }
            }
            Self::Grazing { axis, tilt, upper } => {
                let (_, columns) = lattice(volume);
                let diagonal = diagonal(volume);
                let mut target = DVec3::splat(0.5);
                target[axis] = if upper { 1.0 } else { 0.0 };
                let target = place(volume, target);
                let along = columns[(axis + 1) % 3].normalize();
                // Up leaves the face, so that rows of pixels lie above, in and below it.
                let up = along.cross(columns[(axis + 2) % 3]).normalize();
                let eye = target - (along + up * tilt) * diagonal;
                Camera { eye, target, up, projection: Projection::Orthographic { height: 0.5 * diagonal } }
            }
            Self::AtPoint { axis, backwards, perspective } => {
                let points = volume.points().expect("only points are looked at one by one");
                let (target, radius) = (points.positions()[0], f64::from(points.radii()[0]));
                let along = DVec3::AXES[axis] * if backwards { -4.0 } else { 4.0 };
                let projection = if perspective {
                    Projection::Perspective { fov: 30.0 }
                } else {
                    Projection::Orthographic { height: 2.5 * radius }
                };
                Camera { eye: target - along, target, up: DVec3::AXES[(axis + 1) % 3], projection }
            }
        }
    }

    /// The size of the picture that is wanted, or the nearest at which rays meet what the viewpoint wants them to.
    pub fn size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        match *self {
            Self::AlongAxis { rows, .. } => [width, rows],
            // An odd number of pixels: the middle one looks at the point itself.
            Self::AtPoint { .. } => [width | 1, height | 1],
            Self::Generic { .. } | Self::Far { .. } | Self::Grazing { .. } => [width, height],
        }
    }
}

/// A place in the volume's box, by fractions of its sides; the bounds are the box where there is no grid.
fn place(volume: &Volume, p: DVec3) -> DVec3 {
    match volume.grid() {
        Some(grid) => {
            let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
            grid.placement().to_world(p * last)
        }
        None => {
            let (low, high) = volume.bounds();
            low + (high - low) * p
        }
    }
}

fn diagonal(volume: &Volume) -> f64 {
    (place(volume, DVec3::ONE) - place(volume, DVec3::ZERO)).length()
}

/// A point of the volume's lattice near the middle, and the lattice's steps along its axes: of an adaptive mesh those of its finest level, and of a
/// rectilinear grid the mean ones.
fn lattice(volume: &Volume) -> (DVec3, [DVec3; 3]) {
    let along_axes = |steps: DVec3| [0, 1, 2].map(|a| DVec3::AXES[a] * steps[a]);
    match volume {
        Volume::Amr(mesh) => {
            let (origin, spacing) = (mesh.origin(), mesh.finest_spacing());
            let middle = place(volume, DVec3::splat(0.5));
            (origin + ((middle - origin) / spacing).round() * spacing, along_axes(spacing))
        }
        Volume::Rectilinear(grid) => {
            let axes = grid.axes();
            let middle = DVec3::from_array(axes.each_ref().map(|axis| axis.places()[(axis.places().len() - 1) / 2]));
            (middle, along_axes(DVec3::from_array(axes.each_ref().map(|axis| axis.mean_step()))))
        }
        _ => {
            let grid = volume.grid().expect("only volumes with a lattice are seen along its axes");
            let middle = grid.dims().map(|n| ((n - 1) / 2) as f64);
            let axes = grid.placement().axes();
            (grid.placement().to_world(middle.into()), [axes.x_axis, axes.y_axis, axes.z_axis])
        }
    }
}

/// A world axis that is not parallel to the view: the wanted one, unless the view is too close to it.
fn upright(view: DVec3, wanted: usize) -> DVec3 {
    let view = view.normalize();
    let axes = [DVec3::Y, DVec3::X, DVec3::Z];
    let mut tries = (0..3).map(|i| axes[(wanted + i) % 3]);
    tries.find(|a| view.cross(*a).length() > 0.1).expect("no view is parallel to three axes")
}

pub(super) fn viewpoint() -> impl Strategy<Value = Viewpoint> {
    prop_oneof![
        5 => generic(),
        2 => (0usize..3, any::<bool>(), 1u32..=8)
            .prop_map(|(axis, backwards, rows)| Viewpoint::AlongAxis { axis, backwards, rows }),
        1 => (0usize..3, prop_oneof![Just(0.0), -1e-6..1e-6, -1e-3..1e-3], any::<bool>())
            .prop_map(|(axis, tilt, upper)| Viewpoint::Grazing { axis, tilt, upper }),
    ]
}

/// Viewpoints anywhere within three boxes, the box's own inside included.
pub(super) fn generic() -> impl Strategy<Value = Viewpoint> {
    let eye = prop_oneof![
        4 => [-2.0..3.0, -2.0..3.0, 1.5..3.0],
        1 => [-2.0..3.0, -2.0..3.0, -2.0..3.0],
        1 => [0.05..0.95, 0.05..0.95, 0.05..0.95],
    ];
    let inside = || 0.2..0.8;
    let fov = proptest::option::weighted(0.5, 20.0..110.0);
    (eye, [inside(), inside(), inside()], 0usize..3, fov, 0.3..1.5)
        .prop_map(|(eye, target, up, fov, zoom)| Viewpoint::Generic { eye, target, up, fov, zoom })
}

/// Viewpoints far away, ten to a million diagonals.
pub(super) fn far() -> impl Strategy<Value = Viewpoint> {
    ([-1.0..1.0, -1.0..1.0, 0.1..1.0], 1.0..=6.0, any::<bool>(), 0.5..1.2)
        .prop_map(|(direction, decades, perspective, zoom)| Viewpoint::Far { direction, decades, perspective, zoom })
}

/// Viewpoints inside the volume.
pub(super) fn inside() -> impl Strategy<Value = Viewpoint> {
    let within = || 0.05..0.95;
    let eye = [within(), within(), within()];
    let target = [-0.5..1.5, -0.5..1.5, -0.5..1.5];
    (eye, target, 0usize..3, proptest::option::weighted(0.7, 20.0..110.0), 0.3..1.5)
        .prop_map(|(eye, target, up, fov, zoom)| Viewpoint::Generic { eye, target, up, fov, zoom })
}

/// Any camera that looks at a volume: orthographic and perspective, from inside and outside, along the axes of the grid with
/// rays in the faces of cells, and nearly parallel to a face of the box.
pub fn camera(volume: Volume) -> impl Strategy<Value = Camera> {
    viewpoint().prop_map(move |v| v.camera(&volume, v.size([8; 2])[1]))
}

/// A camera from outside or inside whose rays have nothing in common with the grid.
pub fn generic_camera(volume: Volume) -> impl Strategy<Value = Camera> {
    generic().prop_map(move |v| v.camera(&volume, 8))
}

/// Crops and planes apart from a volume.
#[derive(Clone, Debug)]
pub(super) struct Cuts {
    /// Lower corner and extent, in fractions of the bounds.
    crop: Option<([f64; 3], [f64; 3])>,
    /// Normal, and a point of the plane in fractions of the bounds.
    planes: Vec<([f64; 3], [f64; 3])>,
}

impl Cuts {
    pub fn of_volume(&self, volume: &Volume) -> Clip {
        let (low, high) = volume.bounds();
        let at = |p: [f64; 3]| low + (high - low) * DVec3::from(p);
        let plane = |&(normal, point): &([f64; 3], [f64; 3])| {
            let normal = DVec3::from(normal) + DVec3::new(0.0, 0.0, 1e-3);
            Plane { normal, offset: normal.dot(at(point)) }
        };
        let crop = self.crop.map(|(corner, extent)| {
            let low_corner = at(corner);
            (low_corner, low_corner + (high - low) * DVec3::from(extent))
        });
        Clip { crop, planes: self.planes.iter().map(plane).collect() }
    }
}

pub(super) fn cuts() -> impl Strategy<Value = Cuts> {
    let corner = [-0.2..0.6, -0.2..0.6, -0.2..0.6];
    let extent = [0.2..1.2, 0.2..1.2, 0.2..1.2];
    let crop = proptest::option::weighted(0.25, (corner, extent));
    let normal = [-1.0..1.0, -1.0..1.0, -1.0..1.0];
    let plane = (normal, [0.2..0.8, 0.2..0.8, 0.2..0.8]);
    let planes = prop_oneof![3 => Just(Vec::new()), 1 => vec(plane, 1..=2)];
    (crop, planes).prop_map(|(crop, planes)| Cuts { crop, planes })
}

/// Usually none; a crop box, up to two planes, or both.
pub fn clip(volume: Volume) -> impl Strategy<Value = Clip> {
    cuts().prop_map(move |c| c.of_volume(&volume))
}
