//! One smooth stretch of a ray: optical depth and light, with an a-priori bound on the error of the quadrature.
//!
//! On a stretch the field f is a polynomial and lies in one segment of the transfer function, so κ∘f is analytic. The bound
//! looks at the Bernstein ellipse of parameter ρ around the stretch (sum of semi-axes ρ, a = (ρ + 1/ρ)/2 the major one): there
//! |f − f₀| ≤ Σ |cₖ| aᵏ =: S, hence α stays in a disc of radius r = |dα/df| S around α₀, and if r < 1 − α₀, κ = −ln(1 − α)/u
//! is analytic and bounded. With a bound M on an ellipse, n + 1 Chebyshev points miss at most
//!
//! * 4 M ρ⁻ⁿ/(ρ − 1) of a function in interpolation (Trefethen, *Approximation Theory and Approximation Practice*, 2013,
//!   theorem 8.2), hence at most that times the length of an integral of the interpolant;
//! * 4.2 M ρ^−(n+2)/(1 − ρ⁻²) of an integral over [−1, 1] by Clenshaw-Curtis with even n: the coefficients of T_k are at most
//!   2 M ρ⁻ᵏ, those up to n are integrated exactly, odd ones vanish, and each other one is off by at most 2 + 2/(k² − 1).
//!
//! Light of a density emitter, q = κ c with c linear in f (times the colour of the place, another polynomial, where there is one), is integrated by parts, so that κ may be as large as it likes:
//! ∫ κ c e^(−τ) ds = c(a) E(b) + ∫ c' (E(b) − E) ds with E = 1 − e^(−τ).

use vr_core::bound::{Bound, largest};
use vr_core::field::{LineColor, LineModel, Poly};
use vr_core::transfer::Segment;
use vr_core::{OpacityRule, Shading};

use crate::component::{Component, Linear, Share, extinction_of};
use crate::nodes::{DEGREES, Rule, rule};
use crate::optics::Optics;
use crate::transport::Place;

/// Light and depth of a stretch, not yet dimmed by the medium in front.
#[derive(Clone, Copy, Debug)]
pub struct Gain {
    /// Optical depth.
    pub depth: f64,
    /// Upper bound of the error of `depth`.
    pub depth_error: Bound,
    /// Light at the stretch's front.
    pub light: [f64; 3],
    /// Upper bound of the error of each component of `light`.
    pub light_error: Bound,
}

/// A stretch on which everything is smooth.
pub struct Leaf<'a> {
    optics: &'a Optics<'a>,
    model: &'a LineModel,
    /// Colour of the places, by which colours and emissions are multiplied.
    place: Option<&'a LineColor>,
    /// Half its length in world units.
    half: f64,
    shade: Option<Shade<'a>>,
    /// Component that there is, and a second one where the medium is a mixture of two rows.
    component: Component,
    other: Option<Component>,
    /// Largest slopes of opacity, colour and emission by the value, over the range that the field's error leaves open.
    steepest: Slopes,
}

/// Slopes by the value.
#[derive(Clone, Copy, Default)]
struct Slopes {
    alpha: f64,
    color: f64,
    emission: f64,
}

impl Slopes {
    /// The steepest in any segment that a range of values touches.
    fn within(optics: &Optics<'_>, [low, high]: [f64; 2]) -> Self {
        let mut steepest = Self::default();
        let touched = optics.of_rows(optics.touching(low, high));
        for s in touched.filter(|s| s.from.is_finite() && s.to.is_finite()) {
            let span = s.to - s.from;
            let apart = |a: [f64; 3], b: [f64; 3]| largest((0..3).map(|c| a[c] - b[c])) / span;
            steepest.alpha = steepest.alpha.max((s.end.opacity - s.start.opacity).abs() / span);
            steepest.color = steepest.color.max(apart(s.start.color, s.end.color));
            steepest.emission = steepest.emission.max(apart(s.start.emission, s.end.emission));
        }
        steepest
    }
}

/// The gradient's part in a stretch.
struct Shade<'a> {
    shading: &'a Shading,
    /// g·g
    square: Poly,
    /// g·l and g·h of every light.
    towards: Vec<(f64, [Poly; 2])>,
}

