//! Meshes and scenes of the tests, and the error of a renderer on them.

use glam::DVec3;
use vr_core::cells::{CellMesh, CellValues};
use vr_core::{
    Camera, Compositing, Control, ControlPoint, Model, OpacityRule, Renderer, Scene, TransferFunction, View,
};
use vr_physics::Reference;
use vr_physics::check::strategies::uneven_cubes;

/// n³ cubes of six cells over the unit cube, inner vertices moved, without the cells whose middle is where `hole` says.
pub fn mesh(n: usize, jitter: f64, of_cells: bool, hole: impl Fn(DVec3) -> bool) -> CellMesh {
    let (moved, cells) = uneven_cubes([n; 3], jitter, 1);
    let waves = |p: DVec3| 0.5 + 0.3 * (7.0 * p.x + 3.0 * p.y).sin() + 0.2 * (9.0 * p.z - 4.0 * p.y).cos();
    let middle = |cell: &[u32; 4]| cell.iter().map(|&v| moved[v as usize]).sum::<DVec3>() * 0.25;
    let cells: Vec<[u32; 4]> = cells.into_iter().filter(|cell| !hole(middle(cell))).collect();
    let values = if of_cells {
        CellValues::Cells(cells.iter().map(|cell| waves(middle(cell))).collect())
    } else {
        CellValues::Vertices(moved.iter().map(|&v| waves(v)).collect())
    };
    CellMesh::new(moved, cells, values).unwrap()
}

pub fn transfer(opacity: f64) -> TransferFunction {
    let p = ControlPoint::new;
    let points = vec![
        p(0.1, [0.1, 0.2, 0.9], 0.0),
        p(0.45, [0.9, 0.3, 0.1], 0.4 * opacity),
        p(0.45, [0.2, 0.9, 0.1], 0.1 * opacity),
        p(0.6, [0.2, 0.8, 0.3], 0.0),
        p(1.0, [1.0, 1.0, 0.9], opacity),
    ];
    TransferFunction::new(points, OpacityRule::Power, 0.1).unwrap()
}

/// Largest error of a renderer against the reference, less its bound, and the root mean square.
pub fn errors(renderer: &dyn Renderer, scene: &Scene, view: &View) -> (f64, f64) {
    let control = Control::default();
    let frame = renderer.prepare(scene, &control).unwrap().render(view, &control).unwrap().frame;
    let exact = Reference::default().solve(scene, view, &Model::Canonical, &control).unwrap();
    let (mut largest, mut sum) = (0.0f64, 0.0);
    for (i, (found, exact)) in frame.pixels().iter().zip(&exact.pixels).enumerate() {
        for c in 0..4 {
            let off = ((f64::from(found[c]) - exact.rgba[c]).abs() - exact.certainty.value()).max(0.0);
            sum += off * off;
            if off > largest {
                println!("pixel {i}: {found:?} for {:?}", exact.rgba);
                largest = off;
            }
        }
    }
    (largest, (sum / (4 * frame.pixels().len()) as f64).sqrt())
}

pub fn view(yaw: f64, pitch: f64, fov: Option<f64>) -> View {
    View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), yaw, pitch, fov), [24, 20])
}

#[allow(dead_code, reason = "each test file compiles the whole module")]
pub const OPERATORS: [Compositing; 6] = [
    Compositing::Over,
    Compositing::Maximum,
    Compositing::Minimum,
    Compositing::Average,
    Compositing::First { threshold: 0.55 },
    Compositing::Accumulate { level: 0.5 },
];
