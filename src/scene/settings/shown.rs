//! The views of pictures: one row for each, with all of its texts. `src/render/renderer/` draws them.

use super::Settings;
use crate::choice::choice;
use Part::{Charts, Distances, Flat, OwnColors, Points, Scale, Trail};

/// A feature of some views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The trail.
    Trail,
    /// The colour map, as a scale from none to much.
    Scale,
    /// Colours that do not depend on the trail or the colour map.
    OwnColors,
    /// The atlas's charts, with the strength of `picture.charts`.
    Charts,
    /// Particles as points.
    Points,
    /// Distances between objects: there must be two of them, and a step must have been run.
    Distances,
    /// The atlas, unwrapped, in place of objects that a camera sees.
    Flat,
}

/// The panel's legend for the colours of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Legend {
    /// Nothing.
    None,
    /// Some values of the trail, in their colours.
    Trail,
    /// Hues of headings, as shares of a turn, each with what it means; and a hint.
    Hues(&'static [(f32, &'static str)], &'static str),
    /// Shares of the colour map, and what they mean.
    Scale(&'static [f32], &'static str),
    /// Linear light, each with what it means; `{reach}` stands for the reach of distances.
    Lights(&'static [([f32; 3], &'static str)]),
    /// The colours of objects with their names, and a last line.
    Objects(&'static str),
}

/// A row of the table of views.
#[derive(Clone, Copy, Debug)]
struct View {
    /// As buttons call it.
    title: &'static str,
    /// A one-line description.
    help: &'static str,
    /// Its key in the window, and what the list of keys says about it.
    key: Option<(&'static str, &'static str)>,
    has: &'static [Part],
    legend: Legend,
}