/// Ellipses tried: the largest on which everything is still analytic and small wins.
const RHO: [f64; 9] = [1.25, 1.6, 2.2, 3.2, 5.0, 8.0, 14.0, 30.0, 100.0];

/// A rule, and the bounds on its errors.
pub struct Choice {
    which: usize,
    depth_error: Bound,
    light_error: Bound,
}

impl<'a> Leaf<'a> {
    pub fn new(optics: &'a Optics<'a>, segment: &'a Segment, (model, place): Place<'a>, half: f64) -> Self {
        let f0 = model.field.coefficients()[0];
        let shade = optics.shading.as_ref().and_then(|(shading, ray)| {
            let g = model.gradient.as_ref()?;
            let dot = |v: [f64; 3]| g[0] * v[0] + g[1] * v[1] + g[2] * v[2];
            let square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
            let towards = ray.lights.iter().map(|l| (largest(l.color), [dot(l.to_light), dot(l.half)])).collect();
            Some(Shade { shading, square, towards })
        });
        let magnitude = shade.as_ref().map_or(0.0, |s| s.square.at(0.0).max(0.0).sqrt());
        // A gradient that does not change has one factor, at a knot of the factors, too.
        let constant = shade.as_ref().is_none_or(|s| s.square.is_constant());
        let (component, other) = if optics.transfer.has_rows() {
            let mix = optics.transfer.row_mix(magnitude);
            let index = optics.index_of(segment);
            let of_row = |row: usize, middle: f64, slope: f64| {
                let share = Share { middle, slope: if constant { 0.0 } else { slope } };
                Component::new(&optics.transfer.rows()[row].transfer.segments()[index], f0, share)
            };
            let other = (mix.upper != mix.lower).then(|| of_row(mix.upper, mix.share, mix.slope));
            (of_row(mix.lower, 1.0 - mix.share, -mix.slope), other)
        } else {
            let share = shade.as_ref().map_or(Share::ALL, |s| Share {
                middle: s.shading.modulation(magnitude),
                slope: if constant { 0.0 } else { modulation_slope(s.shading, magnitude) },
            });
            (Component::new(segment, f0, share), None)
        };
        let steepest = Slopes::within(optics, model.range());
        Self { optics, model, place, half, shade, component, other, steepest }
    }

    /// The components of the medium.
    fn components(&self) -> impl Iterator<Item = &Component> {
        std::iter::once(&self.component).chain(&self.other)
    }

    /// True if extinction has a factor that may change with the gradient.
    fn follows_gradient(&self) -> bool {
        let factors = self.shade.as_ref().is_some_and(|s| !s.shading.gradient_opacity.is_empty());
        factors || self.other.is_some()
    }

    /// Largest bound of a quantity of the components, at most `spread` of the field away from its middle.
    fn brightest(&self, quantity: impl Fn(&Component) -> [Linear; 3], spread: f64) -> f64 {
        largest(self.components().flat_map(quantity).map(|l| l.bound(spread)))
    }

    /// True if light is reflected: the gradient exists and is not zero throughout.
    fn is_shaded(&self) -> bool {
        let is_flat = |s: &Shade<'_>| self.optics.transfer.has_rows() && s.shading.is_flat();
        let has_gradient = |s: &Shade<'_>| !(s.square.is_constant() && s.square.at(0.0) == 0.0);
        self.shade.as_ref().is_some_and(|s| has_gradient(s) && !is_flat(s))
    }

