//! Changes of pictures as a volume turns: brightness and jumps, in parallel projection.
//!
//! `cargo run --release -p vr-shearwarp --example turntable -- [KEY=VALUE ...]`; the keys and their defaults, which
//! take one to two minutes:
//!
//! - `scenes=fog,blobs,hydrogen`: phantoms, sampled as u8; `all` for every one there is
//! - `opacity=1,0.05`: factors of the opacities of the phantom's transfer function
//! - `settings=default,uncorrected,classic`: also `classic-uncorrected`, `octree`, `fine` and `cubic`; `default@4` has 4 texels to a voxel
//! - `axes=xyz`: axes of the volume that the camera turns about
//! - `angles=72`, `elevation=0`: steps of a whole turn, and how far the camera is raised, in degrees
//! - `size=64`, `pixels=256`: samples of the volume and pixels of the picture, along an edge
//! - `subgrid=24`: the references are solved at this many pixels squared; brightness and changes are of these pixels
//! - `threads=2`
//! - `every=no`: `yes` prints the brightness at every angle as well
//!
//! An error of brightness is the mean of all errors of red, green and blue, with their sign, as a part of the mean of the reference. It is
//! taken against the canonical reference, the integral, and against what the renderer says that it sums (`Prepared::model`): the
//! first shows the method, the second the program. A change is the difference of two neighbouring frames, of all four components; beside
//! that of the renderer stands that of the reference. A jump is the change of the error: 0 for an error that turns with the volume.
//!
//! The model knows of no texels. What they cost is in the error to it: light is interpolated between them, and the outline of what ends at
//! the volume's faces is a texel wide.

use std::collections::HashMap;

use vr_core::phantom::{self, Phantom};
use vr_core::{Camera, Control, Frame, Model, Prepared, Projection, Renderer, Scene, View};
use vr_physics::Reference;
use vr_physics::metrics::subgrid;
use vr_shearwarp::{EmptySpace, ShearWarp, WarpFilter};

/// Largest error of a reference's pixel.
const TOLERANCE: f64 = 1e-4;

type Pixels = Vec<[f64; 4]>;

fn scene(name: &str, n: usize, opacity: f64) -> Scene {
    let phantom: Box<dyn Phantom> = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, n, opacity).expect("a valid size")
}

fn renderer(setting: &str) -> ShearWarp {
    if let Some((setting, resolution)) = setting.split_once('@') {
        let resolution: f64 = resolution.parse().expect("settings: a number behind @");
        return {
            let coarse = renderer(setting);
            ShearWarp { texel: coarse.texel / resolution, slice_distance: coarse.slice_distance * resolution, ..coarse }
        };
    }
    match setting {
        "default" => ShearWarp::default(),
        "uncorrected" => ShearWarp { correction: false, ..ShearWarp::default() },
        "classic" => ShearWarp::classic(),
        "classic-uncorrected" => ShearWarp { correction: false, ..ShearWarp::classic() },
        "octree" => ShearWarp { empty_space: EmptySpace::Octree, ..ShearWarp::default() },
        "fine" => ShearWarp { slice_distance: 0.25, texel: 0.5, ..ShearWarp::default() },
        "cubic" => ShearWarp { warp: WarpFilter::Cubic, ..ShearWarp::default() },
        _ => panic!("settings: unknown {setting}"),
    }
}

/// The volume seen from across an axis, turned about it.
fn view(scene: &Scene, axis: usize, degrees: f64, elevation: f64, size: u32) -> View {
    let (low, high) = scene.volume.bounds();
    let (centre, diagonal) = (0.5 * (low + high), (high - low).length());
    let unit = |a: usize| {
        let mut v = centre * 0.0;
        v[a % 3] = 1.0;
        v
    };
    let camera = Camera {
        eye: centre + diagonal * unit(axis + 1),
        target: centre,
        up: unit(axis),
        projection: Projection::Orthographic { height: diagonal },
    };
    View::new(camera.orbit(degrees, elevation), [size; 2])
}

