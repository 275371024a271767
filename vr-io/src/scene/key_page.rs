//! The page on scene files: all sections and keys, as the program knows them.

use std::fmt::Write;

use super::key_help::{Absent, KeyHelp, sections};
use super::volume_section::{GridDescription, VolumeSource};

/// Opening of the page.
const HEAD: &str = "\
# Keys of scene files

A scene file is TOML: sections of keys. `vr render --scene FILE` draws it, flags override what stands in it, and `vr scene` writes one with a
comment on every key. Every section may be absent, and so may every key that has a default here. Colours are linear light unless a key says
otherwise, lengths are in the world units of the volume, angles in degrees. Paths are relative to the folder of the file. A value in brackets
is an example: without the key there is none, or one that the rest of the scene determines. `vr help keys` prints this page.
";

/// The page as Markdown: for each section a line on what it is, and a table of its keys with their defaults, meanings, units and ranges.
pub fn scene_keys() -> String {
    let mut page = HEAD.to_owned();
    for (name, meaning, keys) in sections(None) {
        // Writing into a string cannot fail.
        let _ = write!(page, "\n## [{name}]\n\n{meaning}\n");
        if name == "volume" {
            for (source, about) in volume_sources() {
                let [(_, _, keys), ..] = sections(Some(&source));
                let _ = write!(page, "\n### {about}\n");
                table(&mut page, &keys);
            }
        } else {
            table(&mut page, &keys);
        }
        if name == "render" {
            page += "\nAll other keys of this section are options of the renderer, as `vr help NAME` lists them.\n";
        }
    }
    page
}

/// Sources of a volume, each with a heading.
fn volume_sources() -> [(VolumeSource, &'static str); 5] {
    let grid = GridDescription::default();
    [
        (VolumeSource::File(Default::default()), "A file"),
        (VolumeSource::Phantom { name: String::new(), size: None }, "A formula on a grid"),
        (VolumeSource::PhantomPoints { name: String::new(), count: None }, "A formula of scattered points"),
        (VolumeSource::Grid { data: Vec::new(), grid }, "Voxels in the scene file"),
        (
            VolumeSource::Points { points: Vec::new(), kernel: None, mixing: None, colors: None },
            "Scattered points in the scene file",
        ),
    ]
}

fn table(page: &mut String, keys: &[KeyHelp]) {
    page.push_str("\n| key | default | meaning |\n|---|---|---|\n");
    for KeyHelp { key, meaning, absent } in keys {
        let default = match absent {
            Absent::Usual(value) => format!("`{value}`"),
            Absent::Example(value) => format!("(`{value}`)"),
            Absent::Nothing => String::new(),
        };
        let _ = writeln!(page, "| `{key}` | {default} | {} |", meaning.replace('|', "\\|"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_section_and_key_stands_on_the_page() {
        let page = scene_keys();
        for (name, _, keys) in sections(None) {
            assert!(page.contains(&format!("\n## [{name}]\n")), "{name}");
            for KeyHelp { key, .. } in keys {
                assert!(page.contains(&format!("\n| `{key}` | ")), "{name}.{key}");
            }
        }
        // A cell is one line, and a table has three of them in each.
        let rows = page.lines().filter(|line| line.starts_with("| "));
        assert!(rows.clone().all(|row| row.ends_with(" |")), "{page}");
        assert!(rows.count() > 100);
    }
}
