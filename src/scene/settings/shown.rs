//! What pictures can show, in words; and why one of them has nothing to show in a scene.

use super::{Settings, Show};

impl Show {
    /// As buttons call it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Surface => "Trail",
            Self::Relief => "Relief",
            Self::Glow => "Glow",
            Self::Particles => "Particles",
            Self::Headings => "Headings",
            Self::Density => "Density",
            Self::Wireframe => "Wireframe",
            Self::Charts => "Charts",
            Self::Distance => "Distance",
            Self::Nearest => "Nearest",
            Self::Atlas => "Atlas",
        }
    }

    /// What it shows, in a line.
    #[must_use]
    pub fn help(self) -> &'static str {
        match self {
            Self::Surface => "the lit surface in the trail's colours",
            Self::Relief => "the trail raised by light, as if it stood up from the surface",
            Self::Glow => "the trail as the only light, in the dark",
            Self::Particles => "every particle as a point",
            Self::Headings => {
                "every particle in the hue of its heading: right red, up green, left blue, down violet"
            }
            Self::Density => "how many particles there are by area, in the trail's colours",
            Self::Wireframe => "the edges of triangles, over a faint trail",
            Self::Charts => "the atlas's charts, each in a colour, with their seams",
            Self::Distance => {
                "signed distance to other objects: blue outside, orange inside, bright where they touch"
            }
            Self::Nearest => {
                "the colour of the nearest other object; each object's own, dark, beyond reach"
            }
            Self::Atlas => "the texture that holds the trail, unwrapped",
        }
    }

    /// What a scene would need for it to have something to show; `None` where it has.
    #[must_use]
    pub fn why_not(self, settings: &Settings) -> Option<&'static str> {
        let needs_others = matches!(self, Self::Distance | Self::Nearest);
        (needs_others && settings.objects.len() < 2)
            .then_some("it needs a second object, and there is only one")
    }

    /// Does it show as much of the atlas's charts as `picture.charts` says?
    #[must_use]
    pub fn has_charts(self) -> bool {
        matches!(
            self,
            Self::Surface
                | Self::Relief
                | Self::Glow
                | Self::Particles
                | Self::Headings
                | Self::Atlas
        )
    }

    /// Is it flat, and not seen by the camera?
    #[must_use]
    pub fn is_flat(self) -> bool {
        self == Self::Atlas
    }
}
