//! Messages about values that are not what their key takes: its place, what was found, what would be right, and an example, without the types
//! of the program.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{on_one_line, shown, shown_with_quotes};

use super::key_help::{Absent, KeyHelp, sections};

/// Returns a message about the value at a place in a text, of what serde says about it; as it is where the text is no TOML.
pub(super) fn explained(message: &str, text: &str, at: usize) -> String {
    // It may quote the file.
    let message = on_one_line(&message.replace('\n', " ")).into_owned();
    // A check of the section's own says all of it.
    if message.contains(": found ") {
        return message;
    }
    let Ok(document) = DeTable::parse(text) else { return message };
    let mut found = Found { path: Vec::new(), span: None };
    find_in_table(document.get_ref(), at, &mut found);
    let path = found.path.concat();
    let help = help_of(&found.path);
    let value = found.span.and_then(|span| text.get(span)).map(shown_with_quotes);
    let mut explained = match (missing_field(&message), expected(&message)) {
        (Some(field), _) => format!("{path}: no {field}, which must be there"),
        (None, Some(expected)) => {
            format!("{path}: found {}; must be {expected}", value.unwrap_or_else(|| "nothing".to_owned()))
        }
        // One of several kinds, of which serde names none: the help does.
        (None, None) if message.contains("any variant") || message.starts_with("invalid") => {
            let found = value.unwrap_or_else(|| "nothing".to_owned());
            match &help {
                Some(help) => format!("{path}: found {found}; must be as follows. {}", help.meaning),
                None => format!("{path}: found {found}; must be a number, true or false, or a word in quotes"),
            }
        }
        (None, None) if path.is_empty() => message,
        (None, None) => format!("{path}: {message}"),
    };
    if let Some(KeyHelp { key, absent: Absent::Usual(value) | Absent::Example(value), .. }) = &help {
        explained += &format!("; for example {key} = {value}");
    }
    explained
}

/// Place of a value: the names and numbers that lead to it, and its part of the text.
struct Found {
    path: Vec<String>,
    span: Option<std::ops::Range<usize>>,
}

/// Goes down to the innermost value around a place.
fn find_in_table(table: &DeTable<'_>, at: usize, found: &mut Found) {
    for (key, value) in table {
        let dot = if found.path.is_empty() { "" } else { "." };
        let name = format!("{dot}{}", shown(key.get_ref()));
        // A section's own place is its head alone: its keys stand below it.
        let depth = found.path.len();
        found.path.push(name);
        if find_in_value(value, at, found) || key.span().contains(&at) {
            return;
        }
        found.path.truncate(depth);
    }
}

/// True if the place is in a value; goes down to it then.
fn find_in_value(value: &Spanned<DeValue<'_>>, at: usize, found: &mut Found) -> bool {
    let is_here = value.span().contains(&at);
    let depth = found.path.len();
    match value.get_ref() {
        DeValue::Table(table) => find_in_table(table, at, found),
        DeValue::Array(items) => {
            for (number, item) in items.iter().enumerate() {
                found.path.push(format!("[{number}]"));
                if find_in_value(item, at, found) {
                    return true;
                }
                found.path.truncate(depth);
            }
        }
        _ => {}
    }
    if found.path.len() > depth {
        return true;
    }
    if is_here {
        found.span = Some(value.span());
    }
    is_here
}

/// Returns the help of the key of a section that a path leads through.
fn help_of(path: &[String]) -> Option<KeyHelp> {
    let (section, key) = (path.first()?, path.get(1)?.trim_start_matches('.'));
    let (.., keys) = sections(None).into_iter().find(|(name, ..)| name == section)?;
    keys.into_iter().find(|help| help.key == key)
}

fn missing_field(message: &str) -> Option<String> {
    message.strip_prefix("missing field `")?.split('`').next().map(str::to_owned)
}

