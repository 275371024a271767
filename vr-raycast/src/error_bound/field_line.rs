//! Walk along a ray through a field of any kind, by the polynomials that it gives.

use vr_core::Real;
use vr_core::field::{Chord, Field, FieldLine, LineModel, Poly, Stretch};
use vr_core::{Clip, Ray};

use super::looks::Looks;
use super::normals::{Gradients, Normals};
use super::polynomials::{CubicVector, Polynomials};
use super::tint::Tint;
use super::walk::{Course, Jump};

/// Largest number of halvings of a stretch of which the field knows too little.
const MAX_HALVINGS: u32 = 10;

/// Field along one ray.
pub(super) struct FieldWay<'a> {
    line: Box<dyn FieldLine + 'a>,
    breakpoints: Vec<f64>,
    /// Parts of it whose range is known, ascending; none where the field does not tell.
    stretches: Vec<Stretch>,
    gradients: Option<&'a Gradients>,
    /// Error that is promised.
    error: f64,
}

impl<'a> FieldWay<'a> {
    /// Returns a field along a ray, within a clip and up to a world distance; `None` where the ray does not meet it.
    pub(super) fn new(
        field: &'a dyn Field,
        (ray, clip, far): (&Ray, &Clip, f64),
        gradients: Option<&'a Gradients>,
        error: f64,
    ) -> Option<Self> {
        let line = field.along(ray, clip, far, gradients.is_some())?;
        let (chord, mut breakpoints, mut stretches) = (line.chord(), Vec::new(), Vec::new());
        line.breakpoints(&mut breakpoints);
        field.stretches(ray, [chord.start, chord.end].map(|s| s + chord.offset), &mut stretches);
        for stretch in &mut stretches {
            (stretch.from, stretch.to) = (stretch.from - chord.offset, stretch.to - chord.offset);
        }
        Some(Self { line, breakpoints, stretches, gradients, error })
    }

    pub(super) fn chord(&self) -> Chord {
        self.line.chord()
    }

    /// Takes a course along the ray. Returns false if the field has no bounds, but estimates.
    pub(super) fn walk<R: Real>(&self, course: &mut impl Course) -> bool {
        let (mut certain, mut stretches) = (true, self.stretches.iter().peekable());
        let mut before = None;
        for ends in self.breakpoints.windows(2).filter(|ends| ends[1] > ends[0]) {
            if course.is_done() {
                break;
            }
            let (from, to) = (ends[0], ends[1]);
            while stretches.next_if(|stretch| stretch.to < to).is_some() {}
            let within = stretches.peek().filter(|stretch| stretch.from <= from && to <= stretch.to);
            let range = within.map(|stretch| stretch.range.map(f64::from));
            if range.is_some_and(|range| course.passes_values(range)) {
                self.jump(from, [before, range], to - from, course);
                before = range;
                continue;
            }
            let model = self.line.between(from, to);
            let range = model.as_ref().map(LineModel::range);
            self.jump(from, [before, range], to - from, course);
            before = range;
            if let Some(model) = model {
                certain &= self.part::<R>(&model, [from, to], 0, course);
            }
        }
        if let Some(&end) = self.breakpoints.last().filter(|_| !course.is_done()) {
            self.jump(end, [before, None], f64::INFINITY, course);
        }
        certain
    }

    /// Tells a course of a breakpoint whose place is not known to the last bit.
    fn jump(&self, at: f64, sides: [Option<[f64; 2]>; 2], length: f64, course: &mut impl Course) {
        let misplaced = self.line.misplaced(at);
        if misplaced > 0.0 {
            let short = length <= 2.0 * misplaced;
            course.jump(&Jump { misplaced, sides, short });
        }
    }

    /// Hands a stretch over, or its halves where the field knows more of those.
    fn part<R: Real>(&self, model: &LineModel, [from, to]: [f64; 2], halvings: u32, course: &mut impl Course) -> bool {
        if course.is_done() || course.passes_values(model.range()) {
            return model.certain;
        }
        let reach = model.field.spread(1.0);
        let base = model.field.coefficients()[0];
        let enough = course.resolution(model.range());
        let middle = 0.5 * (from + to);
        // Roundings of the field are no smaller anywhere.
        let rounding = 64.0 * f64::EPSILON * (reach + base.abs());
        if halvings < MAX_HALVINGS && model.field_error > enough.max(rounding) && from < middle && middle < to {
            let halves = [[from, middle], [middle, to]].map(|ends| (ends, self.line.between(ends[0], ends[1])));
            let errors = halves.iter().flat_map(|(_, half)| half).map(|half| half.field_error).fold(0.0, f64::max);
            // A field that knows no more of the halves knows no more of shorter parts.
            if errors <= 0.5 * model.field_error {
                return halves.iter().fold(true, |certain, (ends, half)| {
                    half.as_ref().is_none_or(|half| self.part::<R>(half, *ends, halvings + 1, course)) && certain
                });
            }
        }
        self.pieces::<R>(model, [from, to], course);
        model.certain
    }

    fn pieces<R: Real>(&self, model: &LineModel, ends: [f64; 2], course: &mut impl Course) {
        let (base, reach) = (model.field.coefficients()[0], model.field.spread(1.0));
        let steepest = |gradient: &[Poly; 3]| {
            gradient.iter().map(|g| g.coefficients()[0].abs() + g.spread(1.0)).fold(0.0, f64::max)
        };
        let gradient = model.gradient.map(|gradient| (gradient, model.gradient_error, steepest(&gradient)));
        let [from, to] = ends;
        let colors = self.line.color(from, to).map(|color| (color.channels, color.error));
        let looks = |_: [f64; 2], gradient: Option<&CubicVector>, colors: Option<&CubicVector>| {
            let normals = match (self.gradients, gradient) {
                (None, _) => Normals::Absent,
                (Some(gradients), Some(cubics)) => gradients.by_cubics(cubics, 0.0),
                (Some(_), None) => Normals::Unknown,
            };
            Looks { normals, tint: colors.map_or(Tint::White, |colors| Tint::Along(*colors)) }
        };
        if model.field.is_constant() && model.field_error == 0.0 {
            // Along a stretch of one value colours may change.
            if colors.as_ref().is_none_or(|(channels, _)| channels.iter().all(Poly::is_constant)) {
                let gradient = gradient.as_ref().map(|(gradient, off, _)| CubicVector::whole(gradient, *off));
                let colors = colors.as_ref().map(|(colors, off)| CubicVector::whole(colors, *off));
                return course.constant(base, || looks(ends, gradient.as_ref(), colors.as_ref()), from, to - from);
            }
        }
        let pieces = Polynomials {
            field: model.field + Poly::constant(-base),
            off: model.field_error,
            base,
            reach,
            limits: model.limits,
            misplaced: ends.map(|at| self.line.misplaced(at)).iter().sum::<f64>() / (ends[1] - ends[0]),
            gradient,
            colors,
            ends,
            error: self.error,
            looks: &looks,
        };
        pieces.hand_over::<R>(course);
    }
}
