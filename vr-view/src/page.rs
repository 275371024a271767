//! The page: its files, which are part of the program.

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

macro_rules! files {
    ($($name:literal: $kind:expr),* $(,)?) => {
        /// Name, media type and text of each file.
        pub const FILES: &[(&str, &str, &str)] = &[$(($name, $kind, include_str!(concat!("page/", $name)))),*];
    };
}

files! {
    "index.html": HTML,
    "style.css": CSS,
    "icon.svg": SVG,
    "app.js": JS,
    "connection.js": JS,
    "local.js": JS,
    "worker.js": JS,
    "picture.js": JS,
    "hands.js": JS,
    "status.js": JS,
    "marks.js": JS,
    "crop_box.js": JS,
    "curve.js": JS,
    "panels.js": JS,
    "color.js": JS,
    "question.js": JS,
    "error_map.js": JS,
    "ray.js": JS,
    "curtain.js": JS,
    "slices.js": JS,
    "slice_view.js": JS,
    "open.js": JS,
    "pick.js": JS,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names within the quotes that follow a word.
    fn named<'a>(text: &'a str, word: &str) -> Vec<&'a str> {
        text.split(word).skip(1).filter_map(|rest| rest.split('"').next()).collect()
    }

    #[test]
    fn the_page_asks_for_its_own_files_alone() {
        let known: Vec<&str> = FILES.iter().map(|file| file.0).collect();
        for (name, _, text) in FILES {
            for word in ["src=\"", "href=\"", "from \"./"] {
                for file in named(text, word) {
                    assert!(known.contains(&file) || file.starts_with('#'), "{name} asks for {file}");
                }
            }
            // Names of namespaces are no requests.
            let other = text.replace("http://www.w3.org/", "");
            assert!(!other.contains("http://") && !other.contains("https://") && !other.contains("//cdn"), "{name}");
            assert!(!text.contains("eval(") && !text.contains("innerHTML"), "{name} makes code or markup of text");
        }
    }
}
