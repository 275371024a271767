//! Memory of an encoded volume: `cargo run --release -p vr-shearwarp --example memory -- [SIZE ...]`.
//!
//! Phantoms of SIZE³ bytes (default 256), each encoding, in a Markdown table: stored voxels as a part of all, bytes to each with its
//! runs, MB for one axis and for three. The samples themselves are not counted.

use vr_core::Control;
use vr_core::phantom::{self};
use vr_shearwarp::{EmptySpace, ShearWarp};

fn main() {
    let mut sizes: Vec<usize> = std::env::args().skip(1).map(|n| n.parse().expect("SIZE: a number")).collect();
    if sizes.is_empty() {
        sizes.push(256);
    }
    let control = Control::default();
    let encodings = [
        ("classic", ShearWarp::classic()),
        ("default", ShearWarp::default()),
        ("octree", ShearWarp { empty_space: EmptySpace::Octree, ..ShearWarp::default() }),
    ];
    println!("| scene | encoding | stored | bytes | one axis | three |\n|---|---|--:|--:|--:|--:|");
    for size in sizes {
        for name in ["blobs", "hydrogen", "marschner-lobb", "fog"] {
            let phantom = phantom::by_name(name).expect("a known phantom");
            let scene = phantom::sampled_scene::<u8>(&*phantom, size, 1.0).expect("SIZE: two or more");
            for (label, renderer) in &encodings {
                let size_of = |axes: &[usize]| renderer.encoded_size(&scene, axes, &control).expect("a valid scene");
                let (one, three) = (size_of(&[2]), size_of(&[0, 1, 2]));
                println!(
                    "| {name} {size} | {label} | {:.1} % | {:.2} | {:.1} | {:.1} |",
                    100.0 * one.stored as f64 / (size as f64).powi(3),
                    one.per_voxel(),
                    one.total() as f64 / 1e6,
                    three.total() as f64 / 1e6
                );
            }
        }
    }
}
