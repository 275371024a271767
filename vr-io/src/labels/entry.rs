//! Entry of a file about a label.

/// Name, colour, opacity and visibility of a label, as far as a file gives them.
///
/// # Examples
/// ```
/// use std::path::Path;
///
/// let list = "0 0 0 0 0 0 0 \"Clear Label\"\n3 255 0 0 0.5 1 1 \"left lung\"\n";
/// let entries = vr_io::parse_label_list(list, Path::new("lungs.label"))?;
/// assert_eq!((entries[1].label, entries[1].name.as_deref()), (3, Some("left lung")));
/// assert_eq!((entries[1].color, entries[1].opacity), (Some([1.0, 0.0, 0.0]), Some(0.5)));
/// assert_eq!(entries[0].visible, Some(false));
/// # Ok::<(), vr_io::FileError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelEntry {
    /// The label.
    pub label: i32,
    /// Its name.
    pub name: Option<String>,
    /// Linear RGB.
    pub color: Option<[f64; 3]>,
    /// Opacity, from 0 to 1.
    pub opacity: Option<f64>,
    /// False if it is not to be seen.
    pub visible: Option<bool>,
}
