//! What the picture shows for a while because the pointer rests on a look or on a colour map. The document stays as it is.

use myxo::scene::settings::{ColorMap, Settings};

/// The pointer rests on a look for so long before it is previewed, seconds.
const RESTS: f64 = 0.15;
/// Between two looks the preview of the first one stays for so long, seconds.
const STAYS: f64 = 0.2;

/// The look under the pointer, and whether it is previewed.
#[derive(Clone, Debug, Default)]
pub struct Preview {
    /// The look under the pointer, and since when.
    pointed: Option<(String, f64)>,
    /// The look that is previewed, and when the pointer was on it last.
    shown: Option<(String, f64)>,
    /// A look whose preview has ended under the pointer. It is previewed again once the pointer has left it.
    ended: Option<String>,
    /// The colour map under the pointer.
    colors: Option<ColorMap>,
}

/// A look that is previewed.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewedLook {
    /// Its name.
    pub name: String,
    /// The edited settings with this look.
    pub settings: Settings,
}

impl Preview {
    /// A frame: the look under the pointer, if any, and whether the pointer is among looks at all. Returns the seconds until
    /// something changes though nothing comes in.
    pub fn follow(&mut self, now: f64, pointed: Option<&str>, is_among: bool) -> Option<f64> {
        if self.ended.as_deref() != pointed {
            self.ended = None;
        }
        let pointed = pointed.filter(|_| self.ended.is_none());
        let since = match (&self.pointed, pointed) {
            (Some((name, since)), Some(now_pointed)) if name == now_pointed => *since,
            _ => now,
        };
        self.pointed = pointed.map(|name| (name.to_owned(), since));
        let Some(name) = pointed else {
            let (_, last) = self.shown.as_ref()?;
            let left = last + STAYS - now;
            if !is_among || left <= 0.0 {
                self.shown = None;
                return None;
            }
            return Some(left);
        };
        let left = since + RESTS - now;
        if self.shown.is_none() && left > 0.0 {
            return Some(left);
        }
        self.shown = Some((name.to_owned(), now));
        None
    }

    /// This look is not previewed until the pointer has left it: a click has taken it, or its preview cannot begin.
    pub fn end_on(&mut self, name: &str) {
        self.end();
        self.ended = Some(name.to_owned());
    }

    /// Nothing is previewed.
    pub fn end(&mut self) {
        (self.pointed, self.shown) = (None, None);
    }

    /// Is a preview about to begin?
    pub fn is_coming(&self) -> bool {
        self.pointed.is_some() && self.shown.is_none()
    }

    /// The name of the look that is previewed.
    pub fn look(&self) -> Option<&str> {
        self.shown.as_ref().map(|(name, _)| name.as_str())
    }

    /// The colour map under the pointer in this frame.
    pub fn point_at(&mut self, colors: Option<ColorMap>) {
        self.colors = colors;
    }

    /// The colour map under the pointer.
    pub fn colors(&self) -> Option<ColorMap> {
        self.colors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: previews of looks that the pointer only crosses, a wait at every look, and a preview that stays when the
    /// pointer has gone.
    #[test]
    fn the_first_look_waits_for_a_pointer_that_rests_and_the_next_ones_do_not() {
        let mut preview = Preview::default();
        let mut at = |now, pointed, is_among| {
            let wait = preview.follow(now, pointed, is_among);
            (wait.is_some(), preview.look().map(str::to_owned))
        };
        let none = (false, None);
        let shows = |name: &str| (false, Some(name.to_owned()));
        assert_eq!(at(0.0, Some("cells"), true), (true, None));
        // Another look under the pointer begins its own wait.
        assert_eq!(at(0.1, Some("rings"), true), (true, None));
        assert_eq!(at(0.2, Some("rings"), true), (true, None));
        assert_eq!(at(0.26, Some("rings"), true), shows("rings"));
        // Over the gap between two.
        assert_eq!(at(0.3, None, true), (true, Some("rings".to_owned())));
        assert_eq!(at(0.4, Some("cells"), true), shows("cells"));
        assert_eq!(at(0.5, None, true), (true, Some("cells".to_owned())));
        assert_eq!(at(0.7, None, true), none);
        // It is the first one again.
        assert_eq!(at(0.8, Some("cells"), true), (true, None));
        assert_eq!(at(1.0, Some("cells"), true), shows("cells"));
        // Elsewhere it ends at once.
        assert_eq!(at(1.01, None, false), none);
    }

    /// Would catch: a preview that covers what a click has just chosen, and one that cannot begin and is tried again in each frame.
    #[test]
    fn a_preview_that_has_ended_does_not_come_again_until_the_pointer_leaves_its_look() {
        let mut preview = Preview::default();
        preview.follow(0.0, Some("cells"), true);
        preview.follow(0.2, Some("cells"), true);
        assert_eq!(preview.look(), Some("cells"));
        preview.end_on("cells");
        for now in [0.2, 0.5, 9.0] {
            assert_eq!(preview.follow(now, Some("cells"), true), None);
            assert_eq!(preview.look(), None);
        }
        preview.follow(9.1, Some("rings"), true);
        preview.follow(9.2, Some("cells"), true);
        preview.follow(9.4, Some("cells"), true);
        assert_eq!(preview.look(), Some("cells"));
    }
}