    /// The rule that misses no more than the given light and depth; `None` if neither does, or no ellipse is free of
    /// singularities.
    pub fn choose(&self, light_share: f64, depth_share: f64) -> Option<Choice> {
        let mut best: [Option<Choice>; 2] = [None, None];
        for rho in RHO {
            let Some(size) = self.on_ellipse(rho) else { break };
            for which in 0..DEGREES.len() {
                let n = DEGREES[which] as i32;
                let decay = rho.powi(-n);
                let depth_error = Bound::new(2.0 * self.half * 4.0 * size.extinction * decay / (rho - 1.0));
                let quadrature = Bound::new(4.2 * size.integrand * decay / (rho * rho - 1.0));
                // An extinction that does not change is integrated without error, however bright it is.
                let from_depth =
                    if depth_error == Bound::ZERO { Bound::ZERO } else { depth_error * size.light_per_depth };
                let light_error = quadrature + from_depth;
                let worst = |c: &Choice| (c.light_error / light_share).max(c.depth_error / depth_share);
                let choice = Choice { which, depth_error, light_error };
                if best[which].as_ref().is_none_or(|b| worst(&choice) < worst(b)) {
                    best[which] = Some(choice);
                }
            }
        }
        let fits = |c: &Choice| c.light_error.within(light_share) && c.depth_error.within(depth_share);
        best.into_iter().flatten().find(fits)
    }

    /// Bounds on one ellipse; `None` if something is singular in it.
    fn on_ellipse(&self, rho: f64) -> Option<Size> {
        let (a, b) = (0.5 * (rho + 1.0 / rho), 0.5 * (rho - 1.0 / rho));
        let spread = self.model.field.spread(a);
        // κ = base + variation, its real part in [low, high], |Im κ| ≤ turn.
        let Ellipse { variation, low, high, turn } = self.component_on_ellipse(&self.component, spread)?;
        let mut size_of_kappa = high.abs().max(low.abs()) + turn;
        let mut extinction = variation;
        // −Re τ along the straight way from −1 to any point of the ellipse.
        let mut growth = self.half * (high.max(0.0) * (a - 1.0) + (-low).max(0.0) * (1.0 + a) + turn * b);
        let mut reflect = (1.0, 0.0);
        // Of two components: bounds of the factors on them, and of κ of each.
        let mut mixed = None;
        if let Some(s) = &self.shade {
            let (g, g_spread) = (s.square.coefficients()[0], s.square.spread(a));
            if self.is_shaded() {
                if !is_below(g_spread, g) {
                    return None;
                }
                reflect = s.reflect_bound(a, g - g_spread)?;
            }
            if self.components().any(|c| c.share.slope != 0.0) && !is_below(g_spread, g) {
                return None;
            }
            if self.follows_gradient() {
                let factor = self.component.share.bound(g, g_spread);
                size_of_kappa *= factor;
                if let Some(other) = &self.other {
                    let Ellipse { low, high, turn, .. } = self.component_on_ellipse(other, spread)?;
                    let other_factor = other.share.bound(g, g_spread);
                    let other_size = (high.abs().max(low.abs()) + turn) * other_factor;
                    mixed = Some([(factor, size_of_kappa), (other_factor, other_size)]);
                    size_of_kappa += other_size;
                }
                extinction = size_of_kappa;
                growth = self.half * (1.0 + a + b) * size_of_kappa;
            }
        }
        // Past e^30 the bound is useless anyway, and infinities would become NaN.
        if !is_below(growth, 30.0) {
            return None;
        }
        let growth = libm::exp(growth);
        // A bound of the colour of the places, and of its slope.
        let (tint, tint_slope) = self.place.map_or((1.0, 0.0), |color| {
            let slope = |p: &Poly| p.at(0.0).abs() + p.spread(a);
            let size = largest(color.channels.iter().map(|p| p.coefficients()[0].abs() + p.spread(a)));
            (size, largest(color.channels.iter().map(|p| slope(&p.derivative()))))
        });
        let brightest = |l: &[Linear; 3]| largest(l.iter().map(|l| l.bound(spread)));
        let (integrand, light_per_depth) = if let Some(mixed) = mixed {
            let emits = self.optics.transfer.has_emission();
            let emission = |(c, (factor, kappa)): (&Component, (f64, f64))| match emits {
                true => factor * brightest(&c.emission) * tint,
                false => kappa * (brightest(&c.color) * tint * reflect.0 + reflect.1),
            };
            let q = self.components().zip(mixed).map(emission).sum::<f64>() * self.half;
            (q * growth, 2.0 * q)
        } else if self.optics.transfer.has_emission() {
            let e = brightest(&self.component.emission) * self.half * tint;
            (e * growth, 2.0 * e)
        } else if self.is_shaded() {
            let c = brightest(&self.component.color) * tint * reflect.0 + reflect.1;
            (self.half * size_of_kappa * c * growth, c * 2.0 * self.half * size_of_kappa)
        } else {
            let slope = largest(self.component.color.iter().map(|l| l.slope));
            let run = self.model.field.derivative();
            let run = run.at(0.0).abs() + run.spread(a);
            // |E(b) − E(z)| ≤ |τ(b) − τ(z)| times the growth.
            let apart = (self.half * size_of_kappa * (1.0 + a)).min(2.0) * growth;
            let color = brightest(&self.component.color);
            ((slope * run * tint + color * tint_slope) * apart, 3.0 * color * tint)
        };
        Some(Size { extinction, integrand, light_per_depth })
    }

