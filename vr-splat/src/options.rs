//! The settings as named options.

use vr_core::{Classification, Configurable, DeclaredOption, NumberRange, OptionTable};

use crate::kernel::{Shape, SplatKernel};
use crate::splatter::{Buffers, CompositingOrder, Splatter};

/// The option that is refined.
pub(crate) const SLICE_DISTANCE: &str = "slice-distance";

impl Configurable for Splatter {
    fn options() -> OptionTable<Self> {
        let width = NumberRange::at_least(0.25).up_to(4.0);
        OptionTable::new(
            Self::NAME,
            [
                DeclaredOption::choice(
                    "buffers",
                    "where splats are gathered: in sheets parallel to the image, in the volume's own sheets, or nowhere, each composited at once",
                    [("image", Buffers::Image), ("axis", Buffers::Axis), ("samples", Buffers::Samples)],
                    |r: &Self| r.buffers,
                    |r, buffers| r.buffers = buffers,
                ),
                DeclaredOption::choice(
                    "classification",
                    "classify a sheet's values, or voxels and points before they are splatted; with buffers=samples both are one: a sample on its own has its own value",
                    [("values", Classification::Post), ("voxels", Classification::Pre)],
                    |r: &Self| r.classification,
                    |r, classification| r.classification = classification,
                ),
                DeclaredOption::choice(
                    "kernel",
                    "how a voxel is spread; bilinear: as the volume's filter says; scattered points have kernels of their own, and take none of these six options",
                    [
                        ("bilinear", Shape::Bilinear),
                        ("bspline", Shape::BSpline),
                        ("gaussian", Shape::Gaussian),
                        ("cone", Shape::Cone),
                        ("sinc", Shape::Sinc),
                        ("box", Shape::Box),
                        ("catmull-rom", Shape::CatmullRom),
                        ("product-gaussian", Shape::ProductGaussian),
                    ],
                    |r: &Self| r.kernel.shape,
                    |r, shape| r.kernel.shape = shape,
                ),
                DeclaredOption::number(
                    "radius",
                    "reach of a kernel in voxels; 0: 1 bilinear, 2 bspline, gaussians and catmull-rom, 1.6 cone, 3 sinc, 0.5 box",
                    NumberRange::at_least(0.5).up_to(8.0).or_zero(),
                    |r| r.kernel.radius,
                    |r, x| r.kernel.radius = x,
                ),
                DeclaredOption::<Self>::number(
                    "sigma",
                    "standard deviation of the kernels gaussian and product-gaussian, in voxels",
                    NumberRange::at_least(0.1).up_to(8.0),
                    |r| r.kernel.sigma,
                    |r, x| r.kernel.sigma = x,
                )
                .refuse("only the kernels 'gaussian' and 'product-gaussian' have one: must be absent", |r| {
                    let has_sigma = matches!(r.kernel.shape, Shape::Gaussian | Shape::ProductGaussian);
                    r.kernel.sigma != SplatKernel::default().sigma && !has_sigma
                }),
                DeclaredOption::number(
                    "width-x",
                    "factor on a kernel's width along the volume's x",
                    width,
                    |r| r.kernel.width[0],
                    |r, x| r.kernel.width[0] = x,
                ),
                DeclaredOption::number(
                    "width-y",
                    "the same along y",
                    width,
                    |r| r.kernel.width[1],
                    |r, x| r.kernel.width[1] = x,
                ),
                DeclaredOption::number(
                    "width-z",
                    "the same along z",
                    width,
                    |r| r.kernel.width[2],
                    |r, x| r.kernel.width[2] = x,
                ),
                DeclaredOption::<Self>::number(
                    SLICE_DISTANCE,
                    "distance of sheets parallel to the image, in smallest voxel edges, or in half mean radii of points; means over grids need sheets only where voxels are missing",
                    NumberRange::at_least(0.02).up_to(64.0),
                    |r| r.slice_spacing,
                    |r, x| r.slice_spacing = x,
                )
                .refuse("only sheets parallel to the image have a distance of their own: must be absent", |r| {
                    r.slice_spacing != Self::default().slice_spacing && r.buffers != Buffers::Image
                }),
                DeclaredOption::number(
                    "low-pass",
                    "pixels by which footprints are widened against aliasing; 0 takes the ray through a pixel's centre as it is",
                    NumberRange::at_least(0.0).up_to(16.0),
                    |r| r.low_pass,
                    |r, x| r.low_pass = x,
                ),
                DeclaredOption::choice(
                    "order",
                    "order in which sheets are composited; back-to-front is for the volume's own sheets",
                    [("front-to-back", CompositingOrder::FrontToBack), ("back-to-front", CompositingOrder::BackToFront)],
                    |r: &Self| r.order,
                    |r, order| r.order = order,
                ),
                DeclaredOption::<Self>::number(
                    "termination",
                    "opacity from which on pixels take no more, front to back; 1: never",
                    NumberRange::above(0.0).up_to(1.0),
                    |r| r.termination,
                    |r, x| r.termination = x,
                )
                .refuse("back to front, no pixel can end early: must be absent", |r| {
                    r.order == CompositingOrder::BackToFront && r.sets_termination()
                }),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use vr_core::Options;

    use super::*;

    #[test]
    fn every_renderer_survives_the_way_through_options() {
        let kernel =
            SplatKernel { radius: 2.5, sigma: 0.9, width: [1.0, 2.0, 0.5], ..SplatKernel::new(Shape::Gaussian) };
        let all = [
            Splatter::default(),
            Splatter { buffers: Buffers::Axis, order: CompositingOrder::BackToFront, ..Splatter::default() },
            Splatter { buffers: Buffers::Samples, classification: Classification::Pre, ..Splatter::default() },
            Splatter { kernel, slice_spacing: 0.3, low_pass: 1.0, termination: 1.0, ..Splatter::default() },
            Splatter { kernel: SplatKernel::new(Shape::Sinc), ..Splatter::default() },
        ];
        for from in &all {
            for to in &all {
                assert_eq!(from.configure(&to.to_options()).unwrap(), *to);
            }
            assert_eq!(from.configure(&Options::new()).unwrap(), *from);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (key, value) in
            [("radius", 0.1), ("slice-distance", 0.001), ("width-y", 0.01), ("sigma", 0.0), ("termination", 0.0)]
        {
            let error = Splatter::default().configure(&Options::new().with(key, value)).unwrap_err();
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
            let error = Splatter::default().configure(&idle).unwrap_err().to_string();
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
            assert!(Splatter::default().configure(&fine).is_ok(), "{fine:?}");
        }
    }
}
