//! Stub: the lead's file wins.
use vr_core::*;
#[derive(Clone, Debug)]
pub struct Reference {
    pub tolerance: f64,
}
impl Default for Reference {
    fn default() -> Self {
        Self { tolerance: 1e-10 }
    }
}
#[derive(Clone, Copy, Debug)]
pub enum Certainty {
    Bound(f64),
    Estimate(f64),
}
impl Certainty {
    pub fn value(self) -> f64 {
        match self {
            Self::Bound(x) | Self::Estimate(x) => x,
        }
    }
}
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    pub rgba: [f64; 4],
    pub depth: f64,
    pub certainty: Certainty,
}
pub struct Solution {
    pub pixels: Vec<Pixel>,
    pub counts: Counts,
}
struct At([f64; 3]);
impl SamplerVisitor for At {
    type Output = f64;
    fn visit<T: Voxel, F: filter::Reconstruction>(self, s: Sampler<'_, T, F>) -> f64 {
        s.value(self.0)
    }
}
impl Reference {
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance }
    }
    pub fn solve(&self, scene: &Scene, view: &View, _: &Model, _: &Control) -> Result<Solution, RenderError> {
        if scene.shading.is_some() || !scene.compositing.integrates_light() {
            return Err(RenderError::Unsupported { renderer: "physics", feature: "stub".into() });
        }
        let rays = Rays::new(view)?;
        let u = scene.volume.uniform().unwrap();
        let [w, h] = view.size;
        let mut pixels = vec![];
        for i in 0..w * h {
            let ray = rays.at(f64::from(i % w) + 0.5, f64::from(i / w) + 0.5);
            let mut rgba = [0.0; 4];
            if let Some(r) = IndexRay::new(&ray, u.placement(), u.dims(), &view.clip, f64::INFINITY) {
                let n = (r.length() / u.placement().spacing().min_element() * 64.0).ceil();
                let ds = r.length() / n;
                let mut t = 1.0;
                for k in 0..n as u32 {
                    let p = r.at(r.start + (f64::from(k) + 0.5) * ds);
                    let v = u.with_sampler(scene.filter, At(p.to_array()));
                    if v.is_nan() {
                        continue;
                    }
                    let v = u.calibration().value(v);
                    let o = scene.transfer.at(v);
                    let tau = scene.transfer.extinction(o.opacity) * ds;
                    let a = optics::opacity_of_depth(tau);
                    for c in 0..3 {
                        rgba[c] += t * if scene.transfer.has_emission() {
                            o.emission[c] * ds * optics::source_weight(tau)
                        } else {
                            a * o.color[c]
                        };
                    }
                    t *= 1.0 - a;
                }
                rgba[3] = 1.0 - t;
            }
            pixels.push(Pixel { rgba, depth: f64::INFINITY, certainty: Certainty::Estimate(1e-4) });
        }
        Ok(Solution { pixels, counts: Counts::default() })
    }
}
