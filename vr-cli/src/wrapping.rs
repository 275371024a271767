//! Lines of words.

/// Breaks a text between words into lines that fit; a word that does not fit alone has a line of its own.
pub fn wrapped(text: &str, fits: impl Fn(&str) -> bool) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is one");
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if line.is_empty() || fits(&longer) {
            *line = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_words() {
        let lines = wrapped("one two  three\nfour incomprehensible five", |line| line.len() <= 9);
        assert_eq!(lines, ["one two", "three", "four", "incomprehensible", "five"]);
        assert_eq!(wrapped("", |_| false), [""]);
    }
}
