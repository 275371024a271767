//! Scene files with a comment on every key, for people who are to change them.

use std::fmt::Write;

use toml::{Table, Value};
use vr_core::{OptionSpec, OptionValue};

use crate::toml_table::table_of;

use super::error::SceneFileError;
use super::key_help::{Absent, KeyHelp, sections};
use super::scene_file::SceneFile;

/// Width of a line of comment, in characters.
const WIDTH: usize = 110;

/// Longest list of numbers that stands on one line, in characters.
const LIST_WIDTH: usize = 100;

/// The text of a scene file in which every section and every key stands with its meaning, unit and range: what the file says as it is, marked
/// where it is the default, and what it does not say as a comment. `title` is the first line. `options` are those of the renderer that the
/// file names.
///
/// # Errors
/// [`SceneFileError::Text`] for a number that TOML cannot hold.
///
/// # Examples
/// ```
/// use std::path::Path;
///
/// let file = vr_io::parse_scene("[volume]\nphantom = \"fog\"\n[image]\nsize = [64, 48]\n", Path::new("")).unwrap();
/// let text = vr_io::commented_scene(&file, "A scene", &[]).unwrap();
/// assert!(text.contains("\n# Width and height in pixels, 1 to 65536. Default: [512, 512].\nsize = [64, 48]\n"));
/// assert!(text.contains("\nsamples = 1  # the default\n"));
/// assert_eq!(vr_io::parse_scene(&text, Path::new("")).unwrap(), file);
/// ```
pub fn commented_scene(file: &SceneFile, title: &str, options: &[OptionSpec]) -> Result<String, SceneFileError> {
    let table = table_of(file)?;
    let mut text = String::new();
    comment(&mut text, title);
    comment(
        &mut text,
        "vr render --scene THIS_FILE draws it; flags override what stands here. Lines such as '# key = value' are keys that are not set: \
         take the # away to set one, and that before [section], if there is one. Colours are linear light, lengths are in the world units of the volume.",
    );
    for (name, meaning, keys) in sections(file.volume.source.as_ref()) {
        text.push('\n');
        comment(&mut text, meaning);
        let section = table.get(name).and_then(Value::as_table);
        // A section that is absent stays so: its head alone may mean something.
        let _ = writeln!(text, "{}[{name}]", if section.is_some() { "" } else { "# " });
        let values = section.cloned().unwrap_or_default();
        let specs = if name == "render" { options } else { &[] };
        write_section(&mut text, values, &keys, specs);
    }
    // Sections about which nothing is said here stand as they are.
    let others: Table = table.into_iter().filter(|(name, _)| sections(None).iter().all(|s| s.0 != name)).collect();
    if !others.is_empty() {
        text.push('\n');
        text += &toml::to_string(&others).map_err(|e| SceneFileError::Text { message: e.to_string() })?;
    }
    Ok(text)
}

/// Writes the keys of a section, then a renderer's options.
fn write_section(text: &mut String, mut values: Table, keys: &[KeyHelp], options: &[OptionSpec]) {
    for (i, KeyHelp { key, meaning, absent }) in keys.iter().enumerate() {
        if i > 0 {
            text.push('\n');
        }
        let default = if let Absent::Usual(default) = absent { format!(" Default: {default}.") } else { String::new() };
        comment(text, &format!("{meaning}{default}"));
        match (values.remove(*key), absent) {
            (Some(value), _) => {
                let value = if *key == "background" { short_floats(value) } else { value };
                let is_default = matches!(absent, Absent::Usual(default) if parsed(default).as_ref() == Some(&value));
                assignment(text, key, &value, is_default);
            }
            (None, Absent::Usual(value) | Absent::Example(value)) => {
                let _ = writeln!(text, "# {key} = {value}");
            }
            (None, Absent::Nothing) => {
                let _ = writeln!(text, "# {key} =");
            }
        }
    }
    for OptionSpec { key, kind, default, help, only_with, .. } in options {
        text.push('\n');
        let only_with = only_with.map(|setting| format!(" Only with {setting}.")).unwrap_or_default();
        comment(text, &format!("Option: {help}. {}.{only_with} Default: {default}.", capital(&kind.to_string())));
        let default = match default {
            OptionValue::Switch(on) => Value::Boolean(*on),
            OptionValue::Number(x) => Value::Float(*x),
            OptionValue::Word(word) => Value::String(word.clone()),
        };
        match values.remove(*key) {
            Some(value) => assignment(text, key, &value, value == default),
            None => {
                let _ = writeln!(text, "# {key} = {default}");
            }
        }
    }
    for (key, value) in values {
        assignment(text, &key, &value, false);
    }
}

fn assignment(text: &mut String, key: &str, value: &Value, is_default: bool) {
    let mark = if is_default { "  # the default" } else { "" };
    let _ = writeln!(text, "{key} = {}{mark}", value_text(value));
}

/// The TOML of a value: tables in a list on a line each, long lists of numbers on several.
fn value_text(value: &Value) -> String {
    let Value::Array(list) = value else { return item_text(value) };
    let items: Vec<String> = list.iter().map(item_text).collect();
    let one_line = format!("[{}]", items.join(", "));
    if list.iter().any(Value::is_table) && list.len() > 1 || list.len() > 4 && list.iter().any(Value::is_array) {
        return items.iter().fold("[\n".to_owned(), |text, item| text + "  " + item + ",\n") + "]";
    }
    if one_line.len() <= LIST_WIDTH {
        return one_line;
    }
    let mut text = "[".to_owned();
    let mut width = LIST_WIDTH;
    for item in items {
        if width + item.len() + 2 > LIST_WIDTH {
            text += "\n ";
            width = 0;
        }
        width += item.len() + 2;
        let _ = write!(text, " {item},");
    }
    text + "\n]"
}

/// Keys of tables in a list that come first, in this order.
const FIRST: [&str; 5] = ["value", "headlight", "normal", "direction", "color"];

/// The TOML of a value on one line.
fn item_text(value: &Value) -> String {
    let table = match value {
        Value::Table(table) => table,
        Value::Array(list) if list.iter().any(Value::is_table) => {
            return format!("[{}]", list.iter().map(item_text).collect::<Vec<_>>().join(", "));
        }
        _ => return value.to_string(),
    };
    let mut entries: Vec<(&String, &Value)> = table.iter().collect();
    entries.sort_by_key(|(key, _)| FIRST.iter().position(|first| first == key).unwrap_or(FIRST.len()));
    let entries: Vec<String> =
        entries.into_iter().map(|(key, value)| format!("{key} = {}", item_text(value))).collect();
    format!("{{ {} }}", entries.join(", "))
}

/// Values of 32-bit floats with as few digits as give them back.
fn short_floats(value: Value) -> Value {
    match value {
        Value::Array(list) => Value::Array(list.into_iter().map(short_floats).collect()),
        Value::Float(x) => {
            let short = (x as f32).to_string().parse::<f64>().ok().filter(|&short| short as f32 == x as f32);
            Value::Float(short.unwrap_or(x))
        }
        other => other,
    }
}

/// Parses a value of a table of help.
fn parsed(value: &str) -> Option<Value> {
    toml::from_str::<Table>(&format!("x = {value}")).ok()?.remove("x")
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Writes a comment in lines of a readable width. Line breaks and control characters in it, as a file's name may have, become blanks.
fn comment(text: &mut String, words: &str) {
    let mut line = "#".to_owned();
    for word in words.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty()) {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            let _ = writeln!(text, "{line}");
            line = "#".to_owned();
        }
        line = line + " " + word;
    }
    let _ = writeln!(text, "{line}");
}