/// Declares [`Show`] and the table of its rows, of each view its word in scene files and its row.
macro_rules! views {
    ($($(#[$doc:meta])* $show:ident = $word:literal: $view:expr,)+) => {
        choice! {
            /// The view of pictures.
            Show {
                $($(#[$doc])* $show = $word,)+
            }
        }

        /// In the order of [`Show::ALL`].
        const VIEWS: &[View] = &[$($view),+];
    };
}

views! {
    /// The lit surface in the trail's colours.
    #[default]
    Surface = "surface": View {
        title: "Trail",
        help: "the lit surface in the trail's colours",
        key: Some(("1", "trail on the lit surface")),
        has: &[Trail, Scale, Charts],
        legend: Legend::Trail,
    },
    /// The trail raised by light.
    Relief = "relief": View {
        title: "Relief",
        help: "the trail raised by light, as if it stood up from the surface",
        key: Some(("2", "relief")),
        has: &[Trail, Scale, Charts],
        legend: Legend::Trail,
    },
    /// The trail as the only light.
    Glow = "glow": View {
        title: "Glow",
        help: "the trail as the only light, in the dark",
        key: Some(("3", "glow")),
        has: &[Trail, Scale, Charts],
        legend: Legend::Trail,
    },
    /// Every particle as a point.
    Particles = "particles": View {
        title: "Particles",
        help: "every particle as a point",
        key: Some(("4", "particles")),
        has: &[Points, Charts],
        legend: Legend::None,
    },
    /// Every particle as a point in the hue of its heading.
    Headings = "headings": View {
        title: "Headings",
        help: "every particle in the hue of its heading: right red, up green, left blue, down violet",
        key: Some(("5", "headings")),
        has: &[Points, Charts],
        legend: Legend::Hues(
            &[(0.0, "right"), (0.25, "up"), (0.5, "left"), (0.75, "down")],
            "Where particles head, seen from in front of the surface",
        ),
    },
    /// Particles by area.
    Density = "density": View {
        title: "Density",
        help: "how many particles there are by area, in the trail's colours",
        key: Some(("6", "density of particles")),
        has: &[Scale],
        // By doublings, of which the shader has six.
        legend: Legend::Scale(
            &[0.0, 1.0 / 6.0, 2.0 / 6.0, 4.0 / 6.0, 1.0],
            "0, 1, 3, 15, 63 times as crowded as on the mean",
        ),
    },
    /// The edges of triangles.
    Wireframe = "wireframe": View {
        title: "Wireframe",
        help: "the edges of triangles, over a faint trail",
        key: Some(("7", "wireframe")),
        has: &[Trail, Scale],
        legend: Legend::None,
    },
    /// The atlas's charts.
    Charts = "charts": View {
        title: "Charts",
        help: "the atlas's charts, each in a colour, with their seams",
        key: None,
        has: &[],
        legend: Legend::None,
    },
    /// Signed distance to other objects.
    Distance = "distance": View {
        title: "Distance",
        help: "signed distance to other objects: blue outside, orange inside, bright where they touch",
        key: Some(("8", "signed distance")),
        has: &[Distances, OwnColors],
        legend: Legend::Lights(&[
            ([0.72, 0.72, 0.70], "beside another object"),
            ([0.05, 0.2, 0.6], "away from it; grey beyond {reach} scene radii"),
            ([0.6, 0.13, 0.02], "inside of it"),
        ]),
    },
    /// The nearest other object.
    Nearest = "nearest": View {
        title: "Nearest",
        help: "the colour of the nearest other object; each object's own, dark, beyond reach",
        key: Some(("9", "nearest object")),
        has: &[Distances, OwnColors],
        legend: Legend::Objects("bright: the nearest; dark: its own, none in reach"),
    },
    /// The atlas, unwrapped.
    Atlas = "atlas": View {
        title: "Atlas",
        help: "the texture that holds the trail, unwrapped",
        key: Some(("0", "atlas, unwrapped")),
        has: &[Flat, Trail, Scale, Charts],
        legend: Legend::Trail,
    },
}

impl Show {
    fn view(self) -> &'static View {
        &VIEWS[self as usize]
    }

    /// As buttons call it.
    #[must_use]
    pub fn title(self) -> &'static str {
        self.view().title
    }

    /// What it shows, in a line.
    #[must_use]
    pub fn help(self) -> &'static str {
        self.view().help
    }

    /// Its key in the window, and what the list of keys says about it; `None` where it has no key.
    #[must_use]
    pub fn key(self) -> Option<(&'static str, &'static str)> {
        self.view().key
    }

    /// Does it have this?
    #[must_use]
    pub fn has(self, part: Part) -> bool {
        self.view().has.contains(&part)
    }

    /// The panel's legend for its colours.
    #[must_use]
    pub fn legend(self) -> Legend {
        self.view().legend
    }

    /// What a scene lacks for this view; `None` if it lacks nothing.
    #[must_use]
    pub fn why_not(self, settings: &Settings) -> Option<&'static str> {
        (self.has(Distances) && settings.objects.len() < 2)
            .then_some("it needs a second object, and there is only one")
    }

    /// Does it show the atlas's charts with the strength of `picture.charts`?
    #[must_use]
    pub fn has_charts(self) -> bool {
        self.has(Charts)
    }

    /// Is it flat, and not seen by the camera?
    #[must_use]
    pub fn is_flat(self) -> bool {
        self.has(Flat)
    }

    /// The titles of all views that meet a condition, as part of a sentence.
    #[must_use]
    pub fn titles(is_meant: impl Fn(Self) -> bool) -> String {
        let meant = Self::ALL.iter().filter(|show| is_meant(**show));
        let titles: Vec<&str> = meant.map(|show| show.title()).collect();
        match &titles[..] {
            [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
            _ => titles.concat(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_stand_in_a_sentence() {
        assert_eq!(Show::titles(|show| show == Show::Glow), "Glow");
        let of_two = Show::titles(|show| [Show::Atlas, Show::Glow].contains(&show));
        assert_eq!(of_two, "Glow and Atlas");
        let three = [Show::Surface, Show::Density, Show::Charts];
        let of_three = Show::titles(|show| three.contains(&show));
        assert_eq!(of_three, "Trail, Density and Charts");
    }

    #[test]
    fn each_key_shows_one_view() {
        let mut keys: Vec<_> = Show::ALL.iter().filter_map(|show| show.key()).collect();
        let count = keys.len();
        keys.sort_unstable();
        keys.dedup_by_key(|(key, _)| *key);
        assert_eq!(keys.len(), count);
    }
}
