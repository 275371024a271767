//! The options of a renderer, each declared once.

use crate::error::OptionError;
use crate::options::{NumberRange, OptionKind, OptionSpec, OptionValue, Options};

/// One option of a renderer of type `R`: its description, and how to read and set it.
///
/// # Examples
/// ```
/// use vr_core::{DeclaredOption, OptionTable, Options};
///
/// #[derive(Clone, Copy, Default, PartialEq)]
/// enum Order { #[default] FrontToBack, BackToFront }
/// #[derive(Clone, Default)]
/// struct Marcher { order: Order, early: bool }
///
/// let words = [("front-to-back", Order::FrontToBack), ("back-to-front", Order::BackToFront)];
/// let order = DeclaredOption::choice("order", "direction of a ray", words, |m: &Marcher| m.order, |m, o| m.order = o);
/// let early = DeclaredOption::switch("early", "end rays early", |m: &Marcher| m.early, |m, on| m.early = on)
///     .refuse("goes with order=front-to-back alone", |m| m.early && m.order == Order::BackToFront);
/// let table = OptionTable::new("marcher", [order, early]);
/// let wrong = Options::new().with("order", "back-to-front").with("early", true);
/// assert!(table.configure(&Marcher::default(), &wrong).is_err());
/// ```
pub struct DeclaredOption<R> {
    spec: OptionSpec,
    /// Reads its value; `None` where the renderer's other settings leave it none.
    get: Getter<R>,
    set: Setter<R>,
    /// Changes the default renderer such that the option has a value, where its other settings leave it none.
    enable: fn(&mut R),
    refusals: Vec<Refusal<R>>,
}

type Getter<R> = Box<dyn Fn(&R) -> Option<OptionValue>>;
type Setter<R> = Box<dyn Fn(&mut R, &OptionValue)>;

/// A test for settings beside which the value of an option is wrong.
struct Refusal<R> {
    reason: &'static str,
    is_wrong: fn(&R) -> bool,
}