    /// Bounds of a component's κ on an ellipse, before its share; `None` if it is singular in it.
    fn component_on_ellipse(&self, component: &Component, spread: f64) -> Option<Ellipse> {
        let unit = self.optics.transfer.unit_distance();
        let r = component.alpha.slope.abs() * spread;
        match self.optics.transfer.rule() {
            OpacityRule::Extinction => {
                let k = component.alpha.middle / unit;
                Some(Ellipse { variation: r / unit, low: k - r / unit, high: k + r / unit, turn: r / unit })
            }
            OpacityRule::Power => {
                let w = component.clear;
                if !is_below((self.noise(component) * 2.0 + r).value(), w) {
                    return None;
                }
                let kappa = |change: f64| self.extinction_of(component.alpha.middle + change, w - change);
                Some(Ellipse {
                    variation: -libm::log1p(-r / w) / unit,
                    low: kappa(-r),
                    high: kappa(r),
                    turn: libm::asin(r / w) / unit,
                })
            }
        }
    }

    /// Integrates with a chosen rule. Also returns the rule and the optical depth at its nodes.
    pub fn integrate(&self, choice: &Choice) -> (Gain, &'static Rule, Vec<f64>) {
        let rule = rule(choice.which);
        let f: Vec<f64> = rule.nodes.iter().map(|&t| self.model.field.at(t)).collect();
        let reflected: Option<Vec<_>> = self.reflected(rule);
        let shares: Vec<[f64; 2]> = rule.nodes.iter().map(|&t| self.shares_at(t)).collect();
        let kappas: Vec<[f64; 2]> = (0..f.len()).map(|j| self.extinctions_at(shares[j], f[j])).collect();
        let kappa: Vec<f64> = kappas.iter().map(|k| if self.other.is_some() { k[0] + k[1] } else { k[0] }).collect();
        let dot = |w: &[f64], v: &[f64]| w.iter().zip(v).map(|(w, v)| w * v).sum::<f64>();
        let tau: Vec<f64> = rule.running.iter().map(|w| self.half * dot(w, &kappa)).collect();
        let dimmed: Vec<f64> = tau.iter().map(|&t| -libm::expm1(-t)).collect();
        let depth = *tau.last().unwrap_or(&0.0);
        let opacity = *dimmed.last().unwrap_or(&0.0);
        let f0 = self.model.field.coefficients()[0];
        let run = self.model.field.derivative();
        let value = |l: &Linear, f: f64| l.middle + l.slope * (f - f0);
        let own = &self.component;
        // Colour of the places, and its slope, at the nodes.
        let tints = self.place.map(|color| {
            let slopes = color.channels.each_ref().map(Poly::derivative);
            let at = |&t: &f64| (color.at(t), slopes.each_ref().map(|slope| slope.at(t)));
            rule.nodes.iter().map(at).collect::<Vec<_>>()
        });
        let tint = |j: usize, c: usize| tints.as_ref().map_or(1.0, |tints| tints[j].0[c]);
        // The light of each channel: by parts for a density emitter without shading, else by its integrand.
        let (mut light, mut magnitude) = ([0.0; 3], Bound::ZERO);
        for c in 0..3 {
            let terms = |j: usize| -> f64 {
                if let Some(other) = &self.other {
                    let parts = [&self.component, other];
                    let emission = |i: usize| match (self.optics.transfer.has_emission(), &reflected) {
                        (true, _) => shares[j][i] * value(&parts[i].emission[c], f[j]) * tint(j, c),
                        (false, None) => kappas[j][i] * value(&parts[i].color[c], f[j]) * tint(j, c),
                        (false, Some(r)) => {
                            let (factor, added) = &r[j];
                            kappas[j][i] * (value(&parts[i].color[c], f[j]) * tint(j, c) * factor[c] + added[c])
                        }
                    };
                    self.half * (emission(0) + emission(1)) * (1.0 - dimmed[j])
                } else if self.optics.transfer.has_emission() {
                    self.half * value(&own.emission[c], f[j]) * tint(j, c) * (1.0 - dimmed[j])
                } else if let Some(r) = &reflected {
                    let (factor, added) = &r[j];
                    let color = value(&own.color[c], f[j]) * tint(j, c);
                    self.half * kappa[j] * (color * factor[c] + added[c]) * (1.0 - dimmed[j])
                } else {
                    let of_value = own.color[c].slope * run.at(rule.nodes[j]);
                    let slope = tints.as_ref().map_or(of_value, |tints| {
                        let (tint, tint_slope) = tints[j];
                        of_value * tint[c] + value(&own.color[c], f[j]) * tint_slope[c]
                    });
                    slope * (opacity - dimmed[j])
                }
            };
            let by_parts = !self.optics.transfer.has_emission() && reflected.is_none() && self.other.is_none();
            let (mut sum, mut size) = (0.0, 0.0);
            if by_parts {
                sum = value(&own.color[c], f[0]) * tint(0, c) * opacity;
                size = sum.abs();
            }
            for (j, w) in rule.weights.iter().enumerate() {
                let term = w * terms(j);
                sum += term;
                size += term.abs();
            }
            light[c] = sum;
            magnitude = magnitude.max(size);
        }
        let (depth_error, light_error) = self.rounding(depth, opacity, magnitude.value());
        let gain = Gain {
            depth,
            depth_error: choice.depth_error + depth_error,
            light,
            light_error: choice.light_error + light_error,
        };
        (gain, rule, tau)
    }

