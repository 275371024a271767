//! The settings as named options, both ways.

use std::sync::LazyLock;

use vr_core::{OptionError, OptionKind, OptionSpec, OptionValue, Options, meaning_of, word_of};

use crate::shear_warp::{Classification, Encoding, ShearWarp};
use crate::warp::WarpFilter;

const CLASSIFICATIONS: &[(&str, Classification)] =
    &[("values", Classification::Values), ("voxels", Classification::Voxels)];
const WARPS: &[(&str, WarpFilter)] = &[("bilinear", WarpFilter::Bilinear), ("cubic", WarpFilter::Cubic)];
const ENCODINGS: &[(&str, Encoding)] = &[("runs", Encoding::Runs), ("octree", Encoding::Octree)];

/// Every option, with the default renderer's values.
pub(crate) static SPECS: LazyLock<Vec<OptionSpec>> = LazyLock::new(|| {
    let defaults = to_options(&ShearWarp::default());
    let spec = |key, kind, help| OptionSpec { key, kind, default: defaults.0[key].clone(), help };
    vec![
        spec(
            "classification",
            OptionKind::Choice(&["values", "voxels"]),
            "what is classified: interpolated values, or voxels, whose colours are then interpolated (the classic way)",
        ),
        spec(
            "slice-distance",
            OptionKind::Number { above: 0.0, most: 16.0 },
            "texels from slice to slice along the principal axis; slices one voxel apart are the layers of voxels",
        ),
        spec(
            "texel",
            OptionKind::Number { above: 0.0, most: 1.0 },
            "voxels to a texel of the intermediate image along either side, at least 0.03",
        ),
        spec("warp", OptionKind::Choice(&["bilinear", "cubic"]), "how the intermediate image is resampled"),
        spec(
            "encoding",
            OptionKind::Choice(&["runs", "octree"]),
            "how what can be seen is found: run-length encoded voxels, or blocks by an octree, at once for a new transfer function",
        ),
        spec(
            "termination",
            OptionKind::Number { above: 0.0, most: 1.0 },
            "opacity from which on a texel takes no more; changes none by more than 1 - termination",
        ),
        spec(
            "opacity-threshold",
            OptionKind::Number { above: -f64::MIN_POSITIVE, most: 0.999 },
            "opacity of a voxel's thickness up to which values are left out, where nothing around is more opaque",
        ),
        spec(
            "correction",
            OptionKind::Switch,
            "opacities corrected for how far apart slices are along a ray; off shows why",
        ),
    ]
});

/// All options that say what this renderer is.
pub(crate) fn to_options(renderer: &ShearWarp) -> Options {
    Options::new()
        .with("classification", word_of(CLASSIFICATIONS, renderer.classification))
        .with("slice-distance", renderer.slice_distance)
        .with("texel", renderer.texel)
        .with("warp", word_of(WARPS, renderer.warp))
        .with("encoding", word_of(ENCODINGS, renderer.encoding))
        .with("termination", renderer.termination)
        .with("opacity-threshold", renderer.opacity_threshold)
        .with("correction", renderer.correction)
}

/// A renderer with options set.
pub(crate) fn configure(renderer: &ShearWarp, options: &Options) -> Result<ShearWarp, OptionError> {
    let refuse = |key: &str, found: f64, allowed: &str| OptionError::Value {
        renderer: ShearWarp::NAME,
        key: key.to_owned(),
        found: found.to_string(),
        allowed: allowed.to_owned(),
    };
    let mut new = renderer.clone();
    for (key, value) in options.check(ShearWarp::NAME, &SPECS)? {
        match (key, value) {
            ("classification", OptionValue::Word(w)) => new.classification = meaning_of(CLASSIFICATIONS, w),
            ("slice-distance", &OptionValue::Number(distance)) => {
                new.slice_distance = distance;
            }
            ("texel", &OptionValue::Number(texel)) => {
                if texel < 0.03 {
                    return Err(refuse(key, texel, "must be 0.03 to 1"));
                }
                new.texel = texel;
            }
            ("warp", OptionValue::Word(w)) => new.warp = meaning_of(WARPS, w),
            ("encoding", OptionValue::Word(w)) => new.encoding = meaning_of(ENCODINGS, w),
            ("termination", &OptionValue::Number(x)) => new.termination = x,
            ("opacity-threshold", &OptionValue::Number(x)) => new.opacity_threshold = x,
            ("correction", &OptionValue::Switch(on)) => new.correction = on,
            _ => unreachable!("checked against the list"),
        }
    }
    Ok(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_renderer_survives_the_way_through_options() {
        let all = [
            ShearWarp::default(),
            ShearWarp::classic(),
            ShearWarp { slice_distance: 0.3, texel: 0.4, warp: WarpFilter::Cubic, ..ShearWarp::default() },
            ShearWarp { encoding: Encoding::Octree, opacity_threshold: 0.05, ..ShearWarp::default() },
            ShearWarp { correction: false, termination: 1.0, slice_distance: 1.0 / 64.0, ..ShearWarp::default() },
        ];
        for from in &all {
            for to in &all {
                assert_eq!(configure(from, &to_options(to)).unwrap(), *to);
                assert!(to.validate().is_ok());
            }
            assert_eq!(configure(from, &Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (key, value) in [("texel", 0.02), ("termination", 0.0)] {
            let error = configure(&ShearWarp::default(), &Options::new().with(key, value)).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
    }
}
