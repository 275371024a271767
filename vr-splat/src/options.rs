//! The settings as named options, both ways.

use std::sync::LazyLock;

use vr_core::{OptionError, OptionKind, OptionSpec, OptionValue, Options, meaning_of, word_of};

use crate::kernel::Shape;
use crate::splatting::{Buffers, Classification, SheetOrder, Splatting};

const BUFFERS: &[(&str, Buffers)] =
    &[("image", Buffers::Image), ("axis", Buffers::Axis), ("samples", Buffers::Samples)];
const CLASSIFICATIONS: &[(&str, Classification)] =
    &[("values", Classification::Values), ("voxels", Classification::Voxels)];
const SHAPES: &[(&str, Shape)] = &[
    ("bilinear", Shape::Bilinear),
    ("bspline", Shape::BSpline),
    ("gaussian", Shape::Gaussian),
    ("cone", Shape::Cone),
    ("sinc", Shape::Sinc),
];
const ORDERS: &[(&str, SheetOrder)] =
    &[("front-to-back", SheetOrder::FrontToBack), ("back-to-front", SheetOrder::BackToFront)];

/// Every option, with the default renderer's values.
pub(crate) static SPECS: LazyLock<Vec<OptionSpec>> = LazyLock::new(|| {
    let defaults = to_options(&Splatting::default());
    let spec = |key, kind, help| OptionSpec { key, kind, default: defaults.0[key].clone(), help };
    let width = OptionKind::Number { above: 0.0, most: 4.0 };
    vec![
        spec(
            "buffers",
            OptionKind::Choice(&["image", "axis", "samples"]),
            "where splats are gathered: sheets parallel to the image, the volume's own sheets, or each composited at once",
        ),
        spec(
            "classification",
            OptionKind::Choice(&["values", "voxels"]),
            "what is classified: a sheet's values, or voxels and points before they are splatted (always, with samples)",
        ),
        spec(
            "kernel",
            OptionKind::Choice(&["bilinear", "bspline", "gaussian", "cone", "sinc"]),
            "how a voxel is spread; scattered points have kernels of their own, and take none of these five",
        ),
        spec(
            "radius",
            OptionKind::Number { above: -f64::MIN_POSITIVE, most: 8.0 },
            "how far a kernel reaches, in voxels, 0.5 to 8; 0: 1 bilinear, 2 bspline and gaussian, 1.6 cone, 3 sinc",
        ),
        spec(
            "sigma",
            OptionKind::Number { above: 0.0, most: 8.0 },
            "standard deviation of the kernel gaussian, in voxels",
        ),
        spec("width-x", width, "factor on a kernel's width along the volume's x, 0.25 to 4"),
        spec("width-y", width, "the same along y"),
        spec("width-z", width, "the same along z"),
        spec(
            "slice-distance",
            OptionKind::Number { above: 0.0, most: 64.0 },
            "between sheets parallel to the image, in smallest voxel edges, or in half mean radii of points; at least 0.02; means over grids need no sheets but where voxels are missing",
        ),
        spec(
            "low-pass",
            OptionKind::Number { above: -f64::MIN_POSITIVE, most: 16.0 },
            "pixels by which footprints are widened against aliasing; 0 takes the ray through a pixel's centre as it is",
        ),
        spec(
            "order",
            OptionKind::Choice(&["front-to-back", "back-to-front"]),
            "in which order the volume's own sheets are composited",
        ),
        spec(
            "termination",
            OptionKind::Number { above: 0.0, most: 1.0 },
            "opacity from which on pixels take no more, front to back; 1: never",
        ),
    ]
});

/// All options that say what this renderer is.
pub(crate) fn to_options(renderer: &Splatting) -> Options {
    let [x, y, z] = renderer.kernel.width;
    Options::new()
        .with("buffers", word_of(BUFFERS, renderer.buffers))
        .with("classification", word_of(CLASSIFICATIONS, renderer.classification))
        .with("kernel", word_of(SHAPES, renderer.kernel.shape))
        .with("radius", renderer.kernel.radius)
        .with("sigma", renderer.kernel.sigma)
        .with("width-x", x)
        .with("width-y", y)
        .with("width-z", z)
        .with("slice-distance", renderer.slice_distance)
        .with("low-pass", renderer.low_pass)
        .with("order", word_of(ORDERS, renderer.order))
        .with("termination", renderer.termination)
}