    /// Errors of depth and light by rounding, and by the field's own error.
    fn rounding(&self, depth: f64, opacity: f64, magnitude: f64) -> (Bound, Bound) {
        const ROUNDING: f64 = 8.0 * f64::EPSILON;
        let model = self.model;
        let length = 2.0 * self.half;
        let delta = model.error();
        let unit = self.optics.transfer.unit_distance();
        let spread = model.field.spread(1.0);
        let steepest = self.steepest;
        let factor = self.shade.as_ref().map_or(1.0, |s| s.shading.largest_modulation().max(1.0));
        let mut depth_error = Bound::new(24.0 * f64::EPSILON * depth);
        for component in self.components() {
            let (alpha, clear) = (component.alpha, component.clear);
            // How far off the opacity may be, and what that does to κ (a constant opacity is exact). Below ½ α has the digits of the sum
            // that it is, above it 1 − α has all of its own.
            let size = if alpha.middle - alpha.slope.abs() * spread < 0.5 {
                // a + t (b − a): roundings of a, and of what is added to it.
                component.first_opacity + alpha.bound(spread)
            } else {
                clear + alpha.slope.abs() * spread
            };
            let rounded = if alpha.slope == 0.0 { 0.0 } else { ROUNDING * size };
            let off = product(delta, steepest.alpha) + rounded;
            let steepness = match self.optics.transfer.rule() {
                OpacityRule::Extinction => Bound::new(1.0 / unit),
                OpacityRule::Power => {
                    let w = clear - alpha.slope.abs() * spread - off.value();
                    Bound::new(1.0 / (unit * if w > 0.0 { w } else { 0.0 }))
                }
            };
            depth_error += product(off, steepness * (length * factor));
        }
        let color = self.brightest(|c| c.color, spread);
        let mut light_error = Bound::new(24.0 * f64::EPSILON * magnitude);
        if self.optics.transfer.has_emission() {
            light_error += product(delta, length * steepest.emission) + product(depth_error, magnitude);
        } else {
            let bright = self.optics.brightest_surface().max(color);
            light_error += product(delta, 2.0 * steepest.color * opacity) + product(depth_error, 3.0 * bright);
            light_error += 4.0 * f64::EPSILON * self.optics.transfer.brightest_color() * opacity;
        }
        if let Some(place) = self.place {
            let size = largest(place.channels.iter().map(|p| p.coefficients()[0].abs() + p.spread(1.0)));
            let off = Bound::new(place.error) + ROUNDING * size;
            light_error += if self.optics.transfer.has_emission() {
                product(off, length * self.brightest(|c| c.emission, spread))
            } else {
                product(off, 2.0 * color * self.optics.largest_color_factor() * opacity)
            };
        }
        if let Some(s) = &self.shade {
            let off = model.slope_error();
            if self.optics.transfer.has_rows() {
                let (by_depth, by_light) = self.misplaced_rows(s, magnitude);
                depth_error += by_depth;
                light_error += by_light;
            } else if !s.shading.gradient_opacity.is_empty() {
                let Component { alpha, clear, .. } = self.component;
                let r = alpha.slope.abs() * spread;
                let kappa = self.extinction_of(alpha.middle + r, clear - r);
                let more = product(off, Bound::new(kappa) * (2.0 * steepest_modulation(s.shading) * length));
                depth_error += more;
                light_error += product(more, 3.0 * self.optics.brightest_surface().max(magnitude));
            }
            let transfer = &self.optics.transfer;
            if !(transfer.has_emission() || transfer.has_rows() && s.shading.is_flat()) {
                let smallest = (s.square.coefficients()[0] - s.square.spread(1.0)).max(0.0).sqrt();
                // 0/0 is a field without gradient and without error.
                let turn = if off == Bound::ZERO { Bound::ZERO } else { off * 4.0 / smallest };
                light_error += product(self.optics.turned(turn), opacity);
                light_error += ROUNDING * s.shading.power * magnitude;
            }
        }
        (depth_error, light_error)
    }

