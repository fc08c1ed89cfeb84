//! How long pictures take.

use std::time::{Duration, Instant};

/// The times of pictures.
#[derive(Default)]
pub(super) struct Clock {
    /// How long each took to be drawn.
    drawn: Vec<Duration>,
    /// When each was shown.
    shown: Vec<Instant>,
}

/// So many pictures are kept, at the most.
const KEPT: usize = 100_000;

impl Clock {
    /// A picture is shown that took so long to be drawn.
    pub(super) fn add(&mut self, drawn: Duration) {
        if self.drawn.len() == KEPT {
            self.drawn.clear();
            self.shown.clear();
        }
        self.drawn.push(drawn);
        self.shown.push(Instant::now());
    }

    /// The time of the last pictures, in words.
    pub(super) fn describe(&self) -> String {
        let last = self.drawn.len().saturating_sub(15);
        let [median, _] = quantiles(&self.drawn[last..]);
        format!("{:.1} ms a picture", 1e3 * median)
    }

    /// All times, in words.
    pub(super) fn summary(&self, (width, height): (u32, u32)) -> String {
        let [median, most] = quantiles(&self.drawn);
        // The first one is before the window is there.
        let shown = self.shown.first().zip(self.shown.last());
        let seconds = shown.map_or(0.0, |(first, last)| (*last - *first).as_secs_f64());
        let count = self.shown.len().saturating_sub(1);
        let rate = if seconds > 0.0 { count as f64 / seconds } else { 0.0 };
        format!(
            "{} pictures of {width} x {height} pixels: {rate:.0} a second; to draw one takes {:.1} ms \
             (median), and 19 of 20 take up to {:.1} ms",
            self.drawn.len(),
            1e3 * median,
            1e3 * most
        )
    }
}

/// The median, and what 19 of 20 are not above, in seconds.
fn quantiles(times: &[Duration]) -> [f64; 2] {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let at = |part: f64| {
        let place = (part * sorted.len() as f64) as usize;
        sorted.get(place.min(sorted.len().saturating_sub(1))).map_or(0.0, Duration::as_secs_f64)
    };
    [at(0.5), at(0.95)]
}
