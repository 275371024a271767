//! Clock: the system's; in a browser, which gives a module none, the one that its page sets by `set_clock`.

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub use std::time::Instant;

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use page::{Instant, set_clock};

/// Clock of a page; compiled for the tests, too.
#[cfg(any(test, all(target_family = "wasm", target_os = "unknown")))]
mod page {
    use std::ops::{Add, Sub};
    use std::sync::OnceLock;
    use std::time::Duration;

    static CLOCK: OnceLock<fn() -> f64> = OnceLock::new();

    /// Sets the function that gives the milliseconds since some moment, for all of the module and once. Returns false where one is set already,
    /// which then stays. Until one is set, no time passes.
    pub fn set_clock(milliseconds: fn() -> f64) -> bool {
        CLOCK.set(milliseconds).is_ok()
    }

    /// Moment of the page's clock, with as much of `std::time::Instant` as is used here.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub struct Instant(Duration);

    impl Instant {
        /// The moment that it is.
        pub fn now() -> Self {
            let milliseconds = CLOCK.get().map_or(0.0, |clock| clock());
            Self(Duration::try_from_secs_f64(1e-3 * milliseconds).unwrap_or_default())
        }

        /// Time since this moment.
        pub fn elapsed(&self) -> Duration {
            Self::now().saturating_duration_since(*self)
        }

        /// Time since another moment; zero if that is later.
        pub fn duration_since(&self, earlier: Self) -> Duration {
            self.saturating_duration_since(earlier)
        }

        /// Time since another moment; zero if that is later.
        pub fn saturating_duration_since(&self, earlier: Self) -> Duration {
            self.0.saturating_sub(earlier.0)
        }
    }

    impl Add<Duration> for Instant {
        type Output = Self;

        fn add(self, time: Duration) -> Self {
            Self(self.0 + time)
        }
    }

    impl Sub for Instant {
        type Output = Duration;

        fn sub(self, earlier: Self) -> Duration {
            self.saturating_duration_since(earlier)
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use std::sync::atomic::{AtomicU32, Ordering};

        #[test]
        fn time_is_the_page_s_and_never_runs_backwards() {
            static NOW: AtomicU32 = AtomicU32::new(0);
            let before = Instant::now();
            assert_eq!(before.elapsed(), Duration::ZERO);
            assert!(set_clock(|| f64::from(NOW.load(Ordering::Relaxed)) - 1.0) && !set_clock(|| 0.0));
            // A clock below zero, which no page has, is none.
            assert_eq!(Instant::now(), before);
            NOW.store(1501, Ordering::Relaxed);
            assert_eq!(before.elapsed(), Duration::from_millis(1500));
            let later = Instant::now() + Duration::from_millis(2);
            assert_eq!(later - before, Duration::from_millis(1502));
            assert_eq!(before.duration_since(later), Duration::ZERO);
            assert!(later > before);
        }
    }
}
