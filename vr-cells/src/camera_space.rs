//! A mesh as a camera sees it, and rays that are its axis.

use glam::{DMat3, DVec3};
use vr_core::cells::CellValues;
use vr_core::{CellMesh, ParameterError, Ray, View};

/// Numbers that a ray needs at a vertex: the value, and the gradient's components where something is shaded.
pub(crate) type Attributes<const N: usize> = [f64; N];

/// Returns the gradient among the attributes; `None` if they are the value alone.
#[inline]
pub(crate) fn gradient<const N: usize>(attributes: &Attributes<N>) -> Option<[f64; 3]> {
    match attributes[..] {
        [_, x, y, z] => Some([x, y, z]),
        _ => None,
    }
}

/// A vertex in the camera's axes: to the right, up and ahead of the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraVertex<const N: usize> {
    pub(crate) at: [f64; 3],
    pub(crate) attributes: Attributes<N>,
}

/// A camera's axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CameraSpace {
    eye: DVec3,
    to_camera: DMat3,
    perspective: bool,
}

impl CameraSpace {
    pub(crate) fn new(view: &View) -> Result<Self, ParameterError> {
        let perspective = view.camera.projection.is_perspective();
        Ok(Self { eye: view.camera.eye, to_camera: view.camera.frame()?.transpose(), perspective })
    }

    /// All vertices of a mesh. `N` is 1 for values alone, 4 for values and gradients.
    pub(crate) fn vertices<const N: usize>(&self, mesh: &CellMesh) -> Vec<CameraVertex<N>> {
        let gradients = if N == 4 { mesh.gradients() } else { None };
        let vertex = |i: usize| {
            let mut attributes = [0.0; N];
            if let CellValues::Vertices(values) = mesh.values() {
                attributes[0] = values[i];
            }
            if let (Some(gradients), [_, rest @ ..]) = (gradients, &mut attributes[..]) {
                rest.copy_from_slice(&gradients[i].to_array());
            }
            CameraVertex { at: (self.to_camera * (mesh.vertices()[i] - self.eye)).to_array(), attributes }
        };
        (0..mesh.vertices().len()).map(vertex).collect()
    }

    /// The shear that makes a ray of the view the axis.
    pub(crate) fn axis(&self, ray: &Ray) -> Axis {
        if self.perspective {
            let [x, y, z] = (self.to_camera * ray.direction).to_array();
            Axis { shift: [0.0; 2], slope: [x / z, y / z], length: 1.0 / z }
        } else {
            let [x, y, _] = (self.to_camera * (ray.origin - self.eye)).to_array();
            Axis { shift: [x, y], slope: [0.0; 2], length: 1.0 }
        }
    }
}

/// A ray as the axis of sheared space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    shift: [f64; 2],
    slope: [f64; 2],
    /// World distance along the ray for each unit of depth.
    pub(crate) length: f64,
}

/// A vertex in sheared space: the ray is where x and y are 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedVertex<const N: usize> {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) depth: f64,
    pub(crate) attributes: Attributes<N>,
}

impl Axis {
    #[inline(always)]
    pub(crate) fn shear<const N: usize>(&self, vertex: &CameraVertex<N>) -> ShearedVertex<N> {
        let [x, y, depth] = vertex.at;
        ShearedVertex {
            x: x - self.shift[0] - self.slope[0] * depth,
            y: y - self.shift[1] - self.slope[1] * depth,
            depth,
            attributes: vertex.attributes,
        }
    }

    /// The same ray, moved a little aside.
    pub(crate) fn nudged(&self, by: [f64; 2]) -> Self {
        Self { shift: [self.shift[0] + by[0], self.shift[1] + by[1]], ..*self }
    }
}

/// On which side of the axis the edge from a to b passes: positive if it goes around it counterclockwise. Swapping a and b changes the sign and no digit.
///
/// The sign is exact, and all digits but the last: of a ray that runs along faces, all that it passes is decided by such differences.
#[inline(always)]
pub(crate) fn side<const N: usize>(a: &ShearedVertex<N>, b: &ShearedVertex<N>) -> f64 {
    let (forth, back) = (a.x * b.y, a.y * b.x);
    let difference = forth - back;
    if difference.abs() > CLOSE * forth.abs() {
        return difference;
    }
    exact_difference([a.x, b.y], [a.y, b.x])
}

/// Part of two products by which they differ so much that rounding is a millionth of it.
const CLOSE: f64 = 1e-10;

/// The difference of two products that are nearly the same, with what their rounding loses: the difference of the rounded ones is exact (Sterbenz).
#[inline(never)]
fn exact_difference(forth: [f64; 2], back: [f64; 2]) -> f64 {
    // Halves of a number, whose products are exact (Veltkamp), and the rest of a product (Dekker 1971).
    let halves = |x: f64| {
        let wide = x * 134_217_729.0;
        let high = wide - (wide - x);
        [high, x - high]
    };
    let product = |[x, y]: [f64; 2]| {
        let (rounded, [a, b], [c, d]) = (x * y, halves(x), halves(y));
        [rounded, ((a * c - rounded) + a * d + b * c) + b * d]
    };
    let ([forth, forth_rest], [back, back_rest]) = (product(forth), product(back));
    (forth - back) + (forth_rest - back_rest)
}

/// True if the edge from one vertex to another, whose side this is, goes around the axis counterclockwise. If the axis meets it, the axis is taken to lie a little to
/// the right, and less above; if that does not tell, because both vertices are in one place, their numbers do. Swapping the vertices turns the answer, so that of
/// the cells around an edge each ray has one, and no ray is lost between them, nor takes a way that is none among faces that it runs along.
#[inline(always)]
pub(crate) fn goes_around<const N: usize>(side: f64, [a, b]: [&ShearedVertex<N>; 2], names: [u32; 2]) -> bool {
    if side != 0.0 {
        return side > 0.0;
    }
    let (right, above) = (a.y - b.y, b.x - a.x);
    if right != 0.0 {
        return right > 0.0;
    }
    if above != 0.0 { above > 0.0 } else { names[0] < names[1] }
}
