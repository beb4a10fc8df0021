//! Looks that were made up by chance, in the order in which they were, for the ways back to each of them.

use myxo::scene::parameters::PARAMETERS;
use myxo::scene::presets::is_look;
use myxo::scene::settings::Settings;

/// Looks that are kept; the oldest go.
const MOST: usize = 200;

/// All throws of the dice since the window was opened.
#[derive(Clone, Debug, Default)]
pub struct Throws {
    looks: Vec<Settings>,
    /// The one that was taken last.
    place: usize,
}

impl Throws {
    /// A new look, which comes last.
    pub fn keep(&mut self, look: &Settings) {
        self.looks.push(look.clone());
        if self.looks.len() > MOST {
            self.looks.remove(0);
        }
        self.place = self.looks.len() - 1;
    }

    /// The throw that was taken last and the number of all, counted from 1; none before the first.
    pub fn at(&self) -> Option<(usize, usize)> {
        (!self.looks.is_empty()).then_some((self.place + 1, self.looks.len()))
    }

    /// Is there a throw that way? `look` is the present one: if it is another than the last one taken, that one is before it.
    pub fn can_go(&self, forward: bool, look: &Settings) -> bool {
        self.next(forward, look).is_some()
    }

    /// Goes to the throw after or before. Gives the settings with its look.
    pub fn go(&mut self, forward: bool, look: &Settings) -> Option<Settings> {
        self.place = self.next(forward, look)?;
        let thrown = &self.looks[self.place];
        let mut to = look.clone();
        for parameter in PARAMETERS.iter().filter(|parameter| is_look(parameter)) {
            parameter.copy(thrown, &mut to);
        }
        Some(to)
    }

    fn next(&self, forward: bool, look: &Settings) -> Option<usize> {
        let thrown = self.looks.get(self.place)?;
        let mut parts = PARAMETERS.iter().filter(|parameter| is_look(parameter));
        let is_there = parts.all(|parameter| !parameter.differs(thrown, look));
        match (forward, is_there) {
            (true, _) => Some(self.place + 1).filter(|next| *next < self.looks.len()),
            (false, true) => self.place.checked_sub(1),
            (false, false) => Some(self.place),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::presets::by_chance;

    /// Would catch: a throw that is lost, a way back that skips one after another look was taken, and a throw that brings along
    /// more than a look.
    #[test]
    fn throws_lead_back_and_forward_and_change_nothing_but_the_look() {
        let mut settings = Settings::default();
        let mut throws = Throws::default();
        assert!(throws.at().is_none() && throws.go(false, &settings).is_none());
        let looks = [1, 2, 3].map(|seed| by_chance(&settings, seed));
        looks.iter().for_each(|look| throws.keep(look));
        assert_eq!(throws.at(), Some((3, 3)));
        assert!(!throws.can_go(true, &looks[2]) && throws.can_go(false, &looks[2]));
        let back = throws.go(false, &looks[2]);
        assert_eq!(back.as_ref(), Some(&looks[1]));
        assert_eq!(throws.at(), Some((2, 3)));
        // A preset was taken, and the seed is another one.
        settings.seed = 77;
        settings.trail.decay = 0.5;
        let again = throws.go(false, &settings).expect("the last one taken");
        assert_eq!((again.seed, again.trail.decay), (77, looks[1].trail.decay));
        assert_eq!(throws.at(), Some((2, 3)));
        assert_eq!(
            throws.go(true, &again).map(|look| look.physarum),
            Some(looks[2].physarum.clone())
        );
        assert!(throws.go(true, &looks[2]).is_none());
        // A new throw comes last, wherever one was.
        throws.go(false, &looks[2]);
        throws.keep(&by_chance(&settings, 4));
        assert_eq!(throws.at(), Some((4, 4)));
        (0..2 * MOST).for_each(|_| throws.keep(&settings));
        assert_eq!(throws.at(), Some((MOST, MOST)));
    }
}
