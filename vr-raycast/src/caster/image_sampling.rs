//! Choice of the rays that a picture is made of.

/// Choice of the rays that a picture is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ImageSampling {
    /// Default: [`ImageSampling::Adaptive`] where steps are local and the picture has [`ImageSampling::LARGE`] pixels or more, with a threshold of
    /// [`ImageSampling::THRESHOLD_PER_ERROR`] times the error that the steps aim at, unless a few rays show that more than a third would be traced; [`ImageSampling::EveryPixel`] elsewhere.
    #[default]
    Auto,
    /// The rays of every pixel.
    EveryPixel,
    /// Rays of every fourth pixel along x and y, then of those between where the colours bend or something thin shows; the rest is interpolated by cubics
    /// (after Levoy, *Volume rendering by adaptive refinement*, 1990). Not exact: see `docs/figures/vr-raycast.md` for what was measured.
    Adaptive {
        /// Largest distance of a component of the premultiplied colours from the straight lines through its neighbours' along x and y (the sum of
        /// both second differences), 0 or more, at which nothing is refined; 0: every pixel is traced. Where features are wider than four
        /// pixels, the largest error of the interpolation is below it, and its RMSE a twentieth. Of what is thinner, lines and rims are followed where a ray
        /// meets them, and needles and dots of grids are looked for beforehand.
        threshold: f64,
    },
    /// Rays of every pixel, each begun where its part of the view can show something first. That is projected for each view from what
    /// earlier pictures met first (a C-buffer; Yagel and Shi, *Accelerating volume animation by space-leaping*, 1993). The picture is that
    /// of [`ImageSampling::EveryPixel`], bit for bit. For samples at equal distances by the rules
    /// midpoint, left and linear, under over, accumulate and first.
    #[cfg(feature = "classics")]
    Coherent,
    /// Rays of every pixel, each begun where the point that the last picture met first tells: its points are projected to the view, hidden
    /// ones are removed by their order, and holes are filled from their neighbours (the C-buffer as Yagel and Shi published it, 1993). Every
    /// start is proven by the ranges of blocks of 2³ cells before it is taken, and the ray of a wrong one begins where the proof ends: the
    /// picture is that of [`ImageSampling::EveryPixel`], bit for bit. For what [`ImageSampling::Coherent`] draws.
    #[cfg(feature = "classics")]
    CBuffer,
    /// Parallel rays that all step through the voxels alike, cast from the face of the volume that looks at the eye most; their picture
    /// is stretched onto the screen (Yagel and Kaufman, *Template-based volume viewing*, 1992). The picture is as sharp as voxels are, not as pixels. For
    /// grids in orthographic views: other rays are not parallel.
    #[cfg(feature = "classics")]
    Template {
        /// Samples that the template is made of.
        connectivity: crate::classics::Connectivity,
    },
}

impl ImageSampling {
    /// Number of pixels from which on automatic rays are adaptive. In smaller pictures most of what there is to see is a few pixels wide, and rays take little
    /// time beside what a scene needs to be prepared.
    pub const LARGE: u64 = 1 << 16;
    /// Threshold of automatic adaptive rays in units of the error that the steps aim at: interpolation then adds about as much as the steps do (see
    /// `docs/notes/vr-raycast.md`).
    pub const THRESHOLD_PER_ERROR: f64 = 40.0;

    /// Returns the name that options use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::EveryPixel => "every-pixel",
            Self::Adaptive { .. } => "adaptive",
            #[cfg(feature = "classics")]
            Self::Coherent => "coherent",
            #[cfg(feature = "classics")]
            Self::CBuffer => "c-buffer",
            #[cfg(feature = "classics")]
            Self::Template { connectivity } => connectivity.name(),
        }
    }

    /// True if its rays go through pixels, and not through a picture that is stretched onto them.
    pub(crate) fn casts_pixels(self) -> bool {
        #[cfg(feature = "classics")]
        if matches!(self, Self::Template { .. }) {
            return false;
        }
        true
    }
}
