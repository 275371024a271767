//! Sixteen rays at once against one at a time.

use glam::DVec3;
use vr_core::cells::CellValues;
use vr_core::{
    Camera, CellMesh, Clip, Control, ControlPoint, Light, OpacityRule, Plane, Prepared, Rendered, Scene, Shading,
    TransferFunction, View,
};
use vr_physics::check::strategies::uneven_cubes;

use crate::marcher::CellMarcher;
use crate::prepared::PreparedMarcher;

/// Numbers in [0, 1) from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// Cubes of six cells over a unit cube, with some cells left out, far from the world's origin.
fn mesh(random: &mut Random, n: usize) -> CellMesh {
    let (vertices, cells) = uneven_cubes([n; 3], 0.15, n as u64);
    let vertices: Vec<DVec3> = vertices.into_iter().map(|v| v + DVec3::new(300.0, -20.0, 5.0)).collect();
    let cells = cells.into_iter().filter(|_| random.next() < 0.9).collect();
    let values = vertices.iter().map(|_| 1e3 + random.next()).collect();
    CellMesh::new(vertices, cells, CellValues::Vertices(values)).unwrap()
}

/// Peaks, jumps and walls.
fn transfer(random: &mut Random, most: f64, rule: OpacityRule) -> TransferFunction {
    let mut values: Vec<f64> = (0..7).map(|_| 1e3 + random.next()).collect();
    values.sort_by(f64::total_cmp);
    values[3] = values[2];
    let point = |value| {
        let opacity = if random.next() < 0.3 { 0.0 } else { (1.3 * random.next()).min(1.0) * most };
        ControlPoint::new(value, [random.next(), random.next(), random.next()], opacity)
    };
    TransferFunction::new(values.into_iter().map(point).collect(), rule, 0.1).unwrap()
}

/// Both pictures differ by the rounding of `f32`, which counts where extinction is steep, and by the rule of four points.
#[test]
fn packets_draw_what_single_rays_draw() {
    let control = Control::default();
    let mut worst = (0.0, 0.0f64);
    for seed in 0..24 {
        let mut random = Random(seed);
        let mesh = mesh(&mut random, 3 + seed as usize % 5);
        let rule = if seed % 3 == 0 { OpacityRule::Extinction } else { OpacityRule::Power };
        let most = [0.02, 0.3, 1.0][seed as usize / 2 % 3];
        let mut scene = Scene::new(mesh.into(), transfer(&mut random, most, rule));
        if seed % 4 == 1 {
            scene.shading = Some(Shading::default().into());
            scene.lights =
                vec![Light::default(), Light { direction: Some(DVec3::new(0.3, 1.0, -0.5)), color: [0.9, 0.5, 0.2] }];
        }
        let fov = (seed % 2 == 0).then_some(10.0 + 60.0 * random.next());
        let camera = Camera::framing(scene.volume.bounds(), 360.0 * random.next(), 160.0 * random.next() - 80.0, fov);
        let clip = Clip {
            crop: None,
            planes: vec![Plane { normal: DVec3::new(0.5, -0.3, 0.4), offset: 158.0 + 0.6 * random.next() }],
        };
        let view = View {
            supersampling: 1 + seed as u32 % 6,
            clip: if seed % 4 == 0 { clip } else { Clip::default() },
            ..View::new(camera, [27, 21])
        };
        let prepared = || PreparedMarcher::new(CellMarcher { termination: 1.0 }, &scene, &control).unwrap();
        let draw = |mut prepared: PreparedMarcher| -> Rendered { prepared.render(&view, &control).unwrap() };
        let (fast, plain) = (draw(prepared()), draw(prepared().without_packets()));
        assert!(plain.stats.counts.samples > 0);
        let (mut error, mut off) = (0.0f64, 0.0f64);
        let depths = fast.frame.depth().unwrap().iter().zip(plain.frame.depth().unwrap());
        for ((a, b), (d, e)) in fast.frame.pixels().iter().zip(plain.frame.pixels()).zip(depths) {
            error = (0..4).map(|c| f64::from(a[c] - b[c]).abs()).fold(error, f64::max);
            // Half the light may be left over a long way: there the depth is ill-conditioned, and infinite on one side of it.
            if d.is_finite() && e.is_finite() {
                off += f64::from(d - e).abs();
            }
        }
        off /= fast.frame.pixels().len() as f64;
        println!("{seed}: {error:.1e}, depth {off:.1e}, {} steps", fast.stats.counts.samples);
        // Normals that turn within a cell are followed to a highlight's width by both.
        let allowed = if scene.shading.is_some() { 2e-4 } else { 1e-5 };
        worst = (f64::max(worst.0, error / allowed), worst.1.max(off));
    }
    assert!(worst.0 < 1.0 && worst.1 < 1e-4, "{worst:?}");
}
