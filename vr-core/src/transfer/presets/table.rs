//! The numbers of the presets. Colours are sRGB, opacities those of one voxel.
//!
//! Hounsfield units by which the CT presets are laid out: air −1000, lung −950 to −600, fat −130 to −70, water 0, muscle and organs 20 to 70,
//! clotted blood 80, contrast agent in vessels 150 to 500, cancellous bone 200 to 500, cortical bone 700 to 2000, metal above.
//! MR, PET, ultrasound and microscopy have no unit: positions are fractions of the signal.

use crate::transfer::{cool_warm, inferno, viridis};

use super::PresetFamily::{Any, Ct, Microscopy, Mr, Pet, Ultrasound};
use super::recipe::{Curve, Gloss, Recipe, Row};

/// Number of points of a colour map: the straight lines between them are within 3 of 255 steps of the map itself (17 points: within 9).
const MAP_POINTS: usize = 33;

/// The recipes, in the order of the variants of [`super::Preset`].
pub(super) const RECIPES: [Recipe; 22] = [
    map("grey", "black to white, opacity growing with the value", Curve::Map { color: grey, points: 2, opacity: 0.06 }),
    map("viridis", "dark violet to yellow, opacity growing with the value", colors(viridis)),
    map("inferno", "black over red to yellow, opacity growing with the value", colors(inferno)),
    map(
        "cool-warm",
        "blue to red; values of both signs are grey and clear at 0",
        Curve::Diverging { color: cool_warm, points: MAP_POINTS, opacity: 0.1 },
    ),
    Recipe { gloss: None, ..ct("x-ray", "a radiograph: bone is white, as on film", &X_RAY, Gloss::Soft) },
    ct("ct-bone", "ivory bone; soft tissue is clear", &CT_BONE, Gloss::Matte),
    ct("ct-angio", "vessels with contrast agent in red, bone in ivory; muscle is clear", &CT_ANGIO, Gloss::Moist),
    ct("ct-lung", "lungs as haze with their vessels and airways; the body around is clear", &CT_LUNG, Gloss::Soft),
    ct("ct-soft-tissue", "skin, fat and muscle, translucent, around ivory bone", &CT_SOFT_TISSUE, Gloss::Moist),
    ct(
        "ct-cardiac",
        "chambers and vessels with contrast agent, the muscle of the heart as haze",
        &CT_CARDIAC,
        Gloss::Moist,
    ),
    ct("ct-muscle", "muscle and organs, opaque; skin and fat are clear", &CT_MUSCLE, Gloss::Moist),
    ct("ct-skin", "the skin, opaque", &CT_SKIN, Gloss::Matte),
    ct("ct-fat", "fat in yellow, and a trace of bone", &CT_FAT, Gloss::Soft),
    ct("ct-air", "the surface of air: airways, lungs, sinuses and bowel, within a veil of skin", &CT_AIR, Gloss::Soft),
    Recipe {
        gloss: None,
        is_projection: true,
        ..ct("ct-mip", "the densest value along each ray, from fat to bone", &CT_MIP, Gloss::Soft)
    },
    signal(Mr, "mr-default", "tissue from brown to white; air and noise are clear", &MR_DEFAULT, Some(Gloss::Matte)),
    signal(Mr, "mr-t2-brain", "fluid in pale blue through grey and white matter", &MR_T2_BRAIN, Some(Gloss::Matte)),
    signal(Mr, "mr-angio", "bright vessels in red; all that is less bright is clear", &MR_ANGIO, Some(Gloss::Moist)),
    signal(Pet, "pet-hot", "uptake from dark red over yellow to white, glowing", &PET_HOT, None),
    signal(Ultrasound, "ultrasound", "echoes in amber; fluid is clear", &ULTRASOUND, Some(Gloss::Soft)),
    signal(Microscopy, "fluorescence", "stain that glows green, white where it is dense", &FLUORESCENCE, None),
    signal(
        Microscopy,
        "microscopy",
        "dense structures as surfaces, from slate to ivory",
        &MICROSCOPY,
        Some(Gloss::Matte),
    ),
];

const fn map(name: &'static str, title: &'static str, curve: Curve) -> Recipe {
    Recipe { name, title, family: Any, curve, gloss: None, is_projection: false }
}

const fn colors(color: fn(f64) -> [f64; 3]) -> Curve {
    Curve::Map { color, points: MAP_POINTS, opacity: 0.1 }
}

