//! The renderer's settings.

/// A renderer that draws slices through textures.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSlicer {
    /// Proxy geometry of slices.
    pub proxy: Proxy,
    /// Distance from slice to slice, in smallest voxel edges; of [`Proxy::Stacks`], in layers of voxels, rounded down to one part of a layer or one layer.
    pub slice_spacing: f64,
    /// Content of a texture, and the stage of its classification.
    pub format: Format,
    /// Order in which fragments are blended under `over`.
    pub blend: Blend,
    /// Order in which fragments are drawn.
    pub order: DrawOrder,
    /// True if blocks are left out in which nothing can be visible, or picked: of a mean, vacuum alone.
    pub skip_empty_space: bool,
    /// Opacity in (0, 1] at which a pixel takes no more fragments, front to back; 1: never, as the textbooks have it. What is left out changes no
    /// pixel by more than 1 − termination where no colour is brighter than 1, and where one is, more is drawn accordingly.
    pub termination: f64,
    /// True if opacities are corrected for the distance between slices along each ray. Off, a picture is darker or brighter with the angle: to show why
    /// it is on.
    pub correction: bool,
    /// Cells along the edge of a brick, a texture of its own, made when it is first met and kept within the budget; `None`: the volume is one texture. The picture
    /// is the same, bit for bit.
    pub brick: Option<u32>,
    /// Mebibytes that textures may take, tables apart, at every moment: of bricks the least recently used go for others.
    pub budget: f64,
}

/// Proxy geometry of slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Proxy {
    /// Planes that are parallel to the image, through a 3D texture (Cabral, Cam & Foran 1994).
    #[default]
    Planes,
    /// Spheres about the eye: the same distance along every ray (LaMar, Hamann & Joy 1999). In parallel projection they are planes.
    Shells,
    /// The volume's own layers, along the axis that the view goes most along: a stack of 2D textures for each axis, and slices between those that are
    /// stored by interpolation (Rezk-Salama, Engel, Bauer, Greiner & Ertl 2000).
    Stacks,
}

/// Content of a texture, and the stage of its classification.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Values, classified after interpolation, fragment by fragment.
    #[default]
    Scalar,
    /// Values; a fragment is a segment between two of them, integrated beforehand (Engel, Kraus & Ertl 2001).
    PreIntegrated,
    /// Values compressed to blocks of 4³, decoded at each fetch, or brick by brick when one is first met; classified after interpolation.
    Compressed,
    /// Light and opacity, classified and shaded voxel by voxel, then interpolated.
    Rgba,
    /// The same of one light for all three colours.
    LuminanceAlpha,
    /// Bytes, which a palette turns into light and opacity before they are interpolated.
    Paletted,
}

/// Order in which fragments are blended under `over`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// Each behind what is there already: under.
    #[default]
    FrontToBack,
    /// Each over what is there already: the classic. Nothing can end early.
    BackToFront,
}

/// Order in which fragments are drawn. The fragments blended onto a pixel, and their order, are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrawOrder {
    /// All slices of sixteen pixels, then the next sixteen: what a processor's caches like.
    #[default]
    Tiles,
    /// A slice across the whole picture, its polygons rasterised in triangles, then the next one: what a graphics card does.
    Slices,
}

impl Default for TextureSlicer {
    fn default() -> Self {
        Self {
            proxy: Proxy::default(),
            slice_spacing: 0.5,
            format: Format::default(),
            blend: Blend::default(),
            order: DrawOrder::default(),
            skip_empty_space: true,
            termination: 0.9999,
            correction: true,
            brick: None,
            budget: Self::MAX_BUDGET,
        }
    }
}

impl TextureSlicer {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "texslice";
    /// The largest budget, in mebibytes: a tebibyte, which is none at all.
    pub const MAX_BUDGET: f64 = 1_048_576.0;

    /// Returns the renderer of the textbooks: every fragment is drawn, whether it can be seen or not.
    pub fn brute_force() -> Self {
        Self { skip_empty_space: false, termination: 1.0, ..Self::default() }
    }

    /// Slices of a stack to a layer of voxels.
    pub(crate) fn per_layer(&self) -> u32 {
        // A third of a layer times three is one.
        (1.0 / self.slice_spacing - 1e-9).ceil().max(1.0) as u32
    }

    /// The budget in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        (self.budget * f64::from(1u32 << 20)) as u64
    }

    /// True if fragments are segments with a value at either end.
    pub(crate) fn is_pre_integrated(&self) -> bool {
        self.format == Format::PreIntegrated
    }

    /// True if a texture holds light and opacity, not values.
    pub(crate) fn holds_light(&self) -> bool {
        matches!(self.format, Format::Rgba | Format::LuminanceAlpha | Format::Paletted)
    }

    /// True if a termination was asked for: neither the default, nor 1, at which no pixel ends early.
    pub(crate) fn sets_termination(&self) -> bool {
        ![Self::default().termination, 1.0].contains(&self.termination)
    }
}
