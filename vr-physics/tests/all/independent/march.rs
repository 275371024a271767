//! The pixel by brute force: the ray is cut where anything changes, and each piece marched in ever more equal slabs, extrapolated.

use vr_core::{Compositing, ControlPoint, Light, OpacityRule, Scene, Shading};

use super::dd::*;
use super::field::Field;

/// A pixel, and how far it may be off.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    pub rgba: [f64; 4],
    pub error: f64,
}

/// Linear between two control points, constant outside.
#[derive(Clone, Copy)]
struct Line {
    from: f64,
    to: f64,
    a: ControlPoint,
    b: ControlPoint,
}

/// A medium at a point.
#[derive(Clone, Copy)]
struct Medium {
    kappa: f64,
    /// κ's factor.
    factor: f64,
    color: [f64; 3],
    emission: [f64; 3],
}

pub struct March<'a> {
    field: &'a Field,
    points: &'a [ControlPoint],
    /// Rows by the gradient's magnitude, and the line of each that holds in the piece at hand.
    rows: Vec<(f64, &'a [ControlPoint])>,
    lines: Vec<Line>,
    power: bool,
    unit: f64,
    emits: bool,
    shading: Option<&'a Shading>,
    lights: &'a [Light],
    brightest: f64,
    tau: f64,
    light: [f64; 3],
    error: f64,
    level: f64,
    done: bool,
}

/// Taps of the filter that a pixel may cost: no scene may take for ever.
const MAX_WORK: u64 = 1_500_000;
/// Points that a piece is looked at before it is cut.
const LOOKS: usize = 24;

impl<'a> March<'a> {
    pub fn new(scene: &'a Scene, field: &'a Field) -> Self {
        let transfer = &scene.transfer;
        let light = |p: &ControlPoint| p.color.into_iter().chain(p.emission.unwrap_or_default()).fold(0.0, f64::max);
        let shading = scene.shading.as_deref();
        let lamps: f64 =
            shading.map_or(0.0, |_| scene.lights.iter().map(|l| l.color.into_iter().fold(0.0, f64::max)).sum());
        let gain = shading.map_or(1.0, |s| 1.0 + s.ambient + (s.diffuse + s.specular) * lamps);
        Self {
            field,
            points: transfer.points(),
            rows: transfer.rows().iter().map(|row| (row.gradient, row.transfer.points())).collect(),
            lines: Vec::new(),
            power: transfer.rule() == OpacityRule::Power,
            unit: transfer.unit_distance(),
            emits: transfer.has_emission(),
            shading,
            lights: &scene.lights,
            brightest: gain
                * transfer.rows().iter().fold(transfer.points().iter().map(light).fold(1.0, f64::max), |m, row| {
                    row.transfer.points().iter().map(light).fold(m, f64::max)
                }),
            tau: 0.0,
            light: [0.0; 3],
            error: 0.0,
            level: match scene.compositing {
                Compositing::Accumulate { level } if level < 1.0 => -libm::log1p(-level),
                _ => f64::INFINITY,
            },
            done: false,
        }
    }