fn solve(scene: &Scene, view: &View, model: &Model, chosen: &[[u32; 2]], control: &Control) -> Pixels {
    let solution = Reference::new(TOLERANCE).solve_pixels(scene, view, model, chosen, control);
    solution.expect("a view that it can solve").pixels.iter().map(|p| p.rgba).collect()
}

fn draw(prepared: &mut dyn Prepared, view: &View, control: &Control) -> Frame {
    prepared.render(view, control).expect("a view that it can draw").frame
}

/// All pixels of a frame.
fn everything(frame: &Frame) -> Pixels {
    frame.pixels().iter().map(|p| p.map(f64::from)).collect()
}

/// The mean error of red, green and blue as a part of their mean.
fn bias(got: &Pixels, want: &Pixels) -> f64 {
    let light = |pixels: &Pixels| pixels.iter().map(|p| p[0] + p[1] + p[2]).sum::<f64>();
    light(got) / light(want) - 1.0
}

fn difference(a: &Pixels, b: &Pixels) -> Pixels {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect()
}

/// Largest magnitude and root of the mean square.
fn size(pixels: &Pixels) -> [f64; 2] {
    let square: f64 = pixels.iter().flatten().map(|x| x * x).sum();
    let largest = pixels.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    [largest, (square / (4 * pixels.len()) as f64).sqrt()]
}

/// The largest changes from a frame to the next, the last one's next being the first, and where the second of them is.
fn changes(frames: &[Pixels]) -> ([f64; 2], usize) {
    let mut largest = ([0.0; 2], 0);
    for (k, frame) in frames.iter().enumerate() {
        let [max, rms] = size(&difference(&frames[(k + 1) % frames.len()], frame));
        largest.0[0] = max.max(largest.0[0]);
        if rms > largest.0[1] {
            (largest.0[1], largest.1) = (rms, k);
        }
    }
    largest
}

/// The one farthest from 0, and where.
fn farthest(biases: &[f64]) -> (f64, usize) {
    let at = (0..biases.len()).max_by(|&a, &b| biases[a].abs().total_cmp(&biases[b].abs())).expect("an angle");
    (biases[at], at)
}

struct Keys(HashMap<String, String>);

impl Keys {
    const DEFAULTS: [(&str, &str); 10] = [
        ("scenes", "fog,blobs,hydrogen"),
        ("opacity", "1,0.05"),
        ("settings", "default,uncorrected,classic"),
        ("axes", "xyz"),
        ("angles", "72"),
        ("elevation", "0"),
        ("size", "64"),
        ("pixels", "256"),
        ("subgrid", "24"),
        ("threads", "2"),
    ];

