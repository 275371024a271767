//! Numbers of some 31 digits: pairs of f64 (Dekker 1971), by splitting and not by fused multiply-add.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The sum of two f64.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dd(pub f64, pub f64);

fn two_sum(a: f64, b: f64) -> Dd {
    let s = a + b;
    let t = s - a;
    Dd(s, (a - (s - t)) + (b - t))
}

fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

fn two_product(a: f64, b: f64) -> Dd {
    let p = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Dd(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

pub fn dd(x: f64) -> Dd {
    Dd(x, 0.0)
}

impl Dd {
    pub fn f(self) -> f64 {
        self.0 + self.1
    }

    pub fn below(self, other: Self) -> bool {
        self.0 < other.0 || self.0 == other.0 && self.1 < other.1
    }

    pub fn floor(self) -> f64 {
        let f = self.0.floor();
        if f == self.0 && self.1 < 0.0 { f - 1.0 } else { f }
    }

    pub fn sqrt(self) -> Self {
        let mut y = dd(self.0.sqrt());
        if y.0 > 0.0 {
            for _ in 0..2 {
                y = (y + self / y) * dd(0.5);
            }
        }
        y
    }

    /// eˣ: Taylor's series at x/256, squared eight times.
    pub fn exp(self) -> Self {
        let x = self * dd(1.0 / 256.0);
        let mut sum = dd(1.0);
        for n in (1..=20).rev() {
            sum = dd(1.0) + sum * x / dd(f64::from(n));
        }
        for _ in 0..8 {
            sum = sum * sum;
        }
        sum
    }

    /// tan of an angle in degrees, below 90.
    pub fn tan_degrees(self) -> Self {
        let x = self * Dd(std::f64::consts::PI, 1.2246467991473532e-16) / dd(180.0);
        let (mut sin, mut cos) = (dd(1.0), dd(1.0));
        for n in (1..=16).rev() {
            let (a, b) = (f64::from(2 * n), f64::from(2 * n + 1));
            sin = dd(1.0) - sin * x * x / dd(a * b);
            cos = dd(1.0) - cos * x * x / dd(a * (a - 1.0));
        }
        sin * x / cos
    }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        let s = two_sum(self.0, o.0);
        let t = two_sum(self.1, o.1);
        let s = two_sum(s.0, s.1 + t.0);
        two_sum(s.0, s.1 + t.1)
    }
}

impl Neg for Dd {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let p = two_product(self.0, o.0);
        two_sum(p.0, p.1 + (self.0 * o.1 + self.1 * o.0))
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let a = self.0 / o.0;
        let r = self - o * dd(a);
        let b = r.0 / o.0;
        let r = r - o * dd(b);
        dd(a) + dd(b) + dd(r.0 / o.0)
    }
}

pub type V3 = [Dd; 3];

pub fn v3(v: glam::DVec3) -> V3 {
    v.to_array().map(dd)
}

pub fn dot(a: V3, b: V3) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn plus(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn minus(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn times(a: V3, k: Dd) -> V3 {
    a.map(|x| x * k)
}

pub fn unit(a: V3) -> V3 {
    let n = dot(a, a).sqrt();
    a.map(|x| x / n)
}

#[test]
fn digits() {
    let close = |a: Dd, b: Dd| assert!((a - b).f().abs() < 1e-29 * b.f().abs(), "{a:?} {b:?}");
    close(dd(1.0) / dd(3.0) * dd(3.0), dd(1.0));
    close(dd(2.0).sqrt() * dd(2.0).sqrt(), dd(2.0));
    close(dd(1.0).exp(), Dd(std::f64::consts::E, 1.4456468917292502e-16));
    close(dd(-9.0).exp() * dd(9.0).exp(), dd(1.0));
    close(dd(45.0).tan_degrees(), dd(1.0));
    close(dd(30.0).tan_degrees() * dd(60.0).tan_degrees(), dd(1.0));
    assert_eq!((Dd(3.0, -1e-20).floor(), dd(3.0).floor()), (2.0, 3.0));
}