    pub fn solve(mut self, compositing: Compositing) -> Answer {
        let cuts = self.field.cuts();
        let pieces: Vec<(Dd, Dd)> = cuts.windows(2).filter(|w| w[0].below(w[1])).map(|w| (w[0], w[1])).collect();
        let full = |p: &&(Dd, Dd)| !self.field.is_vacuum((p.0 + p.1) * dd(0.5));
        let pieces: Vec<(Dd, Dd)> = pieces.iter().filter(full).copied().collect();
        match compositing {
            Compositing::Over | Compositing::Accumulate { .. } => {
                for (a, b) in pieces {
                    if !self.done {
                        self.cell(a, b);
                    }
                }
                let (tau, opacity) = (self.tau, -libm::expm1(-self.tau));
                let opacity = if tau >= self.level { -libm::expm1(-self.level) } else { opacity };
                let [r, g, b] = self.light;
                Answer { rgba: [r, g, b, opacity], error: self.error + 1e-15 * (1.0 + r.max(g).max(b)) }
            }
            Compositing::Maximum | Compositing::Minimum => {
                let sign = if compositing == Compositing::Maximum { 1.0 } else { -1.0 };
                let all = pieces.iter().map(|&(a, b)| self.extreme(a, b, sign));
                let best = all.reduce(|x, y| if ((y - x) * dd(sign)).f() > 0.0 { y } else { x });
                best.map_or(Answer { rgba: [0.0; 4], error: 0.0 }, |v| self.picked(v))
            }
            Compositing::Average => {
                let (mut sum, mut length) = (dd(0.0), dd(0.0));
                for &(a, b) in &pieces {
                    sum = sum + self.integral(a, b, 0);
                    length = length + (b - a);
                }
                let mut mean = sum / length;
                if let Some(&(a, b)) = pieces.first() {
                    // The mean of a constant is the constant, to the last digit.
                    let value = self.field.value((a + b) * dd(0.5), (a + b) * dd(0.5));
                    if (mean - value).f().abs() <= 1e-25 * value.f().abs() {
                        mean = value;
                    }
                }
                if length.f() > 0.0 { self.picked(mean) } else { Answer { rgba: [0.0; 4], error: 0.0 } }
            }
            Compositing::First { threshold } => {
                for &(a, b) in &pieces {
                    let home = (a + b) * dd(0.5);
                    let over = |s: Dd| (self.field.value(s, home) - dd(threshold)).f();
                    let entry = over(a) >= 0.0;
                    let roots = if entry { vec![a] } else { self.roots(a, b, &|s| over(s)) };
                    let Some(&s) = roots.first() else { continue };
                    let value = if entry { self.field.value(a, home) } else { dd(threshold) };
                    let line = self.line(value);
                    let color = std::array::from_fn(|c| Self::mix(&line, value, |p| p.color[c]));
                    let (color, _) = self.shaded(s, home, color);
                    return Answer { rgba: [color[0], color[1], color[2], 1.0], error: 1e-14 * self.brightest };
                }
                Answer { rgba: [0.0; 4], error: 0.0 }
            }
        }
    }

    fn picked(&self, v: Dd) -> Answer {
        let line = self.line(v);
        let alpha = Self::mix(&line, v, |p| p.opacity);
        let c: [f64; 3] = std::array::from_fn(|c| alpha * Self::mix(&line, v, |p| p.color[c]));
        Answer { rgba: [c[0], c[1], c[2], alpha], error: 1e-15 * self.brightest }
    }

    /// The line that holds at a value: at a jump the one behind it.
    fn line(&self, v: Dd) -> Line {
        Self::line_of(self.points, v)
    }

    fn line_of(p: &[ControlPoint], v: Dd) -> Line {
        let next = p.iter().position(|p| v.below(dd(p.value)));
        match next {
            Some(0) => Line { from: f64::NEG_INFINITY, to: p[0].value, a: p[0], b: p[0] },
            None => Line { from: p[p.len() - 1].value, to: f64::INFINITY, a: p[p.len() - 1], b: p[p.len() - 1] },
            Some(i) => Line { from: p[i - 1].value, to: p[i].value, a: p[i - 1], b: p[i] },
        }
    }

    fn mix(line: &Line, v: Dd, of: impl Fn(&ControlPoint) -> f64) -> f64 {
        Self::mix_exactly(line, v, of).f()
    }

    fn mix_exactly(line: &Line, v: Dd, of: impl Fn(&ControlPoint) -> f64) -> Dd {
        let (a, b) = (of(&line.a), of(&line.b));
        if a == b {
            return dd(a);
        }
        dd(a) + (dd(b) - dd(a)) * ((v - dd(line.from)) / (dd(line.to) - dd(line.from)))
    }

