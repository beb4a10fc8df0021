//! The rows of the parameter table.

use super::{Effect, Kind, Number, Parameter, Scale};
use crate::scene::settings::{
    AtlasMethod, Border, ColorMap, DistanceMethod, ObjectSettings, Show, SignRule, Start, Strategy,
};

macro_rules! real {
    ($($field:ident).+, $range:expr, $slider:expr, $scale:ident) => {
        Kind::Number(Number {
            range: $range,
            slider: $slider,
            scale: Scale::$scale,
            integer: false,
            get: |s| s.$($field).+ as f64,
            set: |s, value| s.$($field).+ = value as f32,
        })
    };
}

macro_rules! whole {
    ($($field:ident).+: $type:ty, $range:expr, $slider:expr, $scale:ident) => {
        Kind::Number(Number {
            range: $range,
            slider: $slider,
            scale: Scale::$scale,
            integer: true,
            get: |s| s.$($field).+ as f64,
            set: |s, value| s.$($field).+ = value.round() as $type,
        })
    };
}

macro_rules! word {
    ($($field:ident).+: $type:ty) => {
        Kind::Choice {
            words: <$type>::WORDS,
            get: |s| s.$($field).+ as usize,
            set: |s, i| s.$($field).+ = <$type>::ALL[i],
        }
    };
}

macro_rules! vector {
    ($($field:ident).+, $range:expr) => {
        Kind::Vector { range: $range, get: |s| s.$($field).+, set: |s, value| s.$($field).+ = value }
    };
}

