//! Scene files, keys of animations, transfer functions, names of labels.

use vr_core::transfer::Preset;
use vr_core::{OpacityRule, Shading, TransferFunction};
use vr_io::{TransferSource, write_transfer};

use super::written;

pub fn scene() -> Vec<Vec<u8>> {
    let inline = "[volume]\ndata = [0, 1, 2, 3, 4, 5, 6, 7]\ndims = [2, 2, 2]\ntype = \"u8\"\nspacing = [1.0, 1.0, 1.0]\n\
                  [transfer]\npoints = [{value = 0.0, color = [0, 0, 0], opacity = 0.0}, {value = 7.0, color = [1, 1, 1], opacity = 0.5}]\n\
                  [image]\nsize = [8, 8]\n[render]\ncompositing = \"over\"\nstep = 0.5\n";
    let points = "[volume]\npoints = [[0, 0, 0, 1, 1, 0.5], [1, 0, 0, 1, 1, 1.0]]\nkernel = \"cone\"\n[transfer]\npreset = \"viridis\"\n\
                  [camera]\nazimuth = 30.0\nprojection = \"perspective\"\nfov = 40.0\n[shading]\nlights = [{direction = [1, 0, 0]}]\n\
                  gradient_opacity = [[0.0, 0.0], [2.0, 1.0]]\n[clip]\ncrop = [[0, 0, 0], [1, 1, 1]]\n[annotations]\ntitle = \"x\"\n";
    let scattering = "[volume]\nphantom = \"fog\"\nsize = 2\n[scattering]\nalbedo = 0.5\nphase = {henyey-greenstein = 0.3}\n\
                      surfaces = [{shape = {sphere = {centre = [0, 2, 0], radius = 0.3}}, emission = [9, 9, 9]}]\n[image]\nsize = [2, 2]\n";
    [inline, points, scattering].map(|text| text.as_bytes().to_vec()).to_vec()
}

pub fn keys() -> Vec<Vec<u8>> {
    let text =
        "[[keys]]\ntime = 0.0\nazimuth = 0.0\n[[keys]]\ntime = 2.5\nazimuth = 90.0\nelevation = 10.0\nzoom = 2.0\n";
    vec![text.into()]
}

pub fn color_maps() -> Vec<Vec<u8>> {
    let text = r#"[{"ColorSpace": "Diverging", "RGBPoints": [0, 0.2, 0.3, 0.7, 1, 0.7, 0.0, 0.1],
                    "Points": [0, 0, 0.5, 0, 0.5, 0.3, 0.2, 0.4, 1, 1, 0.5, 1]}]"#;
    vec![text.into()]
}

fn transfer(name: &str) -> Vec<Vec<u8>> {
    let transfer = TransferFunction::new(Preset::CtBone.points((-1000.0, 3000.0)), OpacityRule::Power, 1.0);
    let (transfer, shading) = (transfer.expect("a preset"), Shading::default());
    let source = TransferSource { name: "x", transfer: &transfer, shading: Some(&shading), gradient_per_voxel: &[] };
    vec![written(name, |path| write_transfer(path, &source).map(drop))]
}

pub fn transfer_json() -> Vec<Vec<u8>> {
    transfer("x.json")
}

pub fn transfer_vp() -> Vec<Vec<u8>> {
    transfer("x.vp")
}

pub fn transfer_csv() -> Vec<Vec<u8>> {
    transfer("x.csv")
}

pub fn transfer_lut() -> Vec<Vec<u8>> {
    transfer("x.lut")
}

pub fn transfer_toml() -> Vec<Vec<u8>> {
    transfer("x.toml")
}

pub fn labels() -> Vec<Vec<u8>> {
    let snap = "# ITK-SNAP\n    0     0    0    0        0  0  0    \"Clear Label\"\n    1   255    0    0        1  1  1    \"one\"\n";
    let table = "# FreeSurfer\n0 Unknown 0 0 0 0\n17 Left-Hippocampus 220 216 20 0\n";
    [snap, table].map(|text| text.as_bytes().to_vec()).to_vec()
}
