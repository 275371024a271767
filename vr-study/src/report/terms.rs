//! Terms of a report, each explained where it stands: a tap or a click on the word opens the explanation, without any script.

use maud::{Markup, html};

/// Term and its explanation.
#[derive(Debug)]
pub(super) struct Term {
    /// Name within the page.
    id: &'static str,
    word: &'static str,
    meaning: &'static str,
}

const fn term(id: &'static str, word: &'static str, meaning: &'static str) -> Term {
    Term { id, word, meaning }
}

pub(super) const REFERENCE: Term = term(
    "reference",
    "reference",
    "The picture as it has to be: the integral of light along the ray through each pixel's centre, solved in double precision with a \
     bound on its own error. Every error on this page is a distance from it.",
);
pub(super) const RMSE: Term = term(
    "rmse",
    "RMSE",
    "Root of the mean of the squared errors over red, green, blue and opacity of all compared pixels: the size of a typical error. \
     Below 1/255 (0.0039) it is less than one step of 8 bits; 0 is a perfect picture.",
);
pub(super) const MAX: Term = term("max", "max", "Largest error of any component of any compared pixel.");
pub(super) const BIAS: Term = term(
    "bias",
    "bias",
    "Mean error with its sign: above 0 the picture is too bright or too opaque, below 0 too dark or too clear.",
);
pub(super) const P99: Term = term("p99", "99 %", "Error that 99 of 100 pixels stay below.");
pub(super) const OWN_MODEL: Term = term(
    "own-model",
    "own model",
    "RMSE against what the renderer itself sets out to draw, such as another reconstruction filter, solved exactly. It separates mistakes of \
     the program from the approximation of the method; a dash means that the renderer sets out to draw the reference.",
);
pub(super) const FUNCTION: Term = term(
    "function",
    "function",
    "RMSE against the phantom as the formula that it is, before it was sampled on a grid. It includes what the grid itself loses.",
);
pub(super) const FRONT: Term = term(
    "front",
    "front",
    "Settings that no other beats in both time and error (the Pareto front). A setting off the front is never the right choice here.",
);
pub(super) const SETTING: Term = term(
    "setting",
    "renderer and setting",
    "Algorithm that draws, and the name of its options; the command below a picture spells the options out.",
);
pub(super) const FRAME: Term = term(
    "frame",
    "ms a frame",
    "Milliseconds of one picture after preparation: median of all rounds, the views of a turning camera.",
);
pub(super) const SPREAD: Term = term(
    "spread",
    "min … max",
    "Shortest and longest round, in milliseconds: far apart, the machine was busy with other work.",
);
pub(super) const PREPARE: Term = term(
    "prepare",
    "prepare ms",
    "Milliseconds of the work that is done once for a scene, before the first picture: tables, blocks, encodings.",
);
pub(super) const MEMORY: Term =
    term("memory", "memory", "Bytes that preparation and pictures need at once, beyond the scene itself.");
pub(super) const SAMPLES: Term = term(
    "samples",
    "samples",
    "Evaluations of the volume for one picture: work counted without a clock, the same in every run.",
);
pub(super) const ORDER: Term = term(
    "order",
    "order of convergence",
    "Exponent p of the error as something is refined by h: error ≈ c·hᵖ. Of order 2, half the step leaves a quarter of the error. In a \
     plot it is the slope of the line.",
);
pub(super) const REFINED: Term =
    term("refined", "refined", "Quantity that is made smaller from point to point; everything else stays as it is.");
pub(super) const DOCUMENTED: Term =
    term("documented", "documented", "Order that the renderer's documentation claims, and this page puts to the test.");
pub(super) const MEASURED: Term = term(
    "measured",
    "measured",
    "Order of the errors found here: the slope of a straight line through those that rounding does not decide.",
);
pub(super) const TOLERANCE: Term = term(
    "tolerance",
    "may differ by",
    "Largest difference between the measured and the documented order at which the claim counts as held.",
);
pub(super) const CLAIM: Term = term("claim", "claim", "Method or setting about which an order is claimed.");
pub(super) const BOUND: Term = term(
    "bound",
    "bound",
    "Largest error, or RMSE where it says so, that the renderer documents for this case. Held: the error stays below. Rays counted: the \
     renderer itself told that so many rays are without a bound.",
);
pub(super) const EXPONENT: Term = term(
    "exponent",
    "exponent",
    "Power p with which time grows: time ≈ c·nᵖ. 1 is proportional; 3, along the side of a volume, is proportional to its voxels.",
);
pub(super) const PREMULTIPLIED: Term = term(
    "premultiplied",
    "premultiplied",
    "Colours that are multiplied by opacity already, as light arrives at the eye; in linear units, twice the number is twice the light.",
);

const ALL: [&Term; 23] = [
    &REFERENCE,
    &RMSE,
    &MAX,
    &BIAS,
    &P99,
    &OWN_MODEL,
    &FUNCTION,
    &FRONT,
    &SETTING,
    &FRAME,
    &SPREAD,
    &PREPARE,
    &MEMORY,
    &SAMPLES,
    &ORDER,
    &REFINED,
    &DOCUMENTED,
    &MEASURED,
    &TOLERANCE,
    &CLAIM,
    &BOUND,
    &EXPONENT,
    &PREMULTIPLIED,
];

impl Term {
    /// Returns the term as a word that opens its explanation.
    pub(super) fn word(&self) -> Markup {
        self.called(self.word)
    }

    /// Returns the term under another name that opens its explanation.
    pub(super) fn called(&self, word: &str) -> Markup {
        html! { button.term type="button" popovertarget={ "term-" (self.id) } title=(self.meaning) { (word) } }
    }
}

/// Returns the explanations of the terms that a page uses. A browser that cannot open them shows them all at the end of the page.
pub(super) fn explanations(page: &str) -> Markup {
    let used = ALL.iter().filter(|term| page.contains(&format!("popovertarget=\"term-{}\"", term.id)));
    html! {
        @for term in used {
            div.explanation popover id={ "term-" (term.id) } { b { (term.word) } " " (term.meaning) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_used_is_explained_and_nothing_else() {
        let word = RMSE.called("root mean square").into_string();
        let text = explanations(&word).into_string();
        assert!(word.contains("popovertarget=\"term-rmse\"") && word.contains(">root mean square<"));
        assert!(text.contains("id=\"term-rmse\"") && !text.contains("term-order"));
        let mut ids: Vec<&str> = ALL.iter().map(|term| term.id).collect();
        ids.dedup();
        assert_eq!(ids.len(), ALL.len());
        for Term { id, word, meaning } in ALL {
            assert!(meaning.ends_with('.') && !word.is_empty(), "{id}");
        }
    }
}