const fn ct(name: &'static str, title: &'static str, rows: &'static [Row], gloss: Gloss) -> Recipe {
    Recipe { name, title, family: Ct, curve: Curve::Hounsfield(rows), gloss: Some(gloss), is_projection: false }
}

const fn signal(
    family: super::PresetFamily,
    name: &'static str,
    title: &'static str,
    rows: &'static [Row],
    gloss: Option<Gloss>,
) -> Recipe {
    Recipe { name, title, family, curve: Curve::Signal(rows), gloss, is_projection: false }
}

fn grey(t: f64) -> [f64; 3] {
    [t; 3]
}

/// μ = μ_water·(1 + HU/1000), so extinction is linear from air upwards; 0.2 % per voxel of water lets two thirds through
/// 200 voxels of a body. So small an opacity is as good as proportional to extinction.
const X_RAY: [Row; 2] = [(-1000.0, [1.0; 3], 0.0), (3071.0, [1.0; 3], 0.002 * 4.071)];

/// After 3D Slicer's CT-Bone, whose ramp begins at −16 HU and veils bone in soft tissue; here it begins at the upper end of
/// blood and muscle.
const CT_BONE: [Row; 5] = [
    (150.0, [0.73, 0.25, 0.30], 0.0),
    (250.0, [0.85, 0.58, 0.42], 0.05),
    (450.0, [0.91, 0.82, 0.62], 0.40),
    (1000.0, [0.98, 0.94, 0.84], 0.80),
    (3071.0, [1.00, 1.00, 1.00], 0.90),
];

const CT_ANGIO: [Row; 6] = [
    (120.0, [0.50, 0.05, 0.05], 0.0),
    (180.0, [0.75, 0.13, 0.10], 0.15),
    (300.0, [0.90, 0.33, 0.22], 0.45),
    (500.0, [0.95, 0.72, 0.52], 0.55),
    (800.0, [0.98, 0.93, 0.83], 0.65),
    (3071.0, [1.00, 1.00, 1.00], 0.85),
];

/// Nothing above −300: the wall of the chest would hide the lung. Skin is crossed within a voxel or two, and stays a veil.
const CT_LUNG: [Row; 6] = [
    (-960.0, [0.35, 0.45, 0.60], 0.0),
    (-880.0, [0.50, 0.62, 0.78], 0.015),
    (-750.0, [0.80, 0.70, 0.72], 0.04),
    (-600.0, [0.90, 0.55, 0.50], 0.08),
    (-420.0, [0.85, 0.35, 0.30], 0.06),
    (-300.0, [0.75, 0.25, 0.22], 0.0),
];

const CT_SOFT_TISSUE: [Row; 7] = [
    (-300.0, [0.55, 0.25, 0.15], 0.0),
    (-120.0, [0.88, 0.66, 0.45], 0.03),
    (-30.0, [0.85, 0.50, 0.38], 0.04),
    (40.0, [0.72, 0.22, 0.18], 0.10),
    (100.0, [0.80, 0.32, 0.25], 0.12),
    (250.0, [0.95, 0.85, 0.70], 0.25),
    (1000.0, [1.00, 0.98, 0.92], 0.60),
];

const CT_CARDIAC: [Row; 7] = [
    (70.0, [0.45, 0.12, 0.10], 0.0),
    (110.0, [0.58, 0.16, 0.12], 0.02),
    (160.0, [0.72, 0.22, 0.16], 0.10),
    (250.0, [0.88, 0.38, 0.28], 0.35),
    (400.0, [0.95, 0.62, 0.46], 0.50),
    (700.0, [0.98, 0.92, 0.82], 0.55),
    (3071.0, [1.00, 1.00, 1.00], 0.80),
];

const CT_MUSCLE: [Row; 6] = [
    (-10.0, [0.60, 0.18, 0.15], 0.0),
    (20.0, [0.66, 0.20, 0.16], 0.20),
    (50.0, [0.74, 0.27, 0.21], 0.60),
    (120.0, [0.82, 0.42, 0.32], 0.65),
    (300.0, [0.95, 0.85, 0.70], 0.75),
    (1000.0, [1.00, 0.98, 0.92], 0.85),
];

const CT_SKIN: [Row; 4] = [
    (-550.0, [0.76, 0.52, 0.40], 0.0),
    (-350.0, [0.84, 0.61, 0.48], 0.30),
    (-150.0, [0.89, 0.68, 0.55], 0.85),
    (3071.0, [0.93, 0.75, 0.63], 0.95),
];

