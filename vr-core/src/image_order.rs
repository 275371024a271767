//! Loops over the rays of a view, tile by tile on all threads: for the ray caster and the reference.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::cancel::CancelToken;
use crate::control::Control;
use crate::error::RenderError;
use crate::parallel::{locked, try_each};
use crate::ray::{Ray, Rays};
use crate::stats::Counts;
use crate::view::View;

/// Result of a ray. A pixel is the mean over its rays.
pub trait PixelValue: Copy + Send {
    /// The mean of at least one value.
    fn mean(values: &[Self]) -> Self;
}

/// Pixels along the edge of a tile: small enough to balance, large enough that a tile's rays share the cache.
const TILE: u32 = 16;

/// Point of the image that a ray goes through.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::image_order::{PixelValue, trace_view};
/// use vr_core::{Camera, Control, View};
///
/// #[derive(Clone, Copy)]
/// struct Shade(f64);
/// impl PixelValue for Shade {
///     fn mean(values: &[Self]) -> Self {
///         Self(values.iter().map(|v| v.0).sum::<f64>() / values.len() as f64)
///     }
/// }
///
/// let view = View::new(Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 0.0, 0.0, None), [3, 2]);
/// let (pixels, counts) = trace_view(&view, &Control::default(), || (), |_, _ray, sample, counts| {
///     counts.rays += 1;
///     Shade(sample.x)
/// })?;
/// assert_eq!((pixels[5].0, counts.rays), (2.5, 6));
/// # Ok::<(), vr_core::RenderError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSample {
    /// Its pixel, counted row by row from the top.
    pub pixel: usize,
    /// Distance from the left edge in pixels.
    pub x: f64,
    /// Distance from the top edge in pixels.
    pub y: f64,
}

/// Calls `trace` for every ray of a view; returns one value per pixel, row by row. `scratch` makes the buffers of one tile.
///
/// The result does not depend on the number of threads: tiles are fixed, and so is the order within each.
///
/// # Errors
/// Same as for [`View::validate`]; also [`RenderError::Cancelled`].
pub fn trace_view<P: PixelValue, S>(
    view: &View,
    control: &Control,
    scratch: impl Fn() -> S + Sync,
    trace: impl Fn(&mut S, &Ray, ImageSample, &mut Counts) -> P + Sync,
) -> Result<(Vec<P>, Counts), RenderError> {
    let [w, h] = view.size;
    let across = w.div_ceil(TILE);
    let tiles = across * h.div_ceil(TILE);
    let in_tile = |t: u32| {
        let (x0, y0) = (t % across * TILE, t / across * TILE);
        (y0..(y0 + TILE).min(h)).flat_map(move |y| (x0..(x0 + TILE).min(w)).map(move |x| (x, y)))
    };
    let (tiles, counts) = trace_groups(view, control, tiles, in_tile, scratch, trace)?;
    let mut image: Vec<Option<P>> = vec![None; w as usize * h as usize];
    for (t, values) in tiles.into_iter().enumerate() {
        for ((x, y), p) in in_tile(t as u32).zip(values) {
            image[(y * w + x) as usize] = Some(p);
        }
    }
    Ok((image.into_iter().map(|p| p.expect("tiles cover the image")).collect(), counts))
}

/// Calls `trace` for the rays of some pixels only; returns one value for each, in their order.
///
/// # Errors
/// Same as for [`trace_view`].
pub fn trace_pixels<P: PixelValue, S>(
    view: &View,
    pixels: &[[u32; 2]],
    control: &Control,
    scratch: impl Fn() -> S + Sync,
    trace: impl Fn(&mut S, &Ray, ImageSample, &mut Counts) -> P + Sync,
) -> Result<(Vec<P>, Counts), RenderError> {
    const GROUP: usize = 64;
    let groups = pixels.len().div_ceil(GROUP) as u32;
    let in_group = |g: u32| {
        let start = g as usize * GROUP;
        pixels[start..(start + GROUP).min(pixels.len())].iter().map(|p| (p[0], p[1]))
    };
    let (groups, counts) = trace_groups(view, control, groups, in_group, scratch, trace)?;
    Ok((groups.into_iter().flatten().collect(), counts))
}

fn trace_groups<P: PixelValue, S, I: Iterator<Item = (u32, u32)>>(
    view: &View,
    control: &Control,
    groups: u32,
    pixels_of: impl Fn(u32) -> I + Sync,
    scratch: impl Fn() -> S + Sync,
    trace: impl Fn(&mut S, &Ray, ImageSample, &mut Counts) -> P + Sync,
) -> Result<(Vec<Vec<P>>, Counts), RenderError> {
    let rays = Rays::new(view)?;
    let n = view.supersampling;
    let centre = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
    let one = |g: u32| {
        let mut scratch = scratch();
        let mut counts = Counts::default();
        let mut sub = Vec::with_capacity((n * n) as usize);
        let values = pixels_of(g)
            .map(|(px, py)| {
                sub.clear();
                let pixel = (py * view.size[0] + px) as usize;
                for k in 0..n * n {
                    let spot =
                        ImageSample { pixel, x: f64::from(px) + centre(k % n), y: f64::from(py) + centre(k / n) };
                    sub.push(trace(&mut scratch, &rays.at(spot.x, spot.y), spot, &mut counts));
                }
                if n == 1 { sub[0] } else { P::mean(&sub) }
            })
            .collect::<Vec<P>>();
        (values, counts)
    };
    let mut counts = Counts::default();
    let values = in_parallel(control, groups, one)?.into_iter().map(|(values, c)| {
        counts += c;
        values
    });
    Ok((values.collect(), counts))
}

/// Does pieces of work `0 .. count`, one a task, on the control's threads; returns their results in order.
///
/// Pieces are taken in order, so that neighbours run at the same time, and idle threads steal. Progress is reported after each. A long piece may
/// ask for the cancel flag by [`cancel::poll`](crate::cancel::poll).
///
/// # Errors
/// [`RenderError::Cancelled`]; [`RenderError::Memory`] where a piece derives something for which there is too little.
pub fn in_parallel<T: Send>(
    control: &Control,
    count: u32,
    piece: impl Fn(u32) -> T + Sync,
) -> Result<Vec<T>, RenderError> {
    let done = AtomicUsize::new(0);
    let made: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    let one = |i: usize| {
        control.check()?;
        *locked(&made[i]) = Some(piece(i as u32));
        let finished = done.fetch_add(1, Ordering::Relaxed) + 1;
        control.report(finished as f64 / f64::from(count));
        Ok(())
    };
    let all = || try_each(count as usize, &one);
    // Rays poll the current flag: that of the caller's work, or else the control's.
    if CancelToken::current().is_set() { control.run(all) } else { control.cancellable(all)? }?;
    let value = |slot: Mutex<Option<T>>| slot.into_inner().ok().flatten().expect("every piece was made");
    Ok(made.into_iter().map(value).collect())
}
