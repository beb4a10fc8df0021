//! The tools: what the pointer does in the picture, in words.

/// The tool of the pointer in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Turns the camera, and picks objects.
    #[default]
    Look,
    /// Adds trail.
    Trail,
    /// Takes away what was painted and what grew.
    Erase,
    /// Draws particles to a place.
    Attract,
    /// Keeps them away.
    Repel,
    /// Forbids them to enter.
    NoGo,
    /// Gives a place the second look.
    Blend,
    /// Takes particles to a place.
    Particles,
    /// Puts food and markers there, and picks them.
    Food,
    /// Sends a wave from a place.
    Pulse,
}

impl Tool {
    /// In the order of the bar.
    pub const ALL: [Self; 10] = [
        Self::Look,
        Self::Trail,
        Self::Erase,
        Self::Attract,
        Self::Repel,
        Self::NoGo,
        Self::Blend,
        Self::Particles,
        Self::Food,
        Self::Pulse,
    ];

    /// Its name, for tests and in the bar.
    pub fn word(self) -> &'static str {
        match self {
            Self::Look => "look",
            Self::Trail => "trail",
            Self::Erase => "erase",
            Self::Attract => "attract",
            Self::Repel => "repel",
            Self::NoGo => "no-go",
            Self::Blend => "blend",
            Self::Particles => "particles",
            Self::Food => "food",
            Self::Pulse => "pulse",
        }
    }

    pub(super) fn hint(self) -> &'static str {
        match self {
            Self::Look => {
                "Drag turns the scene, a click picks an object (B for the brush used last, Esc to come back)"
            }
            Self::Trail => {
                "Adds trail, which spreads and decays as any other. It grows on at once, so Ctrl Z does not take it back"
            }
            Self::Erase => {
                "Takes away trail, what attracts, repels or forbids, and the second look. Ctrl Z brings back all but the \
                 trail, which has grown on"
            }
            Self::Attract => {
                "Sensors read more here, so particles come; stays until it is erased, or undone by Ctrl Z"
            }
            Self::Repel => {
                "Sensors read less here, so particles go elsewhere; stays until it is erased, or undone by Ctrl Z"
            }
            Self::NoGo => {
                "Particles do not enter and turn round; those inside may leave. Stays until it is erased, or undone by \
                 Ctrl Z"
            }
            Self::Blend => {
                "Particles follow a second look here, which is mixed with the first at the edge; stays until it is erased, \
                 or undone by Ctrl Z"
            }
            Self::Particles => {
                "Particles come here, by chance from all over the same object; their number stays what it is. They walk \
                 on at once, so Ctrl Z does not send them back"
            }
            Self::Food => {
                "A click puts food there, or picks food that lies there; a drag moves it; Delete takes it away (O)"
            }
            Self::Pulse => {
                "A click sends a wave from there, over seams and to other objects, which sweeps particles along. Up to 8 at once; \
                 Ctrl Z does not take it back (M)"
            }
        }
    }

    /// Does it paint?
    pub fn is_brush(self) -> bool {
        !matches!(self, Self::Look | Self::Food | Self::Pulse)
    }
}