    /// The colour that is reflected, and the factor on κ.
    fn shaded(&self, s: Dd, home: Dd, color: [f64; 3]) -> ([f64; 3], f64) {
        let Some(shading) = self.shading else { return (color, 1.0) };
        let g = self.field.gradient(s, home);
        let size = dot(g, g).sqrt().f();
        let factor = if shading.gradient_opacity.is_empty() { 1.0 } else { factor(shading, size) };
        if size == 0.0 {
            return (color, factor);
        }
        let n = g.map(|x| x.f() / size);
        let dot3 = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let mut out = color.map(|c| c * shading.ambient);
        for light in self.lights {
            let (l, h) = self.vectors(light.direction);
            for c in 0..3 {
                out[c] += light.color[c] * shading.diffuse * dot3(n, l).abs() * color[c];
                out[c] += light.color[c] * shading.specular * libm::pow(dot3(n, h).abs(), shading.power);
            }
        }
        (out, factor)
    }

    /// Towards a light, and half way to the eye.
    fn vectors(&self, direction: Option<glam::DVec3>) -> ([f64; 3], [f64; 3]) {
        let eye = self.field.to_eye;
        let l = direction.map_or(eye, |d| d.normalize().to_array());
        let sum: [f64; 3] = std::array::from_fn(|c| l[c] + eye[c]);
        let size = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        (l, if size > 0.0 { sum.map(|x| x / size) } else { [0.0; 3] })
    }

    /// Every place in (a, b) where a function changes its sign, by looking, then bisecting; touches are looked for, too.
    fn roots(&self, a: Dd, b: Dd, of: &dyn Fn(Dd) -> f64) -> Vec<Dd> {
        let seen: Vec<f64> = Self::looks(a, b).map(of).collect();
        Self::roots_of(a, b, &seen, of)
    }

    fn looks(a: Dd, b: Dd) -> impl Iterator<Item = Dd> {
        (0..=LOOKS).map(move |k| a + (b - a) * dd(k as f64 / LOOKS as f64))
    }

    /// The same, of a function that has been looked at.
    fn roots_of(a: Dd, b: Dd, seen: &[f64], of: &dyn Fn(Dd) -> f64) -> Vec<Dd> {
        let at = |k: usize| a + (b - a) * dd(k as f64 / LOOKS as f64);
        let mut roots = Vec::new();
        let bisect = |mut low: Dd, mut high: Dd, sign: f64| {
            for _ in 0..60 {
                let middle = (low + high) * dd(0.5);
                if of(middle) * sign > 0.0 { low = middle } else { high = middle }
            }
            high
        };
        for k in 0..LOOKS {
            let (x, y) = (seen[k], seen[k + 1]);
            if (x > 0.0) != (y > 0.0) || (x < 0.0) != (y < 0.0) {
                roots.push(bisect(at(k), at(k + 1), if x == 0.0 { -y } else { x }));
            }
            // Nearer to 0 than its neighbours, on one side: it may dip to the other between them.
            let bend = if k > 0 { (seen[k - 1] - 2.0 * x + y).abs() } else { 0.0 };
            if k > 0
                && x != 0.0
                && x.abs() <= bend
                && x.abs() <= seen[k - 1].abs()
                && x.abs() <= y.abs()
                && x * y > 0.0
                && x * seen[k - 1] > 0.0
            {
                let sign = x.signum();
                let (mut low, mut high) = (at(k - 1), at(k + 1));
                for _ in 0..60 {
                    let (p, q) = (low + (high - low) * dd(0.382), low + (high - low) * dd(0.618));
                    if of(p) * sign < of(q) * sign { high = q } else { low = p }
                }
                if of(low) * sign <= 0.0 {
                    roots.push(bisect(at(k - 1), low, sign));
                    roots.push(bisect(at(k + 1), low, sign));
                }
            }
        }
        roots.sort_by(|a, b| (*a - *b).f().total_cmp(&0.0));
        roots
    }