impl<R: 'static> DeclaredOption<R> {
    fn new(
        (key, help): (&'static str, &'static str),
        kind: OptionKind,
        get: impl Fn(&R) -> Option<OptionValue> + 'static,
        set: impl Fn(&mut R, &OptionValue) + 'static,
    ) -> Self {
        // The table fills in the default.
        let default = OptionValue::Switch(false);
        let spec = OptionSpec { key, kind, default, help, only_with: None, promises: false, aims: false };
        Self { spec, get: Box::new(get), set: Box::new(set), enable: |_| {}, refusals: Vec::new() }
    }

    /// A number of a range.
    pub fn number(
        key: &'static str,
        help: &'static str,
        range: NumberRange,
        get: fn(&R) -> f64,
        set: fn(&mut R, f64),
    ) -> Self {
        let set = number_setter(set);
        Self::new((key, help), OptionKind::Number(range), move |r| Some(get(r).into()), set)
    }

    /// A number that only some renderers have, such as a number of one variant of an enum: `get` gives `None` for the others. `only_with`
    /// says in the words of options which those are, and `enable` makes one of the default renderer, whose number is the default.
    ///
    /// `set` may leave a renderer without the number as it is, which is an error, or make it one that has it.
    pub fn number_only_with(
        (key, help): (&'static str, &'static str),
        range: NumberRange,
        (only_with, enable): (&'static str, fn(&mut R)),
        get: fn(&R) -> Option<f64>,
        set: fn(&mut R, f64),
    ) -> Self {
        let set = number_setter(set);
        let option = Self::new((key, help), OptionKind::Number(range), move |r| get(r).map(Into::into), set);
        Self { spec: OptionSpec { only_with: Some(only_with), ..option.spec }, enable, ..option }
    }

    /// A switch: true or false.
    pub fn switch(key: &'static str, help: &'static str, get: fn(&R) -> bool, set: fn(&mut R, bool)) -> Self {
        let set = move |r: &mut R, value: &OptionValue| {
            if let OptionValue::Switch(on) = value {
                set(r, *on);
            }
        };
        Self::new((key, help), OptionKind::Switch, move |r| Some(get(r).into()), set)
    }

    /// One of several words, each with its meaning. A renderer that is set to the meaning that it has stays as it is: `get` may leave out
    /// details that a word does not tell.
    ///
    /// # Panics
    /// The table panics if the renderer has a meaning without a word: a bug in the declaration.
    pub fn choice<T: Copy + PartialEq + 'static>(
        key: &'static str,
        help: &'static str,
        words: impl IntoIterator<Item = (&'static str, T)>,
        get: fn(&R) -> T,
        set: fn(&mut R, T),
    ) -> Self {
        let words: Vec<_> = words.into_iter().collect();
        let kind = OptionKind::Choice(words.iter().map(|(word, _)| *word).collect());
        let by_word = words.clone();
        let get_word = move |r: &R| {
            let meaning = get(r);
            Some(words.iter().find(|(_, m)| *m == meaning).expect("every meaning has a word").0.into())
        };
        let set = move |r: &mut R, value: &OptionValue| {
            if let OptionValue::Word(word) = value
                && let Some((_, meaning)) = by_word.iter().find(|(w, m)| w == word && *m != get(r))
            {
                set(r, *meaning);
            }
        };
        Self::new((key, help), kind, get_word, set)
    }

    /// Refuses the option's value, for a reason, where the renderer's other settings do not go with it.
    #[must_use]
    pub fn refuse(mut self, reason: &'static str, is_wrong: fn(&R) -> bool) -> Self {
        self.refusals.push(Refusal { reason, is_wrong });
        self
    }

    /// Marks the option's value as the largest error that the renderer promises.
    #[must_use]
    pub fn promise(self) -> Self {
        Self { spec: OptionSpec { promises: true, ..self.spec }, ..self }
    }

    /// Marks the option's value as the RMSE that the renderer aims at by settings of its own.
    #[must_use]
    pub fn aim(self) -> Self {
        Self { spec: OptionSpec { aims: true, ..self.spec }, ..self }
    }
}

fn number_setter<R: 'static>(set: fn(&mut R, f64)) -> impl Fn(&mut R, &OptionValue) + 'static {
    move |r, value| {
        if let OptionValue::Number(x) = value {
            set(r, *x);
        }
    }
}

/// Every option of a renderer of type `R`, each declared once: the rest follows from the declarations.
///
/// # Examples
/// ```
/// use vr_core::{DeclaredOption, NumberRange, OptionTable, Options};
/// #[derive(Clone, Default)]
/// struct Marcher { step: f64, skip: bool }
/// let table = OptionTable::<Marcher>::new("marcher", [
///     DeclaredOption::number("step", "length of a step", NumberRange::at_least(0.0).up_to(16.0), |m: &Marcher| m.step, |m, x| m.step = x),
///     DeclaredOption::switch("skip", "leave out what is empty", |m: &Marcher| m.skip, |m, on| m.skip = on),
/// ]);
/// let half = table.configure(&Marcher::default(), &Options::new().with("step", 0.5)).unwrap();
/// assert_eq!(half.step, 0.5);
/// let error = table.configure(&half, &Options::new().with("step", 17.0)).err().unwrap();
/// assert_eq!(error.to_string(), "option 'step' of renderer marcher: found 17; must be a number from 0 to 16");
/// ```
pub struct OptionTable<R> {
    renderer: &'static str,
    options: Vec<DeclaredOption<R>>,
}

impl<R: Clone + Default> OptionTable<R> {
    /// The table of a renderer, by its name. Options are set in this order.
    pub fn new(renderer: &'static str, options: impl Into<Vec<DeclaredOption<R>>>) -> Self {
        let mut options = options.into();
        for option in &mut options {
            let mut default = R::default();
            (option.enable)(&mut default);
            option.spec.default = (option.get)(&default).expect("a default value");
        }
        Self { renderer, options }
    }

