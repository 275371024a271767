//! A renderer's options: named, typed, described, so that a command line and a scene file can set them.

use std::collections::BTreeMap;

use crate::error::OptionError;

/// One option of a renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct OptionSpec {
    /// Its name, in kebab case.
    pub key: &'static str,
    /// What values it takes.
    pub kind: OptionKind,
    /// What it is when not set.
    pub default: OptionValue,
    /// One line of help.
    pub help: &'static str,
}

/// What values an option takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OptionKind {
    /// A finite number above `above` and at most `most`.
    Number {
        /// Exclusive lower bound.
        above: f64,
        /// Inclusive upper bound.
        most: f64,
    },
    /// True or false.
    Switch,
    /// One of these words.
    Choice(&'static [&'static str]),
}

/// The value of an option.
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

impl std::fmt::Display for OptionValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Switch(b) => b.fmt(f),
            Self::Number(x) => x.fmt(f),
            Self::Word(w) => w.fmt(f),
        }
    }
}

/// Options that were set, by name.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct Options(pub BTreeMap<String, OptionValue>);

impl Options {
    /// None set.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets one.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<OptionValue>) -> Self {
        self.0.insert(key.to_owned(), value.into());
        self
    }

    /// Checks every option against a renderer's list; returns those set, in the list's order.
    ///
    /// # Errors
    /// [`OptionError`] for an unknown key (naming the nearest one) or a value of the wrong type or range.
    pub fn check<'a>(
        &'a self,
        renderer: &'static str,
        specs: &'a [OptionSpec],
    ) -> Result<Vec<(&'static str, &'a OptionValue)>, OptionError> {
        for key in self.0.keys() {
            if !specs.iter().any(|s| s.key == key) {
                let nearest = specs
                    .iter()
                    .map(|s| (strsim::damerau_levenshtein(s.key, key), s.key))
                    .min()
                    .filter(|&(distance, known)| distance <= 2.max(known.len() / 2))
                    .map(|(_, known)| known);
                return Err(OptionError::Unknown { renderer, key: key.clone(), nearest });
            }
        }
        let set = specs.iter().filter_map(|s| self.0.get(s.key).map(|v| (s, v)));
        set.map(|(spec, value)| match spec.accepts(value) {
            Ok(()) => Ok((spec.key, value)),
            Err(allowed) => {
                Err(OptionError::Value { renderer, key: spec.key.to_owned(), found: value.to_string(), allowed })
            }
        })
        .collect()
    }
}

impl OptionSpec {
    /// Whether a value is allowed; if not, what would be.
    fn accepts(&self, value: &OptionValue) -> Result<(), String> {
        match (self.kind, value) {
            (OptionKind::Number { above, most }, OptionValue::Number(x)) if *x > above && *x <= most => Ok(()),
            (OptionKind::Switch, OptionValue::Switch(_)) => Ok(()),
            (OptionKind::Choice(words), OptionValue::Word(w)) if words.contains(&w.as_str()) => Ok(()),
            _ => Err(self.kind.to_string()),
        }
    }
}

/// The word for a meaning, of a list that has one for each.
///
/// # Panics
/// Where the list has none: it is of the code, not of what somebody typed.
pub fn word_of<T: PartialEq>(words: &[(&'static str, T)], meaning: T) -> &'static str {
    words.iter().find(|(_, m)| *m == meaning).expect("every meaning has a word").0
}

/// The meaning of a word that [`Options::check`] has found among those of an [`OptionKind::Choice`].
///
/// # Panics
/// Where the list has no such word.
pub fn meaning_of<T: Copy>(words: &[(&'static str, T)], word: &str) -> T {
    words.iter().find(|(w, _)| *w == word).expect("checked against the list").1
}

impl std::fmt::Display for OptionKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number { above, most } => write!(f, "must be a number above {above} and at most {most}"),
            Self::Switch => f.write_str("must be true or false"),
            Self::Choice(words) => write!(f, "must be one of {}", words.join(", ")),
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

#[cfg(test)]
mod tests {
    use super::*;

    const SPECS: &[OptionSpec] = &[];

    #[test]
    fn names_the_nearest_key_and_what_is_allowed() {
        let specs = [OptionSpec {
            key: "step",
            kind: OptionKind::Number { above: 0.0, most: 16.0 },
            default: OptionValue::Number(0.5),
            help: "",
        }];
        assert!(Options::new().with("step", 1.0).check("r", &specs).is_ok());
        let e = Options::new().with("stop", 1.0).check("r", &specs).unwrap_err();
        assert_eq!(e.to_string(), "renderer r has no option 'stop'; did you mean 'step'?");
        for bad in [OptionValue::Number(0.0), OptionValue::Number(f64::NAN), OptionValue::Switch(true)] {
            assert!(matches!(Options::new().with("step", 1.0).check("r", SPECS), Err(OptionError::Unknown { .. })));
            let mut o = Options::new();
            o.0.insert("step".into(), bad);
            assert!(matches!(o.check("r", &specs), Err(OptionError::Value { .. })));
        }
    }
}