    fn extreme(&self, a: Dd, b: Dd, sign: f64) -> Dd {
        let home = (a + b) * dd(0.5);
        let of = |s: Dd| self.field.value(s, home) * dd(sign);
        let at = |k: usize| a + (b - a) * dd(k as f64 / LOOKS as f64);
        let seen: Vec<Dd> = (0..=LOOKS).map(|k| of(at(k))).collect();
        let mut best = seen[0];
        for k in 0..=LOOKS {
            if best.below(seen[k]) {
                best = seen[k];
            }
            let (before, behind) = (k.saturating_sub(1), (k + 1).min(LOOKS));
            // At an end, too: a crest may be hidden beside it.
            if !seen[k].below(seen[before]) && !seen[k].below(seen[behind]) {
                let (mut low, mut high) = (at(before), at(behind));
                for _ in 0..80 {
                    let (p, q) = (low + (high - low) * dd(0.382), low + (high - low) * dd(0.618));
                    if of(q).below(of(p)) { high = q } else { low = p }
                }
                let crest = of(low);
                if best.below(crest) {
                    best = crest;
                }
            }
        }
        best * dd(sign)
    }

    /// ∫ f ds, by Romberg's scheme of midpoints.
    fn integral(&self, a: Dd, b: Dd, depth: u32) -> Dd {
        let home = (a + b) * dd(0.5);
        let mut rows: Vec<Vec<Dd>> = Vec::new();
        for k in 0..6 {
            let n = 4usize << k;
            let h = (b - a) / dd(n as f64);
            let sum = (0..n).fold(dd(0.0), |s, i| s + self.field.value(a + h * dd(i as f64 + 0.5), home)) * h;
            let mut row = vec![sum];
            for j in 0..k {
                let fine = row[j];
                row.push(fine + (fine - rows[k - 1][j]) / dd(f64::from(4u32.pow(j as u32 + 1)) - 1.0));
            }
            if k > 0 && (row[k] - rows[k - 1][k - 1]).f().abs() <= 1e-26 * row[k].f().abs() {
                return row[k];
            }
            rows.push(row);
        }
        if depth < 3 {
            return self.integral(a, home, depth + 1) + self.integral(home, b, depth + 1);
        }
        rows[5][5]
    }

    /// A cell: cut where the value, or the gradient, passes anything at which the medium has a kink or jumps.
    fn cell(&mut self, a: Dd, b: Dd) {
        let home = (a + b) * dd(0.5);
        let mut cuts = vec![a, b];
        let mut knots: Vec<f64> = match &self.rows[..] {
            [] => self.points.iter().map(|p| p.value).collect(),
            rows => rows.iter().flat_map(|row| row.1.iter().map(|p| p.value)).collect(),
        };
        knots.sort_by(f64::total_cmp);
        knots.dedup();
        let values: Vec<Dd> = Self::looks(a, b).map(|s| self.field.value(s, home)).collect();
        for v in knots {
            let seen: Vec<f64> = values.iter().map(|&x| (x - dd(v)).f()).collect();
            cuts.extend(Self::roots_of(a, b, &seen, &|s| (self.field.value(s, home) - dd(v)).f()));
        }
        if let Some(shading) = self.shading {
            let gradients: Vec<V3> = Self::looks(a, b).map(|s| self.field.gradient(s, home)).collect();
            let roots = |of: &dyn Fn(V3) -> f64| {
                let seen: Vec<f64> = gradients.iter().map(|&g| of(g)).collect();
                Self::roots_of(a, b, &seen, &|s| of(self.field.gradient(s, home)))
            };
            for light in self.lights {
                let (l, h) = self.vectors(light.direction);
                for v in [l, h] {
                    cuts.extend(roots(&|g| dot(g, v.map(dd)).f()));
                }
            }
            for (m, _) in &shading.gradient_opacity {
                cuts.extend(roots(&|g| (dot(g, g) - dd(*m) * dd(*m)).f()));
            }
        }
        for (m, _) in &self.rows {
            let of = |s: Dd| {
                let g = self.field.gradient(s, home);
                (dot(g, g) - dd(*m) * dd(*m)).f()
            };
            cuts.extend(self.roots(a, b, &of));
        }
        cuts.sort_by(|a, b| (*a - *b).f().total_cmp(&0.0));
        for w in cuts.windows(2) {
            if !self.done && (w[1] - w[0]).f() > 1e-22 * (b - a).f() {
                let middle = (w[0] + w[1]) * dd(0.5);
                let line = self.line(self.field.value(middle, home));
                self.lines = self.rows.iter().map(|row| Self::line_of(row.1, self.field.value(middle, home))).collect();
                self.piece(w[0], w[1], home, &line, 0);
            }
        }
    }

