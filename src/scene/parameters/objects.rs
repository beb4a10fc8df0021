//! The rows of the parameter table for one `[[object]]`.

use super::{Effect, Kind, Number, Own, Parameter, Scale, one_table};
use crate::scene::settings::physarum::{only_own, physarum};
use crate::scene::settings::{
    Easing, Heading, MOST_HALF_LIFE, ModelAnimation, ObjectSettings, ObjectStart, Repeat,
};

/// The parameters of one `[[object]]`, beside its name and mesh. Poses change while a simulation runs; a scale does
/// not, because walks and texels are measured in world lengths.
pub static OBJECT_PARAMETERS: &[Parameter<ObjectSettings>] =
    &one_table::<{ PLACE.len() + PHYSARUM.len() + TRAIL.len() }, 3, ObjectSettings>([
        PLACE, PHYSARUM, TRAIL,
    ]);

macro_rules! own_physarum_rows {
    ($($for:ident $row:tt)*) => { only_own! { own_rows [] $($for $row)* } };
}
macro_rules! own_rows {
    ($({
        $(#[$doc:meta])* $field:ident: $type:ident = $default:expr, $kind:ident ($($range:tt)*),
        $name:literal, $unit:literal, $help:literal
    })*) => {
        &[$(Parameter {
            key: concat!("physarum.", stringify!($field)),
            name: $name,
            unit: $unit,
            help: concat!("For particles on this object, over the scene's physarum.", stringify!($field), "."),
            effect: Effect::Live,
            kind: own!($kind physarum.$field: $type, $($range)*),
        },)*]
    };
}

/// Parameters of its particles.
const PHYSARUM: &[Parameter<ObjectSettings>] = physarum!(own_physarum_rows);

/// How its trail spreads and decays.
const TRAIL: &[Parameter<ObjectSettings>] = &[
    Parameter {
        key: "trail.diffusion",
        name: "Trail diffusion",
        unit: "",
        help: "For the trail on this object, over the scene's trail.diffusion.",
        effect: Effect::Live,
        kind: own!(real trail.diffusion: f32, (0.0, 1.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "trail.diffusion_length",
        name: "Diffusion length",
        unit: "scene radii",
        help: "For the trail on this object, over the scene's trail.diffusion_length. 0: as its trail diffusion says.",
        effect: Effect::Live,
        kind: own!(real trail.diffusion_length: f32, (0.0, 1.0), (0.0, 0.01), Linear),
    },
    Parameter {
        key: "trail.decay",
        name: "Trail decay",
        unit: "",
        help: "For the trail on this object, over the scene's trail.decay.",
        effect: Effect::Live,
        kind: own!(real trail.decay: f32, (0.0, 1.0), (0.5, 1.0), Linear),
    },
    Parameter {
        key: "trail.half_life",
        name: "Half-life",
        unit: "steps",
        help: "For the trail on this object, over the scene's trail.half_life. 0: as its trail decay says.",
        effect: Effect::Live,
        kind: own!(real trail.half_life: f32, (0.0, MOST_HALF_LIFE), (0.0, 200.0), Linear),
    },
];

/// Its pose.
const PLACE: &[Parameter<ObjectSettings>] = &[
    Parameter {
        key: "position",
        name: "Position",
        unit: "world units",
        help: "The position of the object's origin.",
        effect: Effect::Live,
        kind: place!(position),
    },
    Parameter {
        key: "rotation",
        name: "Rotation",
        unit: "degrees",
        help: "About the world's X axis, then Y, then Z.",
        effect: Effect::Live,
        kind: vector!(rotation, (-36_000.0, 36_000.0)),
    },
    Parameter {
        key: "scale",
        name: "Scale",
        unit: "",
        help: "Multiplies the mesh's coordinates.",
        effect: Effect::Restart,
        kind: real!(scale, (1e-6, 1e6), (0.05, 20.0), Logarithmic),
    },
    Parameter {
        key: "texel_weight",
        name: "Texel weight",
        unit: "",
        help: "For the atlas method charts: texels per surface area, relative to the other objects. 4 gives an object twice the resolution.",
        effect: Effect::Restart,
        kind: real!(texel_weight, (0.01, 100.0), (0.1, 10.0), Logarithmic),
    },
    Parameter {
        key: "start.share",
        name: "Share of particles",
        unit: "",
        help: "Particles that begin on this object for its area, relative to the other objects: 2 twice as many, 0 none. For the start uniform, and where objects have starts of their own.",
        effect: Effect::Restart,
        kind: real!(start.share, (0.0, 1_000.0), (0.0, 10.0), Linear),
    },
    Parameter {
        key: "start.place",
        name: "Own start",
        unit: "",
        help: "Where the particles of this object's share of the whole area begin, on it, over the scene's particles.start. scene: with the others.",
        effect: Effect::Restart,
        kind: word!(start.place: ObjectStart),
    },
    Parameter {
        key: "start.at",
        name: "Own start point",
        unit: "scene radii",
        help: "As particles.start_at: the point of this object nearest to this place, counted from the scene's centre.",
        effect: Effect::Restart,
        kind: vector!(start.at, (-100.0, 100.0)),
    },
    Parameter {
        key: "start.radius",
        name: "Own start radius",
        unit: "scene radii",
        help: "For the own starts ring and disc: how far along the surface from the own start point particles begin.",
        effect: Effect::Restart,
        kind: real!(start.radius, (0.0, 10.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "start.mask",
        name: "Own start mask",
        unit: "",
        help: "As particles.start_mask, for the own start mask.",
        effect: Effect::Restart,
        kind: text!(start.mask, "a path relative to the scene file", true),
    },
    Parameter {
        key: "start.heading",
        name: "Own start heading",
        unit: "",
        help: "As particles.start_heading, for the own start.",
        effect: Effect::Restart,
        kind: word!(start.heading: Heading),
    },
    Parameter {
        key: "start.direction",
        name: "Own start direction",
        unit: "",
        help: "As particles.start_direction, for the own start heading aligned.",
        effect: Effect::Restart,
        kind: vector!(start.direction, (-1.0, 1.0)),
    },
    Parameter {
        key: "motion.spin",
        name: "Spin",
        unit: "degrees a second",
        help: "Turns the object about its own axes: one turn, about the axis that the three make up.",
        effect: Effect::Live,
        kind: vector!(motion.spin, (-36_000.0, 36_000.0)),
    },
    Parameter {
        key: "motion.orbit",
        name: "Orbit",
        unit: "degrees a second",
        help: "Carries the object round the orbit's centre, about axes along the world's, as if it stood on a turntable.",
        effect: Effect::Live,
        kind: vector!(motion.orbit, (-36_000.0, 36_000.0)),
    },
    Parameter {
        key: "motion.orbit_center",
        name: "Orbit centre",
        unit: "world units",
        help: "What the orbit goes round.",
        effect: Effect::Live,
        kind: place!(motion.orbit_center),
    },
    Parameter {
        key: "motion.swing",
        name: "Swing",
        unit: "degrees",
        help: "How far the object turns to either side, about its own axes, like a pendulum.",
        effect: Effect::Live,
        kind: vector!(motion.swing, (-36_000.0, 36_000.0)),
    },
    Parameter {
        key: "motion.swing_period",
        name: "Swing period",
        unit: "seconds",
        help: "There and back.",
        effect: Effect::Live,
        kind: real!(motion.swing_period, (0.001, 1e6), (0.5, 60.0), Logarithmic),
    },
    Parameter {
        key: "motion.swing_phase",
        name: "Swing phase",
        unit: "cycles",
        help: "How far ahead the swing begins: 0 in the middle, 0.25 at its end, 0.5 in the middle on the way back.",
        effect: Effect::Live,
        kind: real!(motion.swing_phase, (-1_000.0, 1_000.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "motion.slide",
        name: "Slide",
        unit: "world units",
        help: "How far the object moves to either side of its position, and back, along the world's axes.",
        effect: Effect::Live,
        kind: vector!(motion.slide, (-1e9, 1e9)),
    },
    Parameter {
        key: "motion.slide_period",
        name: "Slide period",
        unit: "seconds",
        help: "There and back.",
        effect: Effect::Live,
        kind: real!(motion.slide_period, (0.001, 1e6), (0.5, 60.0), Logarithmic),
    },
    Parameter {
        key: "motion.slide_phase",
        name: "Slide phase",
        unit: "cycles",
        help: "How far ahead the slide begins, as for the swing.",
        effect: Effect::Live,
        kind: real!(motion.slide_phase, (-1_000.0, 1_000.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "motion.pivot",
        name: "Pivot",
        unit: "world units",
        help: "What spin and swing turn about, counted from the object's origin along its own axes.",
        effect: Effect::Live,
        kind: place!(motion.pivot),
    },
    Parameter {
        key: "motion.model",
        name: "Model's animation",
        unit: "",
        help: "follow: the object goes where the first animation of its glTF model takes it, in a loop, and keyframes do not count. Only rigid animations can be followed.",
        effect: Effect::Restart,
        kind: word!(motion.model: ModelAnimation),
    },
    Parameter {
        key: "motion.repeat",
        name: "Keyframes repeat",
        unit: "",
        help: "After the last keyframe: loop begins again, once stays there, mirror goes back the same way.",
        effect: Effect::Live,
        kind: word!(motion.repeat: Repeat),
    },
    Parameter {
        key: "motion.easing",
        name: "Keyframes ease",
        unit: "",
        help: "From keyframe to keyframe at an even rate, or smoothly, coming to rest at each.",
        effect: Effect::Live,
        kind: word!(motion.easing: Easing),
    },
    Parameter {
        key: "motion.period",
        name: "Keyframes' period",
        unit: "seconds",
        help: "For the repeat loop: the time after which the keyframes begin again; in the rest of it the object moves from the last keyframe to the first. 0, or less than the last keyframe's time: at the last keyframe.",
        effect: Effect::Live,
        kind: real!(motion.period, (0.0, 1e6), (0.0, 60.0), Linear),
    },
];
