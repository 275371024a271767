//! Time that a renderer takes to end when it is cancelled.

use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use vr_core::{Control, RenderError, Renderer, Scene, View};

/// Cancels a picture a while after its rays, or whatever is drawn, begin, from another thread; returns the time from then to its end.
///
/// # Panics
/// Panics if the picture is finished or fails before: it is to be one that takes seconds.
pub fn time_to_cancel(renderer: &dyn Renderer, scene: &Scene, view: &View, after: Duration) -> Duration {
    // A pool of its own: tests that run beside this one hold up none of its work.
    let control = Control::default().with_threads(2);
    let mut prepared = renderer.prepare(scene, &control).expect("a scene that it can draw");
    let flag = control.cancel_flag();
    let cancels = thread::spawn(move || {
        thread::sleep(after);
        flag.store(true, Ordering::Relaxed);
        Instant::now()
    });
    let outcome = prepared.render(view, &control).map(drop);
    let end = Instant::now();
    let since = cancels.join().expect("it sleeps and sets a flag");
    assert!(end > since, "{} was done before it was cancelled: {outcome:?}", renderer.name());
    assert!(matches!(outcome, Err(RenderError::Cancelled)), "{}: {outcome:?}", renderer.name());
    end - since
}