/// Returns in words what serde expected; `None` where it does not say, or names what no file has.
fn expected(message: &str) -> Option<String> {
    if let Some((_, variants)) = message.split_once(", expected ").filter(|_| message.starts_with("unknown variant")) {
        let names: Vec<&str> = variants.split('`').skip(1).step_by(2).collect();
        return Some(match names.as_slice() {
            [one] => one.to_string(),
            names => format!("one of {}", names.join(", ")),
        });
    }
    let (_, expected) = message.split_once(", expected ")?;
    let counted = |words: &str| -> Option<String> {
        let number = words.split_whitespace().find(|word| word.bytes().all(|b| b.is_ascii_digit()))?;
        Some(format!("a list of {number}"))
    };
    Some(match expected {
        "f64" | "f32" => "a number".to_owned(),
        "usize" | "u64" | "u32" | "u16" | "u8" => "a whole number, not negative".to_owned(),
        "i64" | "i32" | "isize" => "a whole number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a string" | "string" | "string or table" => "a word in quotes".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "keys with values".to_owned(),
        words if words.starts_with("struct") => "a section of keys".to_owned(),
        words
            if words.starts_with("a sequence of")
                || words.starts_with("an array of")
                || words.starts_with("a tuple") =>
        {
            counted(words)? + if words.contains("f64") { " numbers" } else { "" }
        }
        words if words.contains("f32") || words.contains("f64") || words.contains("::") => return None,
        words => words.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::parse_scene;

    #[test]
    fn every_fault_names_key_value_and_what_would_be_right() {
        for (text, words) in [
            (
                "[volume]\nphantom = \"fog\"\nsize = \"big\"",
                "line 3: volume.size: found \"big\"; must be a whole number",
            ),
            (
                "[camera]\neye = 3",
                "line 2: camera.eye: found 3; must be a list of 3 numbers; for example eye = [0.0, 0.0, 9.0]",
            ),
            ("[camera]\neye = [0, 1]", "camera.eye"),
            (
                "[image]\nsize = [3.5, 2]",
                "line 2: image.size[0]: found 3.5; must be a whole number, not negative; for example size = [512, 512]",
            ),
            ("[image]\nsamples = -1", "line 2: image.samples: found -1; must be a whole number"),
            (
                "[shading]\ndiffuse = \"much\"",
                "line 2: shading.diffuse: found \"much\"; must be a number; for example diffuse = 0.7",
            ),
            ("[shading]\nenabled = 1", "shading.enabled: found 1; must be true or false; for example enabled = true"),
            (
                "[render]\ncompositing = \"ovr\"",
                "line 2: render.compositing: found \"ovr\"; must be one of over, first, average",
            ),
            ("[render]\nstep = {a = 1}", "render"),
            ("[transfer]\npoints = [{value = 1}]", "line 2: transfer.points[0]: no color, which must be there"),
            ("[mesh]\ncolor = [1, 1]", "line 2: mesh.color: found [1, 1]; must be a list of 3"),
            (
                "[scattering]\nalbedo = \"red\"",
                "line 2: scattering.albedo: found \"red\"; must be as follows. Share of the extinction",
            ),
            ("[scattering]\nphase = \"x\"", "scattering.phase: found \"x\"; must be one of isotropic, rayleigh"),
            ("volume = 3", "line 1: volume: found 3; must be a section of keys"),
            (
                "[volume]\nradius = [1, 2]\npath = \"x\"",
                "volume.radius: found [1, 2]; must be a number; for example radius = 1.5",
            ),
        ] {
            let refused = parse_scene(text, Path::new("x.toml")).unwrap_err().to_string();
            assert!(refused.starts_with("x.toml: ") && refused.contains(words), "{text}\n{refused}\n{words}");
            let types = ["f64", "f32", "usize", "u32", "i64", "struct", "enum", "variant", "sequence", "map", "tuple"];
            let found = types.iter().find(|name| refused.contains(*name));
            assert_eq!(found, None, "{refused}");
        }
    }

    #[test]
    fn control_characters_of_names_are_escaped() {
        for text in [
            "[volume]\nphantom = \"f\\u001B[31m\\ro\"",
            "[volume]\nphantom = \"\"\"f\n\u{1b}[31m\ro\"\"\"",
            "[render]\nrenderer = \"\\u001B[31m\"\ncompositing = \"\\r\\u001B\"",
            "[volume]\n\"\\u001B[31m\\r\" = 1",
            "[camera]\n\"\\u001B\" = { \"\\r\" = 1 }",
        ] {
            let refused = parse_scene(text, Path::new("x.toml")).unwrap_err().to_string();
            assert!(!refused.contains(char::is_control), "{refused:?}");
        }
    }

    #[test]
    fn what_is_no_toml_is_told_as_the_parser_does() {
        let refused = parse_scene("[volume\n", Path::new("x.toml")).unwrap_err().to_string();
        assert_eq!(refused, "x.toml: line 1: unclosed table, expected `]`");
    }
}
