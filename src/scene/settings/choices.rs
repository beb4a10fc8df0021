//! Settings of scene files whose values are one of a few words.

pub use crate::mesh::atlas::AtlasMethod;

use crate::choice::choice;

choice! {
    /// The start places of particles.
    Start {
        /// Everywhere, equally many for equal area.
        #[default]
        Uniform = "uniform",
        /// All at one point, heading everywhere.
        Point = "point",
        /// On a circle round a point.
        Ring = "ring",
        /// Inside of such a circle.
        Disc = "disc",
        /// At the bright places of a picture of the texture.
        Mask = "mask",
        /// All on one food or marker.
        Food = "food",
    }
}

choice! {
    /// The start places of one object's particles.
    ObjectStart {
        /// As in the scene's start.
        #[default]
        Scene = "scene",
        /// Everywhere on the object.
        Uniform = "uniform",
        /// All at one point.
        Point = "point",
        /// On a circle round a point.
        Ring = "ring",
        /// Inside of such a circle.
        Disc = "disc",
        /// At the bright places of a picture of the texture.
        Mask = "mask",
    }
}

impl ObjectStart {
    /// The start as one of a scene; `None` if the object takes the scene's.
    #[must_use]
    pub fn own(self) -> Option<Start> {
        match self {
            Self::Scene => None,
            Self::Uniform => Some(Start::Uniform),
            Self::Point => Some(Start::Point),
            Self::Ring => Some(Start::Ring),
            Self::Disc => Some(Start::Disc),
            Self::Mask => Some(Start::Mask),
        }
    }
}

choice! {
    /// The headings of particles at the start.
    Heading {
        /// Inwards from a ring, otherwise random.
        #[default]
        Auto = "auto",
        /// Everywhere.
        Random = "random",
        /// In one direction, laid onto the surface.
        Aligned = "aligned",
        /// Away from the start's centre.
        Radial = "radial",
        /// Towards it.
        Inward = "inward",
    }
}

choice! {
    /// The treatment of particles that go into another object, and of the order of the particle buffer.
    Strategy {
        /// They walk on.
        None = "none",
        /// They restart on their own object.
        Respawn = "respawn",
        /// They change objects in place; every object's kernels run over all particles.
        Scattered = "scattered",
        /// They change objects; each object has a window of the buffer, kept in order by a single invocation.
        Sequential = "sequential",
        /// They change objects; each object has a window of the buffer, kept in order by many invocations.
        #[default]
        Parallel = "parallel",
        /// They change objects at once; all objects' particles advance together.
        Direct = "direct",
    }
}

choice! {
    /// Does the trail spread from object to object?
    TrailAcross {
        /// Each object's trail stays on it.
        #[default]
        Off = "off",
        /// It spreads over the lines in which two surfaces meet.
        On = "on",
    }
}

choice! {
    /// Where particles restart that have gone into another object.
    RestartPlace {
        /// Anywhere on their own object.
        #[default]
        Anywhere = "anywhere",
        /// Where particles of their object began.
        Start = "start",
    }
}

choice! {
    /// The path of a sensor to the place that it reads.
    Sensing {
        /// Straight in the atlas if its path stays in one chart; otherwise it walks.
        #[default]
        Auto = "auto",
        /// It walks on the surface.
        Walk = "walk",
    }
}

choice! {
    /// The trail that particles seek.
    Preference {
        /// The favourite density if it is above 0, otherwise the most.
        #[default]
        Auto = "auto",
        /// The more the better.
        More = "more",
        /// The favourite density, also if it is 0: then they avoid all trail.
        Favourite = "favourite",
    }
}

choice! {
    /// The published model whose rules particles follow, but for those that a scene names.
    Model {
        /// Particles may share places, and nothing is random but noise.
        #[default]
        Thesis = "thesis",
        /// One particle a cell, as in Jones (2010).
        Jones = "jones",
    }
}

choice! {
    /// The order of the stages of a step.
    StepOrder {
        /// That of the model.
        #[default]
        Model = "model",
        /// Particles sense and turn, then walk.
        SenseFirst = "sense_first",
        /// As `sense_first`, but in the first step they do not turn.
        MoveFirst = "move_first",
    }
}

choice! {
    /// Where a particle turns.
    Turning {
        /// As in the model.
        #[default]
        Model = "model",
        /// To the better side, if it is better than the middle.
        Better = "better",
        /// To a random side where both are better than the middle.
        Random = "random",
    }
}

choice! {
    /// Behaviour of a walk at an open border.
    Border {
        /// The heading is mirrored and the walk continues.
        #[default]
        Reflect = "reflect",
        /// The walk ends at the border.
        Stop = "stop",
    }
}

choice! {
    /// Does an object follow the animation of its model?
    ModelAnimation {
        /// It stays at the position in the file.
        #[default]
        Still = "still",
        /// It follows the first animation of the file.
        Follow = "follow",
    }
}

choice! {
    /// Behaviour after the last keyframe.
    Repeat {
        /// The first comes again.
        #[default]
        Loop = "loop",
        /// The object stays there.
        Once = "once",
        /// They are played backwards, then forwards again.
        Mirror = "mirror",
    }
}

choice! {
    /// How an object goes from keyframe to keyframe.
    Easing {
        /// At an even rate.
        #[default]
        Linear = "linear",
        /// Coming to rest at each.
        Smooth = "smooth",
    }
}

choice! {
    /// How the nearest triangle of another object is found.
    DistanceMethod {
        /// In a tree of boxes.
        #[default]
        Bvh = "bvh",
        /// By comparing all: slow, and a check on the others.
        Brute = "brute",
        /// By the graphics pipeline, whose depth test keeps the nearest.
        Raster = "raster",
    }
}

choice! {
    /// How a distance becomes a depth, of which the depth test keeps the smallest.
    DepthMapping {
        /// By the order of its bits, of which the last two are dropped.
        #[default]
        Ordered = "ordered",
        /// As a projection makes it, between a near and a far plane.
        Clip = "clip",
        /// By the logistic curve.
        Logistic = "logistic",
        /// By the arctangent.
        Arctangent = "arctangent",
        /// Straight.
        Linear = "linear",
    }
}

choice! {
    /// The rule that decides whether a place is inside of an object.
    SignRule {
        /// By the angle-weighted normal of the nearest face, edge or vertex.
        #[default]
        Pseudonormal = "pseudonormal",
        /// By the generalized winding number.
        Winding = "winding",
        /// Outside if any of equally near faces looks towards the place.
        Facing = "facing",
    }
}

choice! {
    /// Colours of the trail, from none to much.
    ColorMap {
        /// The program's own: dark earth to slime yellow.
        #[default]
        Myxo = "myxo",
        /// Blue to yellow by way of green, evenly.
        Viridis = "viridis",
        /// Black to white by way of purple and orange.
        Magma = "magma",
        /// Black to pale yellow by way of red.
        Inferno = "inferno",
        /// Blue to yellow by way of magenta.
        Plasma = "plasma",
        /// Dark blue to white.
        Ice = "ice",
        /// Dark to light green.
        Moss = "moss",
        /// Black to white.
        Grayscale = "grayscale",
    }
}

choice! {
    /// Do pictures show an overlay, such as food?
    Drawn {
        /// It is drawn.
        #[default]
        Shown = "shown",
        /// It is hidden, but still has its effect.
        Hidden = "hidden",
    }
}