    fn medium(&self, s: Dd, home: Dd, line: &Line) -> Medium {
        let v = self.field.value(s, home);
        if !self.rows.is_empty() {
            return self.mixed(s, home, v);
        }
        let kappa = self.kappa(line, v);
        let color = std::array::from_fn(|c| Self::mix(line, v, |p| p.color[c]));
        let (color, factor) = self.shaded(s, home, color);
        let emission = std::array::from_fn(|c| Self::mix(line, v, |p| p.emission.map_or(0.0, |e| e[c])));
        Medium { kappa: if factor == 0.0 { 0.0 } else { kappa * factor }, factor, color, emission }
    }

    fn kappa(&self, line: &Line, v: Dd) -> f64 {
        let alpha = Self::mix_exactly(line, v, |p| p.opacity);
        if self.power {
            let clear = (dd(1.0) - alpha).f();
            (if alpha.f() < 0.5 { -libm::log1p(-alpha.f()) } else { -libm::log(clear.max(0.0)) }) / self.unit
        } else {
            alpha.f() / self.unit
        }
    }

    /// The medium between two rows: κ and κ·c, or the emission, of each by its share.
    fn mixed(&self, s: Dd, home: Dd, v: Dd) -> Medium {
        let g = self.field.gradient(s, home);
        let magnitude = dot(g, g).sqrt();
        let last = self.rows.len() - 1;
        let upper = self.rows.iter().position(|row| (dd(row.0) - magnitude).f() > 0.0);
        let shares: Vec<(usize, f64)> = match upper {
            Some(0) => vec![(0, 1.0)],
            None => vec![(last, 1.0)],
            Some(k) => {
                let (low, high) = (dd(self.rows[k - 1].0), dd(self.rows[k].0));
                let w = ((magnitude - low) / (high - low)).f();
                vec![(k - 1, 1.0 - w), (k, w)]
            }
        };
        let mut all = Medium { kappa: 0.0, factor: 1.0, color: [0.0; 3], emission: [0.0; 3] };
        for (row, share) in shares {
            let line = &self.lines[row];
            let kappa = share * self.kappa(line, v);
            all.kappa += kappa;
            for c in 0..3 {
                all.color[c] += kappa * Self::mix(line, v, |p| p.color[c]);
                all.emission[c] += share * Self::mix(line, v, |p| p.emission.map_or(0.0, |e| e[c]));
            }
        }
        if all.kappa > 0.0 {
            all.color = all.color.map(|q| q / all.kappa);
        }
        all.color = self.shaded(s, home, all.color).0;
        all
    }

    /// τ and light of `n` slabs, as if nothing stood in front; light in the first three.
    fn slabs(&self, a: Dd, b: Dd, home: Dd, line: &Line, n: usize) -> [f64; 4] {
        let h = (b - a) / dd(n as f64);
        let (mut tau, mut light) = (dd(0.0), [dd(0.0); 3]);
        for i in 0..n {
            let m = self.medium(a + h * dd(i as f64 + 0.5), home, line);
            let depth = m.kappa * h.f();
            let clear = libm::exp(-tau.f());
            let opacity = -libm::expm1(-depth);
            for c in 0..3 {
                let b = if self.emits {
                    m.emission[c] * h.f() * if depth == 0.0 { 1.0 } else { opacity / depth }
                } else {
                    m.color[c] * opacity
                };
                light[c] = light[c] + dd(clear * b);
            }
            tau = tau + dd(depth);
        }
        [light[0].f(), light[1].f(), light[2].f(), tau.f()]
    }