const CT_FAT: [Row; 8] = [
    (-190.0, [0.90, 0.68, 0.30], 0.0),
    (-130.0, [0.96, 0.78, 0.40], 0.12),
    (-90.0, [1.00, 0.85, 0.50], 0.20),
    (-50.0, [0.96, 0.76, 0.40], 0.08),
    (-15.0, [0.90, 0.70, 0.40], 0.0),
    (250.0, [0.90, 0.88, 0.84], 0.0),
    (500.0, [0.95, 0.93, 0.90], 0.06),
    (3071.0, [1.00, 1.00, 1.00], 0.15),
];

/// Air itself is clear: it would fill the box around the body, too. What is between it and tissue is its surface.
const CT_AIR: [Row; 5] = [
    (-930.0, [0.30, 0.55, 0.70], 0.0),
    (-800.0, [0.42, 0.70, 0.82], 0.08),
    (-650.0, [0.62, 0.84, 0.90], 0.15),
    (-450.0, [0.85, 0.93, 0.95], 0.08),
    (-300.0, [0.95, 0.97, 0.98], 0.0),
];

/// A window of 800 HU, as radiologists set for vessels and bone.
const CT_MIP: [Row; 2] = [(-100.0, [0.0; 3], 1.0), (700.0, [1.0; 3], 1.0)];

/// Colours of 3D Slicer's MR-Default, whose opacities are three times as large.
const MR_DEFAULT: [Row; 6] = [
    (0.00, [0.0, 0.0, 0.0], 0.0),
    (0.10, [0.168627, 0.0, 0.0], 0.0),
    (0.20, [0.403922, 0.145098, 0.0784314], 0.03),
    (0.45, [0.780392, 0.607843, 0.380392], 0.10),
    (0.75, [0.847059, 0.835294, 0.788235], 0.15),
    (1.00, [1.0, 1.0, 1.0], 0.20),
];

/// Under T2 fluid is brightest, and white matter is darker than grey.
const MR_T2_BRAIN: [Row; 6] = [
    (0.15, [0.30, 0.18, 0.16], 0.0),
    (0.28, [0.52, 0.36, 0.32], 0.02),
    (0.45, [0.74, 0.60, 0.54], 0.08),
    (0.62, [0.80, 0.76, 0.74], 0.10),
    (0.82, [0.66, 0.82, 0.96], 0.30),
    (1.00, [0.90, 0.97, 1.00], 0.55),
];

const MR_ANGIO: [Row; 5] = [
    (0.40, [0.40, 0.05, 0.05], 0.0),
    (0.52, [0.62, 0.12, 0.10], 0.06),
    (0.68, [0.85, 0.30, 0.20], 0.35),
    (0.85, [0.95, 0.60, 0.40], 0.65),
    (1.00, [1.00, 0.92, 0.80], 0.85),
];

const PET_HOT: [Row; 6] = [
    (0.03, [0.15, 0.0, 0.0], 0.0),
    (0.12, [0.40, 0.02, 0.0], 0.008),
    (0.30, [0.80, 0.10, 0.02], 0.03),
    (0.55, [1.00, 0.50, 0.05], 0.10),
    (0.80, [1.00, 0.88, 0.35], 0.25),
    (1.00, [1.00, 1.00, 0.95], 0.45),
];

const ULTRASOUND: [Row; 5] = [
    (0.18, [0.20, 0.10, 0.05], 0.0),
    (0.32, [0.48, 0.27, 0.12], 0.03),
    (0.50, [0.78, 0.50, 0.25], 0.10),
    (0.75, [0.96, 0.76, 0.48], 0.28),
    (1.00, [1.00, 0.95, 0.82], 0.50),
];

const FLUORESCENCE: [Row; 5] = [
    (0.06, [0.0, 0.10, 0.03], 0.0),
    (0.20, [0.02, 0.38, 0.12], 0.01),
    (0.45, [0.08, 0.75, 0.25], 0.05),
    (0.75, [0.35, 0.98, 0.45], 0.15),
    (1.00, [0.90, 1.00, 0.90], 0.35),
];

const MICROSCOPY: [Row; 5] = [
    (0.22, [0.28, 0.32, 0.40], 0.0),
    (0.35, [0.42, 0.46, 0.52], 0.08),
    (0.55, [0.66, 0.62, 0.56], 0.35),
    (0.80, [0.90, 0.84, 0.72], 0.65),
    (1.00, [1.00, 0.98, 0.92], 0.85),
];