    /// Description of each option, in order.
    pub fn specs(&self) -> Vec<OptionSpec> {
        self.options.iter().map(|option| option.spec.clone()).collect()
    }

    /// All options, with the values that a renderer has.
    pub fn values(&self, renderer: &R) -> Options {
        let value = |option: &DeclaredOption<R>| Some((option.spec.key.to_owned(), (option.get)(renderer)?));
        Options(self.options.iter().filter_map(value).collect())
    }

    /// A renderer with options set; those not given keep the value that they have.
    ///
    /// # Errors
    /// [`OptionError`] for an unknown key (naming the nearest one), a value of the wrong type or range, or options that do not go together.
    pub fn configure(&self, renderer: &R, options: &Options) -> Result<R, OptionError> {
        if let Some(key) = options.0.keys().find(|key| self.options.iter().all(|option| option.spec.key != **key)) {
            let nearest = self
                .options
                .iter()
                .map(|option| (strsim::damerau_levenshtein(option.spec.key, key), option.spec.key))
                .min()
                .filter(|&(distance, known)| distance <= 2.max(known.len() / 2))
                .map(|(_, known)| known);
            return Err(OptionError::Unknown { renderer: self.renderer, key: key.clone(), nearest });
        }
        // Set the options in the order of the table; refuse one that has no effect, or undoes an earlier one.
        let mut new = renderer.clone();
        let mut done: Vec<(&DeclaredOption<R>, &OptionValue)> = Vec::new();
        for option in &self.options {
            let Some(value) = options.0.get(option.spec.key) else { continue };
            option.spec.accepts(value).map_err(|allowed| self.error(option, value, allowed))?;
            (option.set)(&mut new, value);
            done.push((option, value));
            // One that was set before and is no longer what it was set to does not go with this one.
            if let Some((undone, was)) = done.iter().find(|(option, value)| (option.get)(&new).as_ref() != Some(*value))
            {
                let mut allowed = match undone.spec.key == option.spec.key {
                    true => "must be absent: it has no effect here".to_owned(),
                    false => format!("must be absent beside {}={was}", undone.spec.key),
                };
                if let Some(only_with) = option.spec.only_with {
                    allowed += &format!("; it goes with {only_with}");
                }
                return Err(self.error(option, value, allowed));
            }
        }
        self.check(&new)?;
        Ok(new)
    }

    /// Checks a renderer's settings: their ranges, and that they go together.
    ///
    /// # Errors
    /// The first option that has a wrong value.
    pub fn check(&self, renderer: &R) -> Result<(), OptionError> {
        for option in &self.options {
            let Some(value) = (option.get)(renderer) else { continue };
            option.spec.accepts(&value).map_err(|allowed| self.error(option, &value, allowed))?;
            if let Some(refusal) = option.refusals.iter().find(|refusal| (refusal.is_wrong)(renderer)) {
                return Err(self.error(option, &value, refusal.reason.to_owned()));
            }
        }
        Ok(())
    }

