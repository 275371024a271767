//! Records of the first layout, which held annotations apart from the scene.

use toml::{Table, Value};

/// Moves the annotations of `[record]` into the scene, where they are today.
///
/// # Errors
/// A message about the name of an annotation that there never was.
pub(super) fn upgrade(section: &mut Table, scene: &mut Table) -> Result<(), String> {
    let mut annotations = Table::new();
    let names = section.remove("annotations").and_then(|names| names.as_array().cloned()).unwrap_or_default();
    for name in &names {
        let shown: &[&str] = match name.as_str() {
            Some("all") => &["marker", "scale", "legend"],
            Some("marker") => &["marker"],
            Some("scale") => &["scale"],
            Some("legend") => &["legend"],
            _ => return Err(format!("it names annotation {name}, which this version does not know")),
        };
        annotations.extend(shown.iter().map(|key| ((*key).to_owned(), Value::Boolean(true))));
    }
    if let Some(title) = section.remove("title") {
        annotations.insert("title".to_owned(), title);
    }
    if !annotations.is_empty() {
        scene.insert("annotations".to_owned(), annotations.into());
    }
    Ok(())
}
