//! Operators along a ray: light that is integrated, or a value that is picked.

use std::ops::ControlFlow;

use vr_core::image_order::PixelValue;
use vr_core::{Compositing, Frame, Layer, RayShading, TransferFunction, View};

use crate::camera_space::gradient;
use crate::medium::{Crossing, Light, Medium, reflected};
use crate::walk::Part;

/// Pixel of a ray, and the distance to what it shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) rgba: [f64; 4],
    pub(crate) depth: f64,
}

impl Seen {
    pub(crate) const NOTHING: Self = Self { rgba: [0.0; 4], depth: f64::INFINITY };

    /// The same in front of the opaque surfaces of its pixel.
    pub(crate) fn before(self, layer: Option<&Layer>, pixel: usize) -> Self {
        layer.map_or(self, |layer| Self {
            rgba: layer.under(pixel, self.rgba),
            depth: self.depth.min(layer.depth(pixel)),
        })
    }

    /// The picture of all pixels.
    pub(crate) fn frame(pixels: &[Self], view: &View) -> Frame {
        let colors = pixels.iter().map(|seen| seen.rgba.map(|x| x as f32)).collect();
        let depths = pixels.iter().map(|seen| seen.depth as f32).collect();
        Frame::new(view.size, colors, Some(depths))
    }
}

impl PixelValue for Seen {
    fn mean(values: &[Self]) -> Self {
        let share = 1.0 / values.len() as f64;
        let sum = |c: usize| values.iter().map(|v| v.rgba[c]).sum::<f64>() * share;
        let depth = values.iter().map(|v| v.depth).fold(f64::INFINITY, f64::min);
        Self { rgba: std::array::from_fn(sum), depth }
    }
}

/// True if an operator integrates light to the end of each ray.
pub(crate) fn is_whole_light(compositing: Compositing) -> bool {
    match compositing {
        Compositing::Over => true,
        Compositing::Accumulate { level } => level >= 1.0,
        _ => false,
    }
}

/// State of an operator along a ray.
pub(crate) struct Gathered<'a> {
    medium: &'a Medium<'a>,
    shade: Option<&'a RayShading<f64>>,
    /// Transparency at which a ray may end.
    opaque: f64,
    state: State,
}

enum State {
    Light {
        light: Light,
        crossing: Crossing,
    },
    First {
        threshold: f64,
        seen: Option<Seen>,
    },
    Mean {
        sum: f64,
        length: f64,
    },
    /// The value picked so far and its distance; `sign` is −1 for the smallest.
    Extreme {
        sign: f64,
        best: Option<(f64, f64)>,
    },
}

impl<'a> Gathered<'a> {
    pub(crate) fn new(
        compositing: Compositing,
        medium: &'a Medium<'a>,
        shade: Option<&'a RayShading<f64>>,
        termination: f64,
    ) -> Self {
        let light =
            |level: f64, ends: bool| State::Light { light: Light::NONE, crossing: Crossing { level, at: None, ends } };
        let state = match compositing {
            Compositing::Over => light(0.5, false),
            Compositing::Accumulate { .. } if is_whole_light(compositing) => light(0.5, false),
            Compositing::Accumulate { level } => light(1.0 - level, true),
            Compositing::First { threshold } => State::First { threshold, seen: None },
            Compositing::Average => State::Mean { sum: 0.0, length: 0.0 },
            Compositing::Maximum => State::Extreme { sign: 1.0, best: None },
            Compositing::Minimum => State::Extreme { sign: -1.0, best: None },
        };
        Self { medium, shade, opaque: 1.0 - termination, state }
    }

    /// Takes the next part of the ray; breaks if nothing behind it counts.
    #[inline]
    pub(crate) fn take<const N: usize>(&mut self, part: &Part<N>) -> ControlFlow<()> {
        let values = part.at.map(|a| a[0]);
        match &mut self.state {
            State::Light { light, crossing } => {
                let [a, b] = part.at.each_ref().map(gradient);
                let gradients = a.zip(b).map(|(a, b)| [a, b]);
                self.medium.add(light, part.ends, values, gradients, self.shade, crossing);
                if light.clear <= self.opaque || (crossing.ends && crossing.at.is_some()) {
                    return ControlFlow::Break(());
                }
            }
            State::First { threshold, seen } => {
                let [a, b] = values;
                if a.max(b) >= *threshold {
                    let t = if a >= *threshold { 0.0 } else { (*threshold - a) / (b - a) };
                    let at = part.mixed(t);
                    let value = if a >= *threshold { a } else { *threshold };
                    let color = self.medium.transfer.at(value).color;
                    let (tint, added) = reflected(self.shade, gradient(&at));
                    let [r, g, b]: [f64; 3] = std::array::from_fn(|c| color[c] * tint[c] + added[c]);
                    let depth = part.ends[0] + (part.ends[1] - part.ends[0]) * t;
                    *seen = Some(Seen { rgba: [r, g, b, 1.0], depth });
                    return ControlFlow::Break(());
                }
            }
            State::Mean { sum, length } => {
                let here = part.ends[1] - part.ends[0];
                *sum += 0.5 * (values[0] + values[1]) * here;
                *length += here;
            }
            State::Extreme { sign, best } => {
                for (value, depth) in values.into_iter().zip(part.ends) {
                    if best.is_none_or(|(found, _)| *sign * value > *sign * found) {
                        *best = Some((value, depth));
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// The pixel.
    pub(crate) fn seen(self) -> Seen {
        let picked = |transfer: &TransferFunction, value: f64| transfer.at(value).pixel();
        let transfer = self.medium.transfer;
        match self.state {
            State::Light { light, crossing } => {
                let [r, g, b] = light.rgb;
                Seen { rgba: [r, g, b, 1.0 - light.clear], depth: crossing.at.unwrap_or(f64::INFINITY) }
            }
            State::First { seen, .. } => seen.unwrap_or(Seen::NOTHING),
            State::Mean { length: 0.0, .. } => Seen::NOTHING,
            State::Mean { sum, length } => Seen { rgba: picked(transfer, sum / length), depth: f64::INFINITY },
            State::Extreme { best, .. } => {
                best.map_or(Seen::NOTHING, |(value, depth)| Seen { rgba: picked(transfer, value), depth })
            }
        }
    }
}