/// Every parameter of a scene, in the order that people read them.
pub static PARAMETERS: &[Parameter] = &[
    Parameter {
        key: "seed",
        name: "Seed",
        unit: "",
        help: "Everything random depends on it: the same scene, seed and device give the same bits.",
        effect: Effect::Restart,
        kind: whole!(seed: u64, (0.0, 4_294_967_295.0), (0.0, 9_999.0), Linear),
    },
    Parameter {
        key: "radius",
        name: "Scene radius",
        unit: "world units",
        help: "Lengths are multiples of it. 0 measures it: from the centre of the box round all objects to the vertex farthest away.",
        effect: Effect::Restart,
        kind: real!(radius, (0.0, 1e9), (0.0, 10.0), Logarithmic),
    },
    Parameter {
        key: "particles.count",
        name: "Particle count",
        unit: "particles",
        help: "How many particles walk on all objects together.",
        effect: Effect::Restart,
        kind: whole!(particles.count: u32, (1.0, 1_073_741_824.0), (1_000.0, 8_000_000.0), Logarithmic),
    },
    Parameter {
        key: "particles.start",
        name: "Start",
        unit: "",
        help: "Where particles begin: everywhere (equally many for equal area), at one point, or on a ring round it, heading inwards.",
        effect: Effect::Restart,
        kind: word!(particles.start: Start),
    },
    Parameter {
        key: "particles.start_at",
        name: "Start point",
        unit: "scene radii",
        help: "For the starts point and ring: the surface point nearest to this place, counted from the scene's centre.",
        effect: Effect::Restart,
        kind: vector!(particles.start_at, (-100.0, 100.0)),
    },
    Parameter {
        key: "particles.start_radius",
        name: "Start radius",
        unit: "scene radii",
        help: "For the start ring: how far along the surface from the start point particles begin.",
        effect: Effect::Restart,
        kind: real!(particles.start_radius, (0.0, 10.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "physarum.speed",
        name: "Particle speed",
        unit: "scene radii per step",
        help: "Length walked in a step.",
        effect: Effect::Live,
        kind: real!(physarum.speed, (0.0, 10.0), (0.0, 0.03), Logarithmic),
    },
    Parameter {
        key: "physarum.rotation_angle",
        name: "Rotation angle",
        unit: "degrees per step",
        help: "How far a particle turns towards the better of its outer sensors.",
        effect: Effect::Live,
        kind: real!(
            physarum.rotation_angle,
            (-360.0, 360.0),
            (0.0, 120.0),
            Linear
        ),
    },
    Parameter {
        key: "physarum.sensor_angle",
        name: "Sensor angle",
        unit: "degrees",
        help: "Between the middle sensor and the outer ones.",
        effect: Effect::Live,
        kind: real!(physarum.sensor_angle, (0.0, 180.0), (0.0, 120.0), Linear),
    },
    Parameter {
        key: "physarum.sensor_offset",
        name: "Sensor offset",
        unit: "scene radii",
        help: "How far ahead the sensors read. Larger values give a coarser network.",
        effect: Effect::Live,
        kind: real!(physarum.sensor_offset, (0.0, 10.0), (0.0, 0.2), Logarithmic),
    },
    Parameter {
        key: "physarum.sensor_noise",
        name: "Sensor noise",
        unit: "trail units",
        help: "Standard deviation of the Gaussian noise added to each sensor. 0 for none.",
        effect: Effect::Live,
        kind: real!(physarum.sensor_noise, (0.0, 1e6), (0.0, 20.0), Logarithmic),
    },
    Parameter {
        key: "physarum.deposit",
        name: "Deposit amount",
        unit: "trail units",
        help: "Trail that one particle leaves in a step, where texels have the mean size.",
        effect: Effect::Live,
        kind: real!(physarum.deposit, (0.0, 1e6), (0.0, 10.0), Logarithmic),
    },
    Parameter {
        key: "physarum.border",
        name: "Border rule",
        unit: "",
        help: "At the open border of a surface particles are reflected, or stop there.",
        effect: Effect::Live,
        kind: word!(physarum.border: Border),
    },
    Parameter {
        key: "physarum.edge_crossing_attempts",
        name: "Edge-crossing attempts",
        unit: "edges per walk",
        help: "How many edges one walk may cross in a step. What is left of it is walked first in the next step.",
        effect: Effect::Live,
        kind: whole!(physarum.edge_crossing_attempts: u32, (0.0, 1_000.0), (0.0, 64.0), Linear),
    },
    Parameter {
        key: "physarum.favourite_density",
        name: "Favourite trail density",
        unit: "trail units",
        help: "Particles seek this much trail and avoid more. 0: the more the better.",
        effect: Effect::Live,
        kind: real!(
            physarum.favourite_density,
            (0.0, 1e6),
            (0.0, 100.0),
            Logarithmic
        ),
    },
    Parameter {
        key: "physarum.gravity_weight",
        name: "Gravity weight",
        unit: "trail units per scene radius",
        help: "Added to a sensor for its height (+Y). Positive values climb, negative ones sink, 0 is off.",
        effect: Effect::Live,
        kind: real!(
            physarum.gravity_weight,
            (-1e6, 1e6),
            (-100.0, 100.0),
            Linear
        ),
    },
    Parameter {
        key: "physarum.decrowding_weight",
        name: "Decrowding weight",
        unit: "trail units per particle",
        help: "Taken from a sensor for each particle that its texel counted in the last step. 0 is off.",
        effect: Effect::Live,
        kind: real!(
            physarum.decrowding_weight,
            (-1e6, 1e6),
            (0.0, 20.0),
            Logarithmic
        ),
    },
    Parameter {
        key: "physarum.distance_weight",
        name: "Distance weight",
        unit: "trail units per scene radius",
        help: "Added to a sensor for the signed distance to other objects. Positive values keep away from them, negative ones seek them, 0 is off.",
        effect: Effect::Live,
        kind: real!(
            physarum.distance_weight,
            (-1e6, 1e6),
            (-100.0, 100.0),
            Linear
        ),
    },
    Parameter {
        key: "time.steps_per_second",
        name: "Steps per second",
        unit: "steps per second",
        help: "A cap in the window. 0 for none.",
        effect: Effect::Live,
        kind: real!(time.steps_per_second, (0.0, 10_000.0), (0.0, 240.0), Linear),
    },
    Parameter {
        key: "trail.diffusion",
        name: "Trail diffusion",
        unit: "",
        help: "How much of a texel is replaced by the mean of its neighbourhood in a step: 0 none, 1 all.",
        effect: Effect::Live,
        kind: real!(trail.diffusion, (0.0, 1.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "trail.diffusion_distance",
        name: "Diffusion distance",
        unit: "texels",
        help: "Reach of that neighbourhood: 1 is 3 x 3 texels, 2 is 5 x 5.",
        effect: Effect::Restart,
        kind: whole!(trail.diffusion_distance: u32, (1.0, 4.0), (1.0, 4.0), Linear),
    },
    Parameter {
        key: "trail.decay",
        name: "Trail decay",
        unit: "",
        help: "What remains of the trail after a step, deposits included: 0 forgets at once, 1 forgets nothing.",
        effect: Effect::Live,
        kind: real!(trail.decay, (0.0, 1.0), (0.5, 1.0), Linear),
    },
    Parameter {
        key: "atlas.method",
        name: "Atlas method",
        unit: "",
        help: "How triangles are laid out in the texture. charts: few large charts in which triangles keep shape and size. grid: square cells, equally many texels for each triangle. mesh: the model's own texture coordinates.",
        effect: Effect::Restart,
        kind: word!(atlas.method: AtlasMethod),
    },
    Parameter {
        key: "atlas.size",
        name: "Atlas size",
        unit: "texels a side",
        help: "Side of the square texture that holds every triangle of every object.",
        effect: Effect::Restart,
        kind: whole!(atlas.size: u32, (16.0, 32_768.0), (256.0, 8_192.0), Logarithmic),
    },
    Parameter {
        key: "atlas.cell_size",
        name: "Cell size",
        unit: "texels a side",
        help: "For the method grid: side of the cell that two triangles share. 0 for as large as fits.",
        effect: Effect::Restart,
        kind: whole!(atlas.cell_size: u32, (0.0, 32_768.0), (0.0, 128.0), Linear),
    },
    Parameter {
        key: "distance.method",
        name: "Distance method",
        unit: "",
        help: "How the nearest triangle of another object is found: in a tree of boxes, or by looking at every one, which is slow and a check on the other.",
        effect: Effect::Live,
        kind: word!(distance.method: DistanceMethod),
    },
    Parameter {
        key: "distance.sign",
        name: "Distance sign",
        unit: "",
        help: "How it is told whether a place is inside of an object. pseudonormal: by the normal of the nearest face, edge or vertex. winding: by the winding number, also right where a mesh has holes, and slower. facing: outside if any of equally near faces looks towards the place, which is wrong in creases.",
        effect: Effect::Live,
        kind: word!(distance.sign: SignRule),
    },
    Parameter {
        key: "distance.interval",
        name: "Distance interval",
        unit: "steps",
        help: "Distances are taken at most every so many steps, and only where objects have moved.",
        effect: Effect::Live,
        kind: whole!(distance.interval: u32, (1.0, 1_000.0), (1.0, 60.0), Linear),
    },
    Parameter {
        key: "distance.reach",
        name: "Distance reach",
        unit: "scene radii",
        help: "The farthest that distances between objects are told. More takes more time.",
        effect: Effect::Live,
        kind: real!(distance.reach, (0.0, 100.0), (0.01, 1.0), Logarithmic),
    },
    Parameter {
        key: "transfer.strategy",
        name: "Transfer strategy",
        unit: "",
        help: "What becomes of particles that go into another object. none: they walk on. respawn: they begin anew on their own object. The others let them change objects, and differ in how the particle buffer is kept in order: scattered: not at all. sequential, parallel: each object has a window of it, kept in order by one invocation or by many. direct: all objects' particles advance together, and change at once. scattered, sequential and parallel give the same bits.",
        effect: Effect::Live,
        kind: word!(transfer.strategy: Strategy),
    },
    Parameter {
        key: "transfer.threshold",
        name: "Transfer threshold",
        unit: "scene radii",
        help: "Places whose signed distance to other objects is smaller are covered: particles that go into covered places change objects. At most the distance reach.",
        effect: Effect::Live,
        kind: real!(transfer.threshold, (-100.0, 100.0), (-0.05, 0.05), Linear),
    },
    Parameter {
        key: "transfer.buffer_size",
        name: "Transfer buffer size",
        unit: "particles",
        help: "How many particles may be under way between objects at once. Those that find it full stay on their object, and are counted. A smaller size than are under way takes effect when they have arrived.",
        effect: Effect::Live,
        kind: whole!(transfer.buffer_size: u32, (1.0, 2_097_152.0), (1_024.0, 1_048_576.0), Logarithmic),
    },
    Parameter {
        key: "camera.azimuth",
        name: "Azimuth",
        unit: "degrees",
        help: "Where the camera stands about the up axis.",
        effect: Effect::Live,
        kind: real!(
            camera.azimuth,
            (-36_000.0, 36_000.0),
            (-180.0, 180.0),
            Linear
        ),
    },
    Parameter {
        key: "camera.elevation",
        name: "Elevation",
        unit: "degrees",
        help: "How far the camera looks down from above the horizon.",
        effect: Effect::Live,
        kind: real!(camera.elevation, (-88.0, 88.0), (-88.0, 88.0), Linear),
    },
    Parameter {
        key: "camera.distance",
        name: "Distance",
        unit: "scene radii",
        help: "From the camera to what it looks at. 0 for as far as shows every object whole.",
        effect: Effect::Live,
        kind: real!(camera.distance, (0.0, 50.0), (0.0, 10.0), Logarithmic),
    },
    Parameter {
        key: "camera.target",
        name: "Target",
        unit: "scene radii",
        help: "What the camera looks at, counted from the scene's centre.",
        effect: Effect::Live,
        kind: vector!(camera.target, (-1_000.0, 1_000.0)),
    },
    Parameter {
        key: "camera.field_of_view",
        name: "Field of view",
        unit: "degrees",
        help: "Vertical opening angle of the picture.",
        effect: Effect::Live,
        kind: real!(camera.field_of_view, (1.0, 150.0), (10.0, 90.0), Linear),
    },
    Parameter {
        key: "picture.brightest",
        name: "Brightest trail",
        unit: "trail units",
        help: "Trail that gets the brightest colour. 0 takes it from the trail's own range.",
        effect: Effect::Live,
        kind: real!(picture.brightest, (0.0, 1e9), (0.0, 200.0), Logarithmic),
    },
    Parameter {
        key: "picture.show",
        name: "Show",
        unit: "",
        help: "The lit surface in the trail's colours, the same with every particle as a point over it, or the unwrapped atlas.",
        effect: Effect::Live,
        kind: word!(picture.show: Show),
    },
    Parameter {
        key: "picture.color_map",
        name: "Colour map",
        unit: "",
        help: "Colours of the trail, from none to much.",
        effect: Effect::Live,
        kind: word!(picture.color_map: ColorMap),
    },
    Parameter {
        key: "picture.charts",
        name: "Charts",
        unit: "",
        help: "How much of the atlas's charts is shown, each in a colour of its own, with seams as light lines: 0 nothing, 0.5 under the trail, 1 nothing else.",
        effect: Effect::Live,
        kind: real!(picture.charts, (0.0, 1.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "picture.particle_size",
        name: "Particle size",
        unit: "pixels",
        help: "Diameter of a drawn particle.",
        effect: Effect::Live,
        kind: real!(picture.particle_size, (0.1, 64.0), (0.5, 8.0), Linear),
    },
    Parameter {
        key: "picture.background",
        name: "Background",
        unit: "",
        help: "Colour behind the objects: red, green and blue as the eye sees them (sRGB).",
        effect: Effect::Live,
        kind: vector!(picture.background, (0.0, 1.0)),
    },
];

/// The parameters of one `[[object]]`, beside its name and mesh. Poses change while a simulation runs; a scale does
/// not, because walks and texels are measured in world lengths.
pub static OBJECT_PARAMETERS: &[Parameter<ObjectSettings>] = &[
    Parameter {
        key: "position",
        name: "Position",
        unit: "world units",
        help: "Where the object's origin stands.",
        effect: Effect::Live,
        kind: vector!(position, (-1e9, 1e9)),
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
];
