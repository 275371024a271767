//! The terminal that stdout is: its size, and what it understands.

use std::env;

use console::Term;

use crate::args::Protocol;

/// Width in columns where stdout is no terminal.
const COLUMNS: u32 = 80;
/// Width in pixels that a column has at least, nearly everywhere.
const COLUMN_PIXELS: u32 = 8;

/// Properties of a terminal.
pub struct Terminal {
    columns: u32,
    /// Lines of text; `None` where stdout is no terminal.
    lines: Option<u32>,
    /// True if it takes 24 bits of colour.
    pub true_color: bool,
    /// Protocol that its variables tell.
    protocol: Protocol,
}

impl Terminal {
    /// Returns what stdout is.
    pub fn of_stdout() -> Self {
        let term = Term::stdout();
        match term.size_checked().filter(|_| term.is_term()) {
            Some((lines, columns)) => Self::new((lines.into(), columns.into()), |name| env::var(name).ok()),
            None => Self::none(),
        }
    }

    /// Returns what a file or a pipe is taken for.
    pub fn none() -> Self {
        Self { columns: COLUMNS, lines: None, true_color: true, protocol: Protocol::Blocks }
    }

    fn new((lines, columns): (u32, u32), variable: impl Fn(&str) -> Option<String>) -> Self {
        let has = |name: &str, words: &[&str]| {
            variable(name).is_some_and(|value| {
                let value = value.to_lowercase();
                words.iter().any(|word| value.contains(word))
            })
        };
        // Pictures do not get through terminals within terminals.
        let within = variable("TMUX").is_some() || has("TERM", &["screen", "tmux"]);
        let protocol = if within {
            Protocol::Blocks
        } else if has("TERM", &["kitty", "ghostty"]) || has("TERM_PROGRAM", &["ghostty"]) {
            Protocol::Kitty
        } else if has("TERM_PROGRAM", &["iterm", "wezterm"]) || has("LC_TERMINAL", &["iterm"]) {
            Protocol::Iterm
        } else if has("TERM", &["sixel", "foot", "mlterm"]) {
            Protocol::Sixel
        } else {
            Protocol::Blocks
        };
        let true_color = has("COLORTERM", &["truecolor", "24bit"]) || has("TERM", &["direct", "truecolor"]);
        Self { columns: columns.max(1), lines: Some(lines), true_color, protocol }
    }

    /// Returns the protocol that it is known to understand.
    pub fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// Returns the number of columns for a picture that is wider than the terminal is likely to be; `None` leaves it as it is.
    pub fn columns_for(&self, [width, _]: [u32; 2]) -> Option<u32> {
        (width > self.columns * COLUMN_PIXELS).then_some(self.columns)
    }

    /// Returns the size of a picture in pixels.
    pub fn pixels_for(&self, size: [u32; 2]) -> [u32; 2] {
        fit(size, [self.columns * COLUMN_PIXELS, u32::MAX])
    }

    /// Returns the size of a picture in halves of characters, two to each, one above the other: no larger than the screen.
    pub fn dots_for(&self, size: [u32; 2]) -> [u32; 2] {
        // One line is the prompt's.
        let lines = self.lines.map_or(u32::MAX, |lines| lines.saturating_sub(1).max(1).saturating_mul(2));
        fit(size, [self.columns, lines])
    }
}

/// Returns a size of the same shape within bounds; no larger than it was.
fn fit([w, h]: [u32; 2], [max_w, max_h]: [u32; 2]) -> [u32; 2] {
    let factor = (f64::from(max_w) / f64::from(w)).min(f64::from(max_h) / f64::from(h)).min(1.0);
    [w, h].map(|n| ((f64::from(n) * factor).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(variables: &[(&str, &str)]) -> Terminal {
        Terminal::new((24, 100), |name| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned()))
    }

    #[test]
    fn variables_tell_the_protocol() {
        let protocol = |variables: &[(&str, &str)]| with(variables).protocol();
        assert_eq!(protocol(&[("TERM", "xterm-kitty")]), Protocol::Kitty);
        assert_eq!(protocol(&[("TERM", "xterm-256color"), ("TERM_PROGRAM", "iTerm.app")]), Protocol::Iterm);
        assert_eq!(protocol(&[("TERM", "foot")]), Protocol::Sixel);
        assert_eq!(protocol(&[("TERM", "xterm-256color")]), Protocol::Blocks);
        assert_eq!(protocol(&[("TERM", "tmux-256color"), ("TERM_PROGRAM", "iTerm.app")]), Protocol::Blocks);
        assert!(with(&[("COLORTERM", "truecolor")]).true_color && !with(&[]).true_color);
    }

    #[test]
    fn pictures_fit_the_screen() {
        assert_eq!(with(&[]).dots_for([512, 512]), [46, 46]);
        assert_eq!(with(&[]).dots_for([4000, 400]), [100, 10]);
        assert_eq!(Terminal::none().dots_for([512, 512]), [80, 80]);
        assert_eq!(Terminal::none().dots_for([20, 5000]), [20, 5000]);
        assert_eq!(Terminal::none().pixels_for([1280, 100]), [640, 50]);
        assert_eq!((Terminal::none().columns_for([640, 9]), Terminal::none().columns_for([641, 9])), (None, Some(80)));
    }
}