    fn new() -> Self {
        let mut all: HashMap<String, String> =
            Self::DEFAULTS.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
        all.insert("every".to_owned(), "no".to_owned());
        for argument in std::env::args().skip(1) {
            let (key, value) = argument.split_once('=').expect("arguments are KEY=VALUE");
            assert!(all.insert(key.to_owned(), value.to_owned()).is_some(), "unknown key {key}");
        }
        Self(all)
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> T {
        self.0[key].parse().unwrap_or_else(|_| panic!("{key}: {} is no number", self.0[key]))
    }

    fn words(&self, key: &str) -> Vec<&str> {
        self.0[key].split(',').collect()
    }
}

/// One turn of one setting.
struct Turn {
    label: String,
    /// Against the canonical reference, and against the renderer's own model.
    biases: [Vec<f64>; 2],
    frames: Vec<Pixels>,
    /// The largest changes over all pixels, not the chosen ones alone.
    changes: [f64; 2],
    /// Minus the canonical reference.
    errors: Vec<Pixels>,
    reference: ([f64; 2], usize),
}

fn turns(keys: &Keys) -> Vec<Turn> {
    let control = Control::default().with_threads(keys.number("threads"));
    let (angles, pixels): (u32, u32) = (keys.number("angles"), keys.number("pixels"));
    let chosen = subgrid(keys.number("subgrid"), [pixels; 2]);
    let names = if keys.0["scenes"] == "all" { phantom::NAMES.to_vec() } else { keys.words("scenes") };
    let mut turns = Vec::new();
    for name in names {
        for opacity in keys.words("opacity") {
            let scene = scene(name, keys.number("size"), opacity.parse().expect("opacity: a number"));
            for axis in keys.0["axes"].chars() {
                let a = "xyz".find(axis).expect("axes: x, y or z");
                let view = |k: u32| {
                    view(&scene, a, 360.0 * f64::from(k) / f64::from(angles), keys.number("elevation"), pixels)
                };
                let views: Vec<View> = (0..angles).map(view).collect();
                let truth: Vec<Pixels> =
                    views.iter().map(|v| solve(&scene, v, &Model::Canonical, &chosen, &control)).collect();
                let reference = changes(&truth);
                for setting in keys.words("settings") {
                    let mut prepared = renderer(setting).prepare(&scene, &control).expect("a scene that it can draw");
                    let mut turn = Turn {
                        label: format!("| {name} × {opacity} | {axis} | {setting} |"),
                        biases: [Vec::new(), Vec::new()],
                        frames: Vec::new(),
                        changes: [0.0; 2],
                        errors: Vec::new(),
                        reference,
                    };
                    let mut before = everything(&draw(&mut *prepared, &views[views.len() - 1], &control));
                    for (view, truth) in views.iter().zip(&truth) {
                        let frame = draw(&mut *prepared, view, &control);
                        let all = everything(&frame);
                        let change = size(&difference(&all, &before));
                        turn.changes = std::array::from_fn(|i| turn.changes[i].max(change[i]));
                        before = all;
                        let frame: Pixels = chosen.iter().map(|&[x, y]| frame.pixel(x, y).map(f64::from)).collect();
                        let own = solve(&scene, view, &prepared.model(view).unwrap(), &chosen, &control);
                        turn.biases[0].push(bias(&frame, truth));
                        turn.biases[1].push(bias(&frame, &own));
                        turn.errors.push(difference(&frame, truth));
                        turn.frames.push(frame);
                    }
                    turns.push(turn);
                }
            }
        }
    }
    turns
}

fn main() {
    let keys = Keys::new();
    let turns = turns(&keys);
    let angles: f64 = keys.number("angles");
    let degrees = |k: usize| format!("{}°", 360.0 / angles * k as f64);

    println!("Brightness: the error farthest from 0, and the angle that it is at.\n");
    println!("| scene | about | setting | to the reference | at | to its own model | at |");
    println!("|---|---|---|---|---|---|---|");
    for Turn { label, biases, .. } in &turns {
        let [(truth, k), (own, l)] = [farthest(&biases[0]), farthest(&biases[1])];
        println!("{label} {:+.3} % | {} | {:+.4} % | {} |", 100.0 * truth, degrees(k), 100.0 * own, degrees(l));
    }

    println!("\nChanges from frame to frame: the largest, and after which angle the RMSE is.\n");
    let columns = "all pixels, max | RMSE | subgrid, max | of the reference | RMSE | of the reference | after | jump, max | RMSE | after";
    println!("| scene | about | setting | {columns} |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for Turn { label, frames, changes: [p, q], errors, reference: ([max, rms], _), .. } in &turns {
        let (([a, b], k), ([c, d], l)) = (changes(frames), changes(errors));
        let (k, l) = (degrees(k), degrees(l));
        println!("{label} {p:.4} | {q:.5} | {a:.4} | {max:.4} | {b:.5} | {rms:.5} | {k} | {c:.4} | {d:.5} | {l} |");
    }

    if keys.0["every"] == "yes" {
        println!("\nBrightness at every angle.\n");
        println!("| scene | about | setting | angle | to the reference | to its own model |");
        println!("|---|---|---|---|---|---|");
        for Turn { label, biases, .. } in &turns {
            for (k, (truth, own)) in biases[0].iter().zip(&biases[1]).enumerate() {
                println!("{label} {} | {:+.3} % | {:+.4} % |", degrees(k), 100.0 * truth, 100.0 * own);
            }
        }
    }
}