    /// A piece on which everything is smooth, but perhaps at its ends.
    fn piece(&mut self, a: Dd, b: Dd, home: Dd, line: &Line, depth: u32) {
        if self.field.spent.get() > MAX_WORK {
            self.error = f64::INFINITY;
            self.done = true;
            return;
        }
        let middle = (a + b) * dd(0.5);
        let value = |s: Dd| self.field.value(s, home);
        let here = value(middle);
        let still = (value(a) - here).f() == 0.0
            && (value(b) - here).f() == 0.0
            && (value((a + middle) * dd(0.5)) - here).f() == 0.0;
        let opaque = self.rows.is_empty()
            && (line.a.opacity == 1.0 && line.b.opacity == 1.0 || still && Self::mix(line, here, |p| p.opacity) == 1.0);
        let is_clear = |line: &Line| {
            [line.a, line.b].iter().all(|p| p.opacity == 0.0 && p.emission.unwrap_or_default() == [0.0; 3])
        };
        let clear = if self.rows.is_empty() { is_clear(line) } else { self.lines.iter().all(is_clear) };
        let in_front = libm::exp(-self.tau);
        if clear || in_front * self.brightest * (1.0 + (self.field.ends[1] - a).f()) < 1e-22 {
            return;
        }
        if self.power && opaque && self.medium(middle, home, line).factor > 0.0 {
            // A wall shows the colour where it is entered.
            let v = value(a);
            let color = std::array::from_fn(|c| Self::mix(line, v, |p| p.color[c]));
            let (color, _) = self.shaded(a, home, color);
            let share = in_front - libm::exp(-self.level);
            if !self.emits {
                for c in 0..3 {
                    self.light[c] += share.max(0.0) * color[c];
                }
            }
            self.tau = f64::INFINITY;
            self.done = true;
            return;
        }
        let mut rows: Vec<Vec<[f64; 4]>> = Vec::new();
        let mut found = None;
        let mut off = f64::INFINITY;
        for k in 0..5 {
            let mut row = vec![self.slabs(a, b, home, line, 4 << k)];
            for j in 0..k {
                let four = f64::from(4u32.pow(j as u32 + 1));
                let next = std::array::from_fn(|c| row[j][c] + (row[j][c] - rows[k - 1][j][c]) / (four - 1.0));
                row.push(next);
            }
            if k > 1 {
                let scale = [0, 1, 2].map(|c| row[k][c].abs());
                off = (0..4)
                    .map(|c| {
                        (row[k][c] - rows[k - 1][k - 1][c]).abs() * in_front * if c == 3 { self.brightest } else { 1.0 }
                    })
                    .fold(0.0, |m: f64, x| if x.is_nan() { f64::INFINITY } else { m.max(x) });
                let largest = scale.into_iter().fold(1.0, f64::max) * in_front.max(1e-30);
                if off <= 1e-15 * largest {
                    found = Some(row[k]);
                    break;
                }
            }
            rows.push(row);
            if k == 2 && off > 1e-6 {
                break;
            }
        }
        // A level inside is closed in on, the end of a ray in tiny pieces.
        let passes = found.is_some_and(|f| self.tau + f[3] > self.level);
        if (found.is_none() || passes) && depth < 70 {
            self.piece(a, middle, home, line, depth + 1);
            if !self.done {
                self.piece(middle, b, home, line, depth + 1);
            }
            return;
        }
        let last = found.unwrap_or_else(|| rows[rows.len() - 1][rows.len() - 1]);
        if passes {
            self.error += 1e-13 * self.brightest;
            self.done = true;
            self.tau = f64::INFINITY;
            return;
        }
        self.error +=
            2.0 * if off.is_finite() { off } else { 1.0 } + 4e-16 * in_front * (last[3].min(30.0) * self.brightest);
        for c in 0..3 {
            self.light[c] += in_front * last[c];
        }
        self.tau += last[3];
    }
}

/// The factor on κ at a gradient's magnitude.
fn factor(shading: &Shading, m: f64) -> f64 {
    let p = &shading.gradient_opacity;
    if m <= p[0].0 {
        return p[0].1;
    }
    for w in p.windows(2) {
        if m <= w[1].0 {
            return w[0].1 + (w[1].1 - w[0].1) * (m - w[0].0) / (w[1].0 - w[0].0);
        }
    }
    p[p.len() - 1].1
}
