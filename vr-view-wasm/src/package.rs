//! Package: the page, its worker and the module in one file, which a browser opens from a disk or from any host.
//!
//! A page that was opened as a file may load no other: scripts are joined, and the module is within, compressed and in letters. Its content security policy lets it
//! run these scripts and no others, and lets it ask no other place for anything.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};
use vr_view::page::FILES;

/// Script that all others lead to.
const FIRST: &str = "app.js";
/// Script of the worker, which imports nothing.
const WORKER: &str = "worker.js";

/// Reason why there is no page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PackageError {
    /// Bytes that are no WebAssembly.
    #[error("the module begins with {0:02x?}; must begin with 00 61 73 6d, as WebAssembly does")]
    NoModule(Vec<u8>),
    /// The module cannot be compressed.
    #[error("compressing the module: {0}")]
    Compress(#[from] std::io::Error),
}

/// Makes the page around a module.
///
/// # Errors
/// Bytes that are no module.
pub fn package(module: &[u8]) -> Result<String, PackageError> {
    if !module.starts_with(b"\0asm") {
        return Err(PackageError::NoModule(module.iter().copied().take(4).collect()));
    }
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(module)?;
    let packed = STANDARD.encode(packed.finish()?);
    let (script, style) = (joined(), text_of("style.css"));
    let icon = STANDARD.encode(text_of("icon.svg"));
    let policy = format!(
        "default-src 'none'; script-src '{}' 'wasm-unsafe-eval'; style-src '{}'; img-src blob: data:; connect-src blob:; worker-src blob:; \
         base-uri 'none'; form-action 'none'",
        hash(&script),
        hash(style)
    );
    let mut page = text_of("index.html").to_owned();
    for (from, to) in [
        (
            "<meta charset=\"utf-8\">",
            format!("<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">"),
        ),
        ("href=\"icon.svg\"", format!("href=\"data:image/svg+xml;base64,{icon}\"")),
        ("<link rel=\"stylesheet\" href=\"style.css\">", format!("<style>{style}</style>")),
        ("<script type=\"module\" src=\"app.js\"></script>\n", String::new()),
        (
            "</body>",
            format!(
                "<script type=\"text/plain\" id=\"worker\">{}</script>\n<script type=\"text/plain\" id=\"module\">{packed}</script>\n\
                 <script type=\"module\">{script}</script>\n</body>",
                text_of(WORKER)
            ),
        ),
    ] {
        assert_eq!(page.matches(from).count(), 1, "the page has {from} once");
        page = page.replace(from, &to);
    }
    Ok(page)
}

/// Text of a file of the page.
fn text_of(name: &str) -> &'static str {
    FILES.iter().find(|(file, ..)| *file == name).map(|(.., text)| *text).expect("a file of the page")
}

/// Source of a text in a policy.
fn hash(text: &str) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(text.as_bytes())))
}

/// All scripts in one, each behind those that it imports, and its own names within a function of its own.
fn joined() -> String {
    let mut done = Vec::new();
    let mut script = String::new();
    join(FIRST, &mut done, &mut script);
    script
}

fn join(name: &'static str, done: &mut Vec<&'static str>, script: &mut String) {
    if done.contains(&name) {
        return;
    }
    done.push(name);
    let (mut body, mut exports) = (String::new(), Vec::new());
    for line in text_of(name).lines() {
        if let Some((names, file)) = import(line) {
            let (file, ..) = FILES.iter().find(|(known, ..)| *known == file).expect("a file of the page");
            join(file, done, script);
            body.push_str(&format!("const {names} = {};\n", variable(file)));
            continue;
        }
        let line = match line.strip_prefix("export ") {
            Some(rest) => {
                exports.extend(declared(rest));
                rest
            }
            None => line,
        };
        body.push_str(line);
        body.push('\n');
    }
    script.push_str(&format!(
        "const {} = (() => {{\n{body}return {{ {} }};\n}})();\n",
        variable(name),
        exports.join(", ")
    ));
}

/// Names in braces, and the file, of a line that imports.
fn import(line: &str) -> Option<(&str, &str)> {
    let (names, rest) = line.strip_prefix("import ")?.split_once(" from \"./")?;
    Some((names, rest.strip_suffix("\";")?))
}

/// Name that a line declares, which it exports.
fn declared(line: &str) -> Option<&str> {
    let mut words = line.split(|c: char| !(c.is_alphanumeric() || "_$".contains(c))).filter(|word| *word != "async");
    matches!(words.next()?, "class" | "const" | "function").then(|| words.next())?
}

/// Variable that has what a file exports.
fn variable(file: &str) -> String {
    format!("${}", file.trim_end_matches(".js"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_joined_behind_what_they_import() {
        let script = joined();
        let place =
            |name: &str| script.find(&format!("const {} = (() =>", variable(name))).unwrap_or_else(|| panic!("{name}"));
        for (name, kind, text) in FILES.iter().filter(|(name, ..)| name.ends_with(".js") && *name != WORKER) {
            assert!(kind.starts_with("text/javascript"));
            for (names, file) in text.lines().filter_map(import) {
                assert!(place(file) < place(name), "{name} is behind {file}");
                // What is imported is exported there.
                let exported: Vec<&str> =
                    text_of(file).lines().filter_map(|line| declared(line.strip_prefix("export ")?)).collect();
                for name in names.trim_matches(['{', '}', ' ']).split(", ") {
                    assert!(exported.contains(&name), "{file} exports {name}");
                }
            }
        }
        assert!(!script.contains("\nimport ") && !script.contains("\nexport ") && !script.contains("</script"));
    }

    #[test]
    fn the_page_has_everything_within_it() {
        let page = package(b"\0asm\x01\0\0\0").unwrap();
        for word in ["src=\"", "href=\""] {
            for place in page.split(word).skip(1) {
                assert!(place.starts_with('#') || place.starts_with("data:"), "{word}{}", &place[..40]);
            }
        }
        // The policy names no host.
        let policy = page.split("Content-Security-Policy\" content=\"").nth(1).unwrap().split('"').next().unwrap();
        assert!(
            policy.contains("default-src 'none'") && !policy.contains("http") && !policy.contains("'self'"),
            "{policy}"
        );
        let letters = page.split("id=\"module\">").nth(1).unwrap().split('<').next().unwrap();
        let mut module = Vec::new();
        let packed = STANDARD.decode(letters).unwrap();
        std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&packed[..]), &mut module).unwrap();
        assert_eq!(module, b"\0asm\x01\0\0\0");
        assert!(matches!(package(b"GIF8"), Err(PackageError::NoModule(found)) if found == b"GIF8"));
    }
}
