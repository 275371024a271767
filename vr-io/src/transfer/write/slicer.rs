//! 3D Slicer's volume properties as text.

use vr_core::Shading;

use super::{TransferSource, display_points};

/// Nine lines of numbers.
pub(super) fn text(source: &TransferSource<'_>, notes: &mut Vec<String>) -> String {
    let shown = display_points(source.transfer);
    let default = Shading::default();
    let Shading { ambient, diffuse, specular, power, gradient_opacity, .. } = source.shading.unwrap_or(&default);
    if !gradient_opacity.is_empty() {
        notes.push("gradient opacity is left out: it is given by world units, and the format's by voxels".to_owned());
    }
    let gradient: Vec<f64> = match source.gradient_per_voxel {
        [] => vec![0.0, 1.0, 255.0, 1.0],
        factors => factors.iter().flat_map(|&(magnitude, factor)| [magnitude, factor]).collect(),
    };
    let opacity: Vec<f64> = shown.iter().flat_map(|p| [p.value, p.opacity]).collect();
    let color: Vec<f64> = shown.iter().flat_map(|p| [p.value, p.color[0], p.color[1], p.color[2]]).collect();
    let shade = u8::from(source.shading.is_some());
    format!(
        "1\n{shade}\n{diffuse}\n{ambient}\n{specular}\n{power}\n{}\n{}\n{}\n",
        counted(&opacity),
        counted(&gradient),
        counted(&color)
    )
}

/// Numbers after how many there are.
fn counted(numbers: &[f64]) -> String {
    let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("{} {}", numbers.len(), words.join(" "))
}
