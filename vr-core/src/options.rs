//! A renderer's options: named, typed, described, so that a command line and a scene file can set them.

use std::collections::BTreeMap;
use std::fmt;

/// One option of a renderer.
///
/// # Examples
/// ```
/// use vr_core::{DeclaredOption, NumberRange, OptionTable};
///
/// #[derive(Clone)]
/// struct Marcher { step: f64 }
/// impl Default for Marcher {
///     fn default() -> Self { Self { step: 0.5 } }
/// }
/// let range = NumberRange::above(0.0).up_to(16.0);
/// let step = DeclaredOption::number("step", "length of a step", range, |m: &Marcher| m.step, |m, x| m.step = x);
/// let spec = &OptionTable::new("marcher", [step]).specs()[0];
/// let line = format!("{}: {} ({}; default {})", spec.key, spec.help, spec.kind, spec.default);
/// assert_eq!(line, "step: length of a step (a number above 0, at most 16; default 0.5)");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct OptionSpec {
    /// Its name, in kebab case.
    pub key: &'static str,
    /// Values that it takes.
    pub kind: OptionKind,
    /// Its value when it is not set.
    pub default: OptionValue,
    /// One line of help.
    pub help: &'static str,
    /// Setting of another option without which this one must be absent, such as `steps=local`.
    pub only_with: Option<&'static str>,
    /// True if its value is the largest error that the renderer promises.
    pub promises: bool,
    /// True if its value is the RMSE that the renderer aims at by settings of its own, in units of max(1, the picture's largest magnitude).
    pub aims: bool,
}

impl OptionSpec {
    /// Checks the type and the range of a value.
    ///
    /// # Errors
    /// The values that would be right, as a message ends.
    pub(crate) fn accepts(&self, value: &OptionValue) -> Result<(), String> {
        let fits = match (&self.kind, value) {
            (OptionKind::Number(range), OptionValue::Number(x)) => range.contains(*x),
            (OptionKind::Switch, OptionValue::Switch(_)) => true,
            (OptionKind::Choice(words), OptionValue::Word(w)) => words.contains(&w.as_str()),
            _ => false,
        };
        if fits { Ok(()) } else { Err(format!("must be {}", self.kind)) }
    }
}

/// Values that an option takes.
///
/// # Examples
/// ```
/// use vr_core::OptionKind;
///
/// assert_eq!(OptionKind::Switch.to_string(), "true or false");
/// assert_eq!(OptionKind::Choice(vec!["post", "pre"]).to_string(), "one of post, pre");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum OptionKind {
    /// A number of a range.
    Number(NumberRange),
    /// True or false.
    Switch,
    /// One of these words.
    Choice(Vec<&'static str>),
}

impl fmt::Display for OptionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(range) => range.fmt(f),
            Self::Switch => f.write_str("true or false"),
            Self::Choice(words) => write!(f, "one of {}", words.join(", ")),
        }
    }
}

/// Finite numbers between two ends, each of which may belong to the range or not.
///
/// # Examples
/// ```
/// use vr_core::NumberRange;
/// let edge = NumberRange::at_least(8.0).up_to(1024.0).whole().or_zero();
/// assert!(edge.contains(0.0) && edge.contains(8.0) && !edge.contains(9.5));
/// assert_eq!(edge.to_string(), "a whole number from 8 to 1024, or 0");
/// assert_eq!(NumberRange::above(0.0).up_to(1.0).to_string(), "a number above 0, at most 1");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberRange {
    low: f64,
    has_low: bool,
    high: f64,
    has_high: bool,
    whole: bool,
    zero: bool,
}

impl NumberRange {
    const ALL: Self = Self {
        low: f64::NEG_INFINITY,
        has_low: false,
        high: f64::INFINITY,
        has_high: false,
        whole: false,
        zero: false,
    };

    /// The range of numbers above `low`, which does not belong to it.
    pub const fn above(low: f64) -> Self {
        Self { low, ..Self::ALL }
    }

    /// The range of numbers from `low` on, which belongs to it.
    pub const fn at_least(low: f64) -> Self {
        Self { low, has_low: true, ..Self::ALL }
    }

    /// Limits the range to numbers up to `high`, which belongs to it.
    #[must_use]
    pub const fn up_to(self, high: f64) -> Self {
        Self { high, has_high: true, ..self }
    }

    /// Limits the range to numbers below `high`, which does not belong to it.
    #[must_use]
    pub const fn below(self, high: f64) -> Self {
        Self { high, has_high: false, ..self }
    }

    /// Limits the range to whole numbers.
    #[must_use]
    pub const fn whole(self) -> Self {
        Self { whole: true, ..self }
    }

    /// Adds 0 to the range.
    #[must_use]
    pub const fn or_zero(self) -> Self {
        Self { zero: true, ..self }
    }

