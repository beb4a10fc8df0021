//! Windows: the visible part of an edge, and cutting by other windows.

use glam::DVec2;

use super::ROUNDING;

/// What is seen through a part of an edge. Seen from the triangle that it enters: the edge is the x axis from 0 on, the
/// triangle lies above it, and the place that it is seen from below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub from: f64,
    pub to: f64,
    pub origin: DVec2,
    /// Length of the path up to the origin.
    pub before: f64,
}

impl Window {
    /// This window in the coordinates of the twin, whose edge runs the other way.
    pub fn turned(&self, length: f64) -> Self {
        Self {
            from: length - self.to,
            to: length - self.from,
            origin: DVec2::new(length - self.origin.x, -self.origin.y),
            before: self.before,
        }
    }

    /// From the other side of the edge, as far from all of it.
    pub fn mirrored(&self) -> Self {
        Self {
            origin: DVec2::new(self.origin.x, -self.origin.y),
            ..*self
        }
    }

    /// The distance of a place on the edge.
    pub fn distance_on_edge(&self, x: f64) -> f64 {
        self.before + self.origin.distance(DVec2::new(x, 0.0))
    }

    /// Of the nearest point in it.
    pub fn least(&self) -> f64 {
        self.distance_on_edge(self.origin.x.clamp(self.from, self.to))
    }

    /// The distance of a place above the edge, if it is seen.
    pub fn distance_to(&self, place: DVec2, slack: f64) -> Option<f64> {
        let x = crossing(self.origin, place);
        (x >= self.from - slack && x <= self.to + slack)
            .then(|| self.before + self.origin.distance(place))
    }
}

/// The place where the line between a place below the x axis and one above crosses the axis.
pub(super) fn crossing(below: DVec2, above: DVec2) -> f64 {
    let part = -below.y / (above.y - below.y).max(f64::MIN_POSITIVE);
    below.x + part * (above.x - below.x)
}

/// Is every way through the window longer than one by an end of the edge? If the way by the start is shorter to the far end
/// of the window, it crosses all that come through nearer, and is shorter for them, too.
pub(super) fn is_beaten(window: &Window, start: f64, end: f64, length: f64) -> bool {
    let slack = ROUNDING * length;
    start + window.to + slack < window.distance_on_edge(window.to)
        || end + length - window.from + slack < window.distance_on_edge(window.from)
}

/// Cuts from the parts of a window those where another window on the same side is nearer by more than rounding: shortest paths
/// there come through the other window. This is how Mitchell, Mount and Papadimitriou bound the number of windows.
pub(super) fn cut(parts: &mut Vec<(f64, f64)>, window: &Window, other: &Window, length: f64) {
    let slack = ROUNDING * length;
    let gain = |x: f64| other.distance_on_edge(x) - window.distance_on_edge(x) + slack;
    let mut k = 0;
    while k < parts.len() {
        let (from, to) = parts[k];
        let (low, high) = (from.max(other.from), to.min(other.to));
        k += 1;
        if high - low <= slack {
            continue;
        }
        let (beaten_from, beaten_to) = match (gain(low) > 0.0, gain(high) > 0.0) {
            (false, false) if !is_between(window.origin, other.origin, low, high) => (low, high),
            (false, true) => (low, change(low, high, slack, gain)),
            (true, false) => (change(high, low, slack, gain), high),
            // It wins, or there may be a part in the middle: keeping too much is harmless.
            _ => continue,
        };
        // Both overlap slightly where they meet, so that there is no gap between them.
        let rest = [(from, beaten_from + slack), (beaten_to - slack, to)];
        let rest = rest
            .into_iter()
            .filter(|(from, to)| to - from > 2.0 * slack);
        let before = parts.len();
        parts.splice(k - 1..k, rest);
        k = k + parts.len() - before;
    }
}

/// Is a place inside the triangle of another place and a part of the edge? If not, each path from the place to the part crosses a
/// path from the other place to an end of the part. A window that is longer at both ends is then longer at these crossings, too.
fn is_between(place: DVec2, other: DVec2, low: f64, high: f64) -> bool {
    let rise = place.y - other.y;
    let x = other.x - other.y / rise * (place.x - other.x);
    rise > 0.0 && low < x && x < high
}

/// The place between `loses`, where there is no gain, and `wins`, where there is one, at which the gain begins. By false position,
/// where the gain at an end that stays counts half each time (the Illinois method).
fn change(mut loses: f64, mut wins: f64, slack: f64, gain: impl Fn(f64) -> f64) -> f64 {
    let (mut loss, mut win) = (gain(loses), gain(wins));
    for _ in 0..60 {
        let x = loses + loss / (loss - win) * (wins - loses);
        let at_x = gain(x);
        if at_x.abs() < 1e-3 * slack {
            return x;
        }
        if at_x > 0.0 {
            (wins, win) = (x, at_x);
            loss *= 0.5;
        } else {
            (loses, loss) = (x, at_x);
            win *= 0.5;
        }
    }
    loses
}