    /// Errors of depth and light by that of the gradient's magnitude, which chooses the rows.
    fn misplaced_rows(&self, shade: &Shade<'_>, magnitude: f64) -> (Bound, Bound) {
        let rows = self.optics.transfer.rows();
        let length = 2.0 * self.half;
        let steepest = largest(rows.windows(2).map(|w| 1.0 / (w[1].gradient - w[0].gradient)));
        // The error of three components, and the rounding of the magnitude.
        let square = shade.square.coefficients()[0].abs() + shade.square.spread(1.0);
        let off = self.model.slope_error() * 2.0 + 8.0 * f64::EPSILON * square.sqrt();
        // The shares of two rows are off, by as much; whichever rows these are, the upper bound holds.
        let shares = product(off, 2.0 * steepest * length);
        let [low, high] = self.model.range();
        let bounds = self.optics.touching(low, high);
        let ends = bounds.iter().flat_map(|s| [low, high].map(|v| s.at(v.clamp(s.from, s.to))));
        let (opacity, emission) = ends.fold((0.0f64, 0.0f64), |(opacity, emission), o| {
            (opacity.max(o.opacity), emission.max(largest(o.emission)))
        });
        let depth = product(shares, self.optics.transfer.extinction(opacity));
        let light = product(depth, 3.0 * self.optics.brightest_surface().max(magnitude)) + product(shares, emission);
        (depth, light)
    }

    /// Factor and summand of the shading at the nodes; `None` where nothing is shaded.
    fn reflected(&self, rule: &Rule) -> Option<Vec<([f64; 3], [f64; 3])>> {
        if self.optics.transfer.has_emission() || !self.is_shaded() {
            return None;
        }
        let (_, ray) = self.optics.shading.as_ref()?;
        let g = self.model.gradient.as_ref()?;
        Some(rule.nodes.iter().map(|&t| ray.reflect(g.map(|p| p.at(t)))).collect())
    }

    /// κ of an opacity α and of 1 − α, whichever has the digits.
    fn extinction_of(&self, alpha: f64, clear: f64) -> f64 {
        extinction_of(self.optics.transfer.rule(), self.optics.transfer.unit_distance(), alpha, clear)
    }