    /// True if a number belongs to the range; infinities and NaN never do.
    pub fn contains(&self, x: f64) -> bool {
        let above = x > self.low || self.has_low && x == self.low;
        let below = x < self.high || self.has_high && x == self.high;
        above && below && x.is_finite() && (!self.whole || x.fract() == 0.0) || self.zero && x == 0.0
    }
}

impl fmt::Display for NumberRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.whole { "a whole number" } else { "a number" })?;
        let (low, high) = (OptionValue::Number(self.low), OptionValue::Number(self.high));
        match (self.has_low, self.has_high) {
            (true, true) => write!(f, " from {low} to {high}")?,
            (true, false) => write!(f, ", {low} or more")?,
            (false, _) => write!(f, " above {low}")?,
        }
        match self.has_high {
            true if !self.has_low => write!(f, ", at most {high}")?,
            false if self.high.is_finite() => write!(f, ", below {high}")?,
            _ => {}
        }
        f.write_str(if self.zero { ", or 0" } else { "" })
    }
}

/// The value of an option.
///
/// # Examples
/// ```
/// use vr_core::OptionValue;
///
/// // A command line gives text, code gives values.
/// assert_eq!(OptionValue::parse("0.5"), OptionValue::from(0.5));
/// assert_eq!(OptionValue::parse("true"), OptionValue::from(true));
/// assert_eq!(OptionValue::parse("bspline"), OptionValue::from("bspline"));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(untagged))]
pub enum OptionValue {
    /// True or false.
    Switch(bool),
    /// A number.
    Number(f64),
    /// A word.
    Word(String),
}

impl OptionValue {
    /// Reads a value as a command line gives it.
    pub fn parse(text: &str) -> Self {
        match text {
            "true" => Self::Switch(true),
            "false" => Self::Switch(false),
            _ => text.parse().map_or_else(|_| Self::Word(text.to_owned()), Self::Number),
        }
    }
}

impl fmt::Display for OptionValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Switch(b) => b.fmt(f),
            // Without the zeros that decimal notation gives a very small or large number.
            Self::Number(x) if *x != 0.0 && !(1e-4..1e9).contains(&x.abs()) => write!(f, "{x:e}"),
            Self::Number(x) => x.fmt(f),
            Self::Word(w) => w.fmt(f),
        }
    }
}

impl From<f64> for OptionValue {
    fn from(x: f64) -> Self {
        Self::Number(x)
    }
}

impl From<bool> for OptionValue {
    fn from(b: bool) -> Self {
        Self::Switch(b)
    }
}

impl From<&str> for OptionValue {
    fn from(w: &str) -> Self {
        Self::Word(w.to_owned())
    }
}

/// Options that were set, by name.
///
/// # Examples
/// ```
/// use vr_core::{OptionValue, Options};
///
/// let options = Options::new().with("step", 0.5).with("skip", true).with("step", 0.25);
/// assert_eq!(options.0.len(), 2);
/// assert_eq!(options.0["step"], OptionValue::Number(0.25));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Options(pub BTreeMap<String, OptionValue>);

impl Options {
    /// Options of which none is set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets an option.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<OptionValue>) -> Self {
        self.0.insert(key.to_owned(), value.into());
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_know_their_ends() {
        for (range, inside, outside, words) in [
            (NumberRange::above(0.0).up_to(16.0), [1e-300, 16.0], [0.0, 16.1], "a number above 0, at most 16"),
            (NumberRange::at_least(0.0).up_to(16.0), [0.0, 16.0], [-1e-300, 17.0], "a number from 0 to 16"),
            (NumberRange::at_least(0.0), [0.0, 1e300], [-1.0, f64::INFINITY], "a number, 0 or more"),
            (NumberRange::at_least(0.0).below(1.0), [0.0, 0.9999], [1.0, -0.1], "a number, 0 or more, below 1"),
            (NumberRange::above(0.0).below(1.0), [0.1, 0.9999], [1.0, 0.0], "a number above 0, below 1"),
            (NumberRange::at_least(1e-13).up_to(0.01), [1e-13, 0.01], [0.0, 0.02], "a number from 1e-13 to 0.01"),
            (NumberRange::at_least(0.5).up_to(8.0).or_zero(), [0.0, 8.0], [0.1, 9.0], "a number from 0.5 to 8, or 0"),
            (NumberRange::at_least(8.0).whole(), [8.0, 1e9], [8.5, 7.0], "a whole number, 8 or more"),
        ] {
            assert_eq!(range.to_string(), words);
            assert!(inside.iter().all(|&x| range.contains(x)), "{words}");
            assert!(outside.iter().chain(&[f64::NAN]).all(|&x| !range.contains(x)), "{words}");
        }
    }

    #[test]
    fn numbers_are_short() {
        for (x, text) in [(0.0, "0"), (0.5, "0.5"), (1e-13, "1e-13"), (1_048_576.0, "1048576"), (5e-4, "0.0005")] {
            assert_eq!(OptionValue::Number(x).to_string(), text);
            assert_eq!(OptionValue::parse(text), OptionValue::Number(x));
        }
    }
}