/// A renderer with options set.
pub(crate) fn configure(renderer: &Splatting, options: &Options) -> Result<Splatting, OptionError> {
    let mut new = renderer.clone();
    for (key, value) in options.check(Splatting::NAME, &SPECS)? {
        match (key, value) {
            ("buffers", OptionValue::Word(w)) => new.buffers = meaning_of(BUFFERS, w),
            ("classification", OptionValue::Word(w)) => new.classification = meaning_of(CLASSIFICATIONS, w),
            ("kernel", OptionValue::Word(w)) => new.kernel.shape = meaning_of(SHAPES, w),
            ("order", OptionValue::Word(w)) => new.order = meaning_of(ORDERS, w),
            ("radius", &OptionValue::Number(x)) => new.kernel.radius = x,
            ("sigma", &OptionValue::Number(x)) => new.kernel.sigma = x,
            ("width-x", &OptionValue::Number(x)) => new.kernel.width[0] = x,
            ("width-y", &OptionValue::Number(x)) => new.kernel.width[1] = x,
            ("width-z", &OptionValue::Number(x)) => new.kernel.width[2] = x,
            ("slice-distance", &OptionValue::Number(x)) => new.slice_distance = x,
            ("low-pass", &OptionValue::Number(x)) => new.low_pass = x,
            ("termination", &OptionValue::Number(x)) => new.termination = x,
            _ => unreachable!("checked against the list"),
        }
    }
    // What a kind of option cannot say.
    new.validate().map_err(|e| OptionError::Value {
        renderer: Splatting::NAME,
        key: e.field.trim_start_matches("render.").to_owned(),
        found: e.found,
        allowed: e.allowed.to_owned(),
    })?;
    Ok(new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::SplatKernel;

    #[test]
    fn every_renderer_survives_the_way_through_options() {
        let kernel =
            SplatKernel { radius: 2.5, sigma: 0.9, width: [1.0, 2.0, 0.5], ..SplatKernel::new(Shape::Gaussian) };
        let all = [
            Splatting::default(),
            Splatting { buffers: Buffers::Axis, order: SheetOrder::BackToFront, ..Splatting::default() },
            Splatting { buffers: Buffers::Samples, classification: Classification::Voxels, ..Splatting::default() },
            Splatting { kernel, slice_distance: 0.3, low_pass: 1.0, termination: 1.0, ..Splatting::default() },
            Splatting { kernel: SplatKernel::new(Shape::Sinc), ..Splatting::default() },
        ];
        for from in &all {
            for to in &all {
                assert_eq!(configure(from, &to_options(to)).unwrap(), *to);
            }
            assert_eq!(configure(from, &Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (key, value) in [("radius", 0.1), ("slice-distance", 0.001), ("width-y", 0.01), ("termination", 0.0)] {
            let error = configure(&Splatting::default(), &Options::new().with(key, value)).unwrap_err();
            assert!(error.to_string().contains(key), "{error}");
        }
    }

    #[test]
    fn what_has_no_effect_is_refused_where_it_is_set() {
        let new = Options::new;
        let axis = || new().with("buffers", "axis");
        for (idle, key) in [
            (new().with("sigma", 0.9), "sigma"),
            (new().with("kernel", "sinc").with("sigma", 0.9), "sigma"),
            (axis().with("slice-distance", 0.5), "slice-distance"),
            (new().with("buffers", "samples").with("slice-distance", 0.5), "slice-distance"),
            (axis().with("order", "back-to-front").with("termination", 0.9), "termination"),
        ] {
            let error = configure(&Splatting::default(), &idle).unwrap_err().to_string();
            assert!(error.contains(key) && error.contains("absent"), "{error}");
        }
        let backwards = || axis().with("order", "back-to-front");
        // At their defaults options may be there; 1 is what happens back to front.
        for fine in [
            axis().with("sigma", 0.7).with("slice-distance", 1.0),
            new().with("kernel", "gaussian").with("sigma", 0.9).with("slice-distance", 0.5),
            backwards().with("termination", 0.9999),
            backwards().with("termination", 1.0),
        ] {
            assert!(configure(&Splatting::default(), &fine).is_ok(), "{fine:?}");
        }
    }
}