    fn error(&self, option: &DeclaredOption<R>, value: &OptionValue, allowed: String) -> OptionError {
        let (renderer, key) = (self.renderer, option.spec.key.to_owned());
        OptionError::Value { renderer, key, found: value.to_string(), allowed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Step {
        Uniform(f64),
        Local(f64),
    }

    #[derive(Clone, Debug, PartialEq)]
    struct Marcher {
        step: Step,
        skip: bool,
    }

    impl Default for Marcher {
        fn default() -> Self {
            Self { step: Step::Uniform(0.5), skip: true }
        }
    }

    const LOCAL: Step = Step::Local(1e-2);

    fn table() -> OptionTable<Marcher> {
        let kind = |m: &Marcher| if let Step::Local(_) = m.step { LOCAL } else { Step::Uniform(0.5) };
        OptionTable::new(
            "r",
            [
                DeclaredOption::choice(
                    "steps",
                    "",
                    [("uniform", Step::Uniform(0.5)), ("local", LOCAL)],
                    kind,
                    |m: &mut Marcher, step| m.step = step,
                ),
                DeclaredOption::<Marcher>::number_only_with(
                    ("step", ""),
                    NumberRange::above(0.0).up_to(16.0),
                    ("steps=uniform", |_| {}),
                    |m| if let Step::Uniform(x) = m.step { Some(x) } else { None },
                    |m, x| m.step = Step::Uniform(x),
                )
                .refuse("must be at most 1 without skip", |m| !m.skip && matches!(m.step, Step::Uniform(x) if x > 1.0)),
                DeclaredOption::number_only_with(
                    ("local-error", ""),
                    NumberRange::above(0.0).up_to(1.0),
                    ("steps=local", |m| m.step = LOCAL),
                    |m| if let Step::Local(x) = m.step { Some(x) } else { None },
                    |m, x| {
                        if let Step::Local(error) = &mut m.step {
                            *error = x;
                        }
                    },
                ),
                DeclaredOption::switch("skip", "", |m| m.skip, |m, on| m.skip = on),
            ],
        )
    }

    fn configured(options: Options) -> Result<Marcher, String> {
        table().configure(&Marcher::default(), &options).map_err(|e| e.to_string())
    }

    #[test]
    fn names_the_nearest_key_and_what_is_allowed() {
        let error = configured(Options::new().with("stop", 1.0)).unwrap_err();
        assert_eq!(error, "renderer r has no option 'stop'; did you mean 'step'?");
        for bad in [0.0.into(), f64::NAN.into(), true.into(), OptionValue::from("long")] {
            let error = configured(Options::new().with("step", bad)).unwrap_err();
            assert!(error.contains("must be a number above 0, at most 16"), "{error}");
        }
        let error = configured(Options::new().with("steps", "lokal")).unwrap_err();
        assert!(error.contains("must be one of uniform, local"), "{error}");
    }

    #[test]
    fn defaults_and_values_are_read_from_renderers() {
        let specs = table().specs();
        let defaults: Vec<String> = specs.iter().map(|s| format!("{}={}", s.key, s.default)).collect();
        assert_eq!(defaults, ["steps=uniform", "step=0.5", "local-error=0.01", "skip=true"]);
        for marcher in [Marcher::default(), Marcher { step: Step::Local(0.25), skip: false }] {
            let values = table().values(&marcher);
            assert_eq!(configured(values).unwrap(), marcher);
            assert_eq!(table().configure(&marcher, &Options::new()).unwrap(), marcher);
            // A word that is the renderer's already leaves the rest of its meaning as it is.
            let kind = Options(table().values(&marcher).0.into_iter().filter(|(key, _)| key == "steps").collect());
            assert_eq!(table().configure(&marcher, &kind).unwrap(), marcher);
        }
    }

    #[test]
    fn options_that_do_not_go_together_are_refused() {
        let local = || Options::new().with("steps", "local");
        assert_eq!(configured(local().with("local-error", 0.5)).unwrap().step, Step::Local(0.5));
        for (options, key, reason) in [
            (Options::new().with("local-error", 0.5), "local-error", "it goes with steps=local"),
            (local().with("step", 0.5), "step", "must be absent beside steps=local; it goes with steps=uniform"),
            (Options::new().with("step", 2.0).with("skip", false), "step", "at most 1 without skip"),
        ] {
            let error = configured(options).unwrap_err();
            assert!(error.contains(&format!("'{key}'")) && error.contains(reason), "{error}");
        }
        let long = Marcher { step: Step::Uniform(2.0), skip: false };
        assert!(table().check(&long).is_err() && table().check(&Marcher { skip: true, ..long }).is_ok());
    }
}
