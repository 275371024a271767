//! Rate of messages that a client may send.

use std::time::Instant;

/// Messages a second that a client may send for long: a mouse that tells a thousand places a second, through a page that sends one a frame, sends
/// 240 at most.
const PER_SECOND: f64 = 400.0;
/// Messages that may come at once.
const BURST: f64 = 800.0;

/// Bucket of messages that fills steadily (a token bucket).
pub struct Rate {
    left: f64,
    since: Instant,
}

impl Rate {
    /// A full bucket.
    pub fn new(now: Instant) -> Self {
        Self { left: BURST, since: now }
    }

    /// True if one more message is within the rate.
    pub fn allows(&mut self, now: Instant) -> bool {
        let refill = now.saturating_duration_since(self.since).as_secs_f64() * PER_SECOND;
        self.left = (self.left + refill).min(BURST) - 1.0;
        self.since = now;
        self.left >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_hand_is_within_the_rate_and_a_flood_is_not() {
        let start = Instant::now();
        let mut rate = Rate::new(start);
        assert!((0..240 * 60).all(|i| rate.allows(start + Duration::from_secs_f64(f64::from(i) / 240.0))));
        let mut rate = Rate::new(start);
        assert_eq!((0..1000).take_while(|_| rate.allows(start)).count(), 800);
    }
}