    /// Shares of the components at a node: factors on their extinction.
    fn shares_at(&self, t: f64) -> [f64; 2] {
        let magnitude = |s: &Shade<'_>| s.square.at(t).max(0.0).sqrt();
        match (&self.shade, &self.other) {
            (Some(s), Some(_)) => {
                let mid = s.square.at(0.0).max(0.0).sqrt();
                let change = if s.square.is_constant() { 0.0 } else { magnitude(s) - mid };
                self.components_share(change)
            }
            (None, Some(_)) => self.components_share(0.0),
            (Some(s), None) if !s.shading.gradient_opacity.is_empty() => [s.shading.modulation(magnitude(s)), 0.0],
            _ => [1.0, 0.0],
        }
    }

    /// Shares of two components where the magnitude has changed by so much since the middle.
    fn components_share(&self, change: f64) -> [f64; 2] {
        let upper = self.other.as_ref().map_or(0.0, |c| (c.share.middle + c.share.slope * change).clamp(0.0, 1.0));
        [1.0 - upper, upper]
    }

    /// κ of the components at a value, times their shares.
    fn extinctions_at(&self, shares: [f64; 2], f: f64) -> [f64; 2] {
        let f0 = self.model.field.coefficients()[0];
        let of = |component: &Component, share: f64| {
            let change = component.alpha.slope * (f - f0);
            share * self.extinction_of(component.alpha.middle + change, component.clear - change)
        };
        [of(&self.component, shares[0]), self.other.as_ref().map_or(0.0, |other| of(other, shares[1]))]
    }

    /// Bound on the error of a component's opacity by rounding and the field's error.
    fn noise(&self, component: &Component) -> Bound {
        product(self.model.error(), component.alpha.slope.abs()) + 8.0 * f64::EPSILON * component.clear
    }

    /// True if 1 − α is no larger than its own error, under the power rule.
    pub fn is_lost(&self) -> bool {
        let lost =
            |c: &Component| Bound::new(self.clearest(c, &self.model.field)).within((self.noise(c) * 4.0).value());
        !self.model.error().is_finite() || self.optics.has_walls() && self.components().any(lost)
    }

    /// True if 1 − α is much smaller somewhere than elsewhere, so that an error of the value weighs unequally, under the power rule.
    pub fn is_graded(&self) -> bool {
        let graded = |c: &Component| c.alpha.slope.abs() * self.model.field.spread(1.0) > 0.5 * c.clear;
        self.optics.has_walls() && self.components().any(graded)
    }

    /// The largest |1 − α| of a field by a component's line, which may go on beyond 1, at a few points.
    fn clearest(&self, component: &Component, field: &Poly) -> f64 {
        let middle = self.model.field.coefficients()[0];
        let clear = |t: f64| (component.clear - component.alpha.slope * (field.at(t) - middle)).abs();
        [-1.0, -0.5, 0.0, 0.5, 1.0].map(clear).into_iter().fold(0.0, f64::max)
    }

    /// A crude enclosure, for stretches so short that nothing more is worth while: around an opacity that touches 1, or a
    /// gradient that vanishes.
    ///
    /// There w = 1 − α is a polynomial of degree d; with this stretch's line it goes on to a longer one of half length H (`whole`)
    /// around this one of half length h, and the maximum of |w| is at least W there. Each of its roots, wherever it lies, adds at most
    /// 2h (1 + ln(2H/h)) to ∫ −ln|w/W| ds.
    pub fn enclosed(&self, whole: Whole<'_>) -> Gain {
        let field = &self.model.field;
        let length = 2.0 * self.half;
        let unit = self.optics.transfer.unit_distance();
        let own = &self.component;
        let deepest = match self.optics.transfer.rule() {
            // No mixture of rows is deeper than the deepest of them, which is no wall.
            _ if self.optics.transfer.has_rows() => {
                let bounds = self.optics.transfer.segments().iter().flat_map(|s| [s.start, s.end]);
                length * self.optics.transfer.extinction(bounds.map(|o| o.opacity).fold(0.0, f64::max))
            }
            OpacityRule::Extinction => length * own.alpha.bound(field.spread(1.0)).min(1.0) / unit,
            OpacityRule::Power => {
                let w = self.clearest(own, whole.field) - self.noise(own).value();
                let roots = if own.alpha.slope == 0.0 { 0.0 } else { whole.field.degree() as f64 };
                let each = 1.0 + libm::log(2.0 * whole.half / self.half);
                if w > 0.0 { length / unit * (roots * each - libm::log(w)) } else { f64::INFINITY }
            }
        };
        let factor = self.shade.as_ref().map_or(1.0, |s| s.shading.largest_modulation());
        // 0·∞: nothing absorbs where the factor is 0.
        let deepest = if factor == 0.0 { 0.0 } else { Bound::new(deepest.max(0.0) * factor).value() };
        let depth = if deepest.is_finite() { 0.5 * deepest } else { 1.0 };
        let depth_error = if deepest.is_finite() { Bound::new(depth) } else { Bound::UNKNOWN };
        let (light, light_error) = if self.optics.transfer.has_emission() {
            let bound = |c: usize| largest(self.components().map(|part| part.emission[c].bound(field.spread(1.0))));
            let e: [f64; 3] = std::array::from_fn(|c| bound(c) * length);
            (e.map(|e| 0.5 * e), largest(e))
        } else {
            let opacity = -libm::expm1(-depth);
            (own.color.map(|l| l.middle * opacity), self.optics.brightest_surface() * -libm::expm1(-deepest))
        };
        Gain { depth, depth_error, light, light_error: Bound::new(light_error) }
    }
}

/// True if a number is surely below a limit: neither is NaN.
fn is_below(x: f64, limit: f64) -> bool {
    x < limit
}

/// A product that is 0 where a factor is: an error that there is none of, or that does not matter.
fn product(error: Bound, factor: impl Into<Bound>) -> Bound {
    let factor = factor.into();
    if error == Bound::ZERO || factor == Bound::ZERO { Bound::ZERO } else { error * factor }
}

/// The stretch that a short one was cut from: the field is one polynomial on it.
#[derive(Clone, Copy, Debug)]
pub struct Whole<'a> {
    /// Half its length.
    pub half: f64,
    /// The field on it.
    pub field: &'a Poly,
}

/// Bounds of a component's κ on an ellipse.
struct Ellipse {
    variation: f64,
    low: f64,
    high: f64,
    turn: f64,
}

/// Bounds on an ellipse.
struct Size {
    /// |κ − κ₀|
    extinction: f64,
    /// The light's integrand by t.
    integrand: f64,
    /// Error in light per error in depth.
    light_per_depth: f64,
}

impl Shade<'_> {
    /// Bounds of the colour's factor and the light added, where |g·g| is at least `min`.
    fn reflect_bound(&self, a: f64, min: f64) -> Option<(f64, f64)> {
        let s = self.shading;
        let (mut factor, mut added) = (s.ambient, 0.0);
        for (bright, [gl, gh]) in &self.towards {
            let size = |p: &Poly| (p.coefficients()[0].abs() + p.spread(a)) / min.sqrt();
            factor += bright * s.diffuse * size(gl);
            if s.specular > 0.0 {
                // A power that is no integer has a branch point where g·h = 0.
                let vanishes = gh.spread(a) >= gh.coefficients()[0].abs();
                if vanishes && s.power.fract() != 0.0 {
                    return None;
                }
                added += bright * s.specular * libm::pow(size(gh), s.power);
            }
        }
        (factor.is_finite() && added.is_finite()).then_some((factor, added))
    }
}

/// Slope of the factor on κ by the gradient's magnitude.
fn modulation_slope(shading: &Shading, magnitude: f64) -> f64 {
    let points = &shading.gradient_opacity;
    let i = points.partition_point(|p| p.0 <= magnitude);
    match (i.checked_sub(1), points.get(i)) {
        (Some(j), Some(&(m1, f1))) => (f1 - points[j].1) / (m1 - points[j].0),
        _ => 0.0,
    }
}

/// Largest slope of the factor on κ by the gradient's magnitude.
fn steepest_modulation(shading: &Shading) -> f64 {
    largest(shading.gradient_opacity.windows(2).map(|w| (w[1].1 - w[0].1) / (w[1].0 - w[0].0)))
}
