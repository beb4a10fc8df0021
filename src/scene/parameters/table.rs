//! The rows of the parameter table.

use super::population::POPULATION;
use super::{Effect, Kind, Number, Parameter, Scale, one_table};
use crate::scene::settings::physarum::physarum;
use crate::scene::settings::{
    AtlasMethod, Border, ColorMap, DepthMapping, DistanceMethod, Drawn, Heading, Model,
    SECOND_LOOKS, Sensing, Settings, Show, SignRule, Start, StepOrder, Strategy, Turning,
};

/// The largest scene radius: squares of lengths stay far within single precision.
pub const MOST_RADIUS: f64 = 1e12;

/// Every parameter of a scene, in the order of the panel.
pub static PARAMETERS: &[Parameter] =
    &one_table::<{ BEFORE.len() + PHYSARUM.len() + POPULATION.len() + AFTER.len() }, 4, Settings>(
        [BEFORE, PHYSARUM, POPULATION, AFTER],
    );

macro_rules! physarum_rows {
    ($($for:ident {
        $(#[$doc:meta])* $field:ident: $type:ident = $default:expr, $kind:ident ($($range:tt)*),
        $name:literal, $unit:literal, $help:literal
    })*) => {
        &[$(Parameter {
            key: concat!("physarum.", stringify!($field)),
            name: $name,
            unit: $unit,
            help: $help,
            effect: physarum_effect!($for),
            kind: physarum_kind!($kind $field: $type, $($range)*),
        },)*]
    };
}
macro_rules! physarum_effect {
    (restart) => {
        Effect::Restart
    };
    ($for:ident) => {
        Effect::Live
    };
}
macro_rules! physarum_kind {
    (real $field:ident: $type:ident, $($range:tt)*) => { real!(physarum.$field, $($range)*) };
    (whole $field:ident: $type:ident, $($range:tt)*) => { whole!(physarum.$field: $type, $($range)*) };
    (word $field:ident: $type:ident,) => { word!(physarum.$field: $type) };
}

/// Parameters of particles.
const PHYSARUM: &[Parameter] = physarum!(physarum_rows);

const BEFORE: &[Parameter] = &[
    Parameter {
        key: "seed",
        name: "Seed",
        unit: "",
        help: "Everything random depends on it: the same scene and seed give the same bits.",
        effect: Effect::Restart,
        kind: whole!(seed: u64, (0.0, 4_294_967_295.0), (0.0, 9_999.0), Linear),
    },
    Parameter {
        key: "radius",
        name: "Scene radius",
        unit: "world units",
        help: "Lengths are multiples of it. 0 measures it: from the centre of the box round all objects to the vertex farthest away.",
        effect: Effect::Restart,
        kind: real!(radius, (0.0, MOST_RADIUS), (0.0, 10.0), Logarithmic),
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
        help: "Where particles begin. uniform: everywhere, equally many for equal area. point: all at a marker, the start point. ring, disc: on a circle round it, or inside. mask: where a picture of the texture is light. food: all on one food or marker.",
        effect: Effect::Restart,
        kind: word!(particles.start: Start),
    },
    Parameter {
        key: "particles.start_at",
        name: "Start point",
        unit: "scene radii",
        help: "The marker for the starts point, ring and disc: the surface point nearest to this place, counted from the scene's centre. Also what the headings radial and inward are away from.",
        effect: Effect::Restart,
        kind: vector!(particles.start_at, (-100.0, 100.0)),
    },
    Parameter {
        key: "particles.start_radius",
        name: "Start radius",
        unit: "scene radii",
        help: "For the starts ring and disc: how far along the surface from the start point particles begin.",
        effect: Effect::Restart,
        kind: real!(particles.start_radius, (0.0, 10.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "particles.start_object",
        name: "Start object",
        unit: "",
        help: "The name of the only object that particles begin on. Empty for all.",
        effect: Effect::Restart,
        kind: text!(
            particles.start_object,
            "the name of an object, or nothing",
            false
        ),
    },
    Parameter {
        key: "particles.start_food",
        name: "Start food",
        unit: "",
        help: "For the start food: on which food or marker particles begin, counted from 0; scattered food comes after the others.",
        effect: Effect::Restart,
        kind: whole!(particles.start_food: u32, (0.0, 255.0), (0.0, 15.0), Linear),
    },
    Parameter {
        key: "particles.start_mask",
        name: "Start mask",
        unit: "",
        help: "For the start mask: a PNG laid over the whole texture, as `myxo atlas --out` draws it; the lighter, the more particles for the area, and none where it is black.",
        effect: Effect::Restart,
        kind: text!(
            particles.start_mask,
            "a path relative to the scene file",
            true
        ),
    },
    Parameter {
        key: "particles.start_heading",
        name: "Start heading",
        unit: "",
        help: "Where particles head when they begin. auto: inward from a ring, else random. aligned: in the start direction, laid onto the surface. radial, inward: away from the start point, or towards it.",
        effect: Effect::Restart,
        kind: word!(particles.start_heading: Heading),
    },
    Parameter {
        key: "particles.start_direction",
        name: "Start direction",
        unit: "",
        help: "For the start heading aligned: a direction in the world, of any length but 0. If it is normal to the surface, headings are random.",
        effect: Effect::Restart,
        kind: vector!(particles.start_direction, (-1.0, 1.0)),
    },
    Parameter {
        key: "areas.map",
        name: "Area map",
        unit: "",
        help: "A PNG laid over the whole texture, as `myxo atlas --out` draws it: on black, green attracts, blue repels, and red may not be entered.",
        effect: Effect::Restart,
        kind: text!(areas.map, "a path relative to the scene file", true),
    },
    Parameter {
        key: "areas.strength",
        name: "Area strength",
        unit: "trail units",
        help: "Added to a sensor's reading where the area map is fully green, and subtracted where it is fully blue.",
        effect: Effect::Restart,
        kind: real!(areas.strength, (0.0, 1e6), (0.0, 1_000.0), Logarithmic),
    },
    Parameter {
        key: "second_look.preset",
        name: "Second look",
        unit: "",
        help: "The built-in preset that particles follow where the second look is painted, or where its map is light. Between, they are mixed.",
        effect: Effect::Live,
        kind: Kind::Choice {
            words: &SECOND_LOOKS,
            get: |s| s.second_look.index(),
            set: |s, i| SECOND_LOOKS[i].clone_into(&mut s.second_look.preset),
        },
    },
    Parameter {
        key: "second_look.map",
        name: "Second look's map",
        unit: "",
        help: "A PNG laid over the whole texture, as `myxo atlas --out` draws it: white for the second look alone, black for the first, grey for both.",
        effect: Effect::Restart,
        kind: text!(second_look.map, "a path relative to the scene file", true),
    },
];

const AFTER: &[Parameter] = &[
    Parameter {
        key: "time.dt",
        name: "Time step",
        unit: "seconds",
        help: "Seconds of the objects' motion that pass in a step. 0 stops them.",
        effect: Effect::Live,
        kind: real!(time.dt, (0.0, 3_600.0), (0.0, 0.1), Linear),
    },
    Parameter {
        key: "time.start",
        name: "Time at the start",
        unit: "seconds",
        help: "Seconds of the objects' motion before the first step.",
        effect: Effect::Restart,
        kind: real!(time.start, (0.0, 1e6), (0.0, 60.0), Linear),
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
        key: "trail.diffusion_length",
        name: "Diffusion length",
        unit: "scene radii",
        help: "How far the trail spreads in a step, as a standard deviation, the same on textures of every size; 4 texels at the most. 0: as the trail diffusion says.",
        effect: Effect::Live,
        kind: real!(trail.diffusion_length, (0.0, 1.0), (0.0, 0.01), Linear),
    },
    Parameter {
        key: "trail.diffusion_distance",
        name: "Diffusion distance",
        unit: "texels",
        help: "How far apart the nine texels of that neighbourhood lie: lines get broader, and from 3 on striped.",
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
        key: "trail.half_life",
        name: "Half-life",
        unit: "steps",
        help: "Steps after which half of the trail remains. 0: as the trail decay says.",
        effect: Effect::Live,
        kind: real!(trail.half_life, (0.0, 1e6), (0.0, 200.0), Linear),
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
        help: "For the method grid: side of the cell that two triangles share. 0 for the largest that fits.",
        effect: Effect::Restart,
        kind: whole!(atlas.cell_size: u32, (0.0, 32_768.0), (0.0, 128.0), Linear),
    },
    Parameter {
        key: "distance.method",
        name: "Distance method",
        unit: "",
        help: "How the nearest triangle of another object is found. bvh: in a tree of boxes. brute: by comparing all, which is slow and serves as a check on the others. raster: by the graphics pipeline, which draws the triangles at their places in the atlas, once for each triangle of the other object, and keeps the nearest by its depth test; for comparison.",
        effect: Effect::Live,
        kind: word!(distance.method: DistanceMethod),
    },
    Parameter {
        key: "distance.depth",
        name: "Distance depth",
        unit: "",
        help: "For raster: how distances become depths. ordered: by the order of their bits, which keeps all but the last two. clip: linear, as in a projection. logistic, arctangent: by these curves. Distances with equal depths are confused: another triangle may then count as the nearest, with its own exact distance.",
        effect: Effect::Live,
        kind: word!(distance.depth: DepthMapping),
    },
    Parameter {
        key: "distance.sign",
        name: "Distance sign",
        unit: "",
        help: "The rule that decides whether a place is inside of an object. pseudonormal: by the normal of the nearest face, edge or vertex. winding: by the winding number, also right where a mesh has holes, and slower. facing: outside if any of equally near faces looks towards the place, which is wrong in creases.",
        effect: Effect::Live,
        kind: word!(distance.sign: SignRule),
    },
    Parameter {
        key: "distance.interval",
        name: "Distance interval",
        unit: "steps",
        help: "Distances are computed at most every so many steps, and only if objects have moved.",
        effect: Effect::Live,
        kind: whole!(distance.interval: u32, (1.0, 1_000.0), (1.0, 60.0), Linear),
    },
    Parameter {
        key: "distance.reach",
        name: "Distance reach",
        unit: "scene radii",
        help: "Distances between objects are clamped beyond this. Larger values take more time.",
        effect: Effect::Live,
        kind: real!(distance.reach, (0.0, 100.0), (0.01, 1.0), Logarithmic),
    },
    Parameter {
        key: "transfer.strategy",
        name: "Transfer strategy",
        unit: "",
        help: "What happens to particles that go into another object. none: they walk on. respawn: they restart at random places of their own object. With the others they change objects, and differ in how the particle buffer is kept in order: scattered: not at all. sequential, parallel: each object has a window of it, kept in order by one invocation or by many. direct: not at all, but for the sort. These four give the same bits.",
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
        help: "How many particles may change objects in a step. If more want to, some stay on their objects, by chance and the same ones in every run, and are counted.",
        effect: Effect::Live,
        kind: whole!(transfer.buffer_size: u32, (1.0, 2_097_152.0), (1_024.0, 1_048_576.0), Logarithmic),
    },
    Parameter {
        key: "feeding.scattered",
        name: "Scattered food",
        unit: "foods",
        help: "How many foods are scattered over all objects, as far apart as can be, besides those with a [[food]] of their own.",
        effect: Effect::Live,
        kind: whole!(feeding.scattered: u32, (0.0, 256.0), (0.0, 64.0), Linear),
    },
    Parameter {
        key: "feeding.radius",
        name: "Food radius",
        unit: "scene radii",
        help: "The distance along the surface up to which sensors read scattered food. Its scent falls off with the square of the remaining distance, to 0 there.",
        effect: Effect::Live,
        kind: real!(feeding.radius, (0.001, 10.0), (0.05, 2.0), Logarithmic),
    },
    Parameter {
        key: "feeding.strength",
        name: "Food strength",
        unit: "trail units",
        help: "Added to a sensor's reading at the place of scattered food. Less than 0 repels.",
        effect: Effect::Live,
        kind: real!(feeding.strength, (-1e6, 1e6), (-100.0, 100.0), Linear),
    },
    Parameter {
        key: "feeding.amount",
        name: "Food amount",
        unit: "meals",
        help: "How many meals each scattered food is: each hungry particle that comes to it takes one, its scent becomes weaker, and in the end it is gone. 0: it never ends.",
        effect: Effect::Live,
        kind: whole!(feeding.amount: u32, (0.0, 60_000_000.0), (0.0, 1e6), Logarithmic),
    },
    Parameter {
        key: "feeding.size",
        name: "Food size",
        unit: "scene radii",
        help: "How far along the surface scattered food is eaten. 0 makes markers of it, which are not eaten.",
        effect: Effect::Live,
        kind: real!(feeding.size, (0.0, 10.0), (0.0, 0.2), Linear),
    },
    Parameter {
        key: "feeding.fed_steps",
        name: "Fed for",
        unit: "steps",
        help: "How long a particle that has eaten is fed. Only hungry ones eat.",
        effect: Effect::Live,
        kind: whole!(feeding.fed_steps: u32, (0.0, 65_535.0), (0.0, 2_000.0), Logarithmic),
    },
    Parameter {
        key: "feeding.fed_deposit",
        name: "Fed deposit",
        unit: "particles",
        help: "How many particles a fed one counts as where it deposits, and for the decrowding weight: where many are fed, the trail is thicker.",
        effect: Effect::Live,
        kind: whole!(feeding.fed_deposit: u32, (1.0, 64.0), (1.0, 16.0), Linear),
    },
    Parameter {
        key: "feeding.fed_attraction",
        name: "Fed attraction",
        unit: "",
        help: "The share of the attraction of food and markers that a fed particle feels: with 0 it follows the trails only, with 1 it is attracted as if it were hungry. Repulsion is always felt.",
        effect: Effect::Live,
        kind: real!(feeding.fed_attraction, (0.0, 1.0), (0.0, 1.0), Linear),
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
        key: "camera.azimuth",
        name: "Azimuth",
        unit: "degrees",
        help: "The direction of the camera about the up axis.",
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
        kind: real!(camera.elevation, (-88.0, 88.0), Linear),
    },
    Parameter {
        key: "camera.distance",
        name: "Distance",
        unit: "scene radii",
        help: "From the camera to what it looks at. 0 for the distance that shows every object whole.",
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
        key: "picture.brightest",
        name: "Brightest trail",
        unit: "trail units",
        help: "Trail that gets the brightest colour. 0 takes it from the trail's own range.",
        effect: Effect::Live,
        kind: real!(picture.brightest, (0.0, 1e9), (0.0, 200.0), Logarithmic),
    },
    Parameter {
        key: "picture.darkest",
        name: "Darkest trail",
        unit: "share of the brightest",
        help: "Up to this share of the brightest trail everything has the darkest colour. 0 shows the faintest haze.",
        effect: Effect::Live,
        kind: real!(picture.darkest, (0.0, 0.99), (0.0, 0.9), Linear),
    },
    Parameter {
        key: "picture.show",
        name: "Show",
        unit: "",
        help: "What pictures show. surface: the lit surface in the trail's colours. relief: the trail raised by light. glow: the trail as the only light. particles: every particle as a point. headings: the same in the hue of its heading. density: particles by area. wireframe: the edges of triangles. charts: the atlas's charts. distance: signed distance to other objects. nearest: which other object is nearest. atlas: the texture, unwrapped.",
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
        key: "picture.light_azimuth",
        name: "Light azimuth",
        unit: "degrees",
        help: "Where the light comes from, seen from the camera: 0 from its side of the scene, 90 from the right, -90 from the left, 180 from behind the scene.",
        effect: Effect::Live,
        kind: real!(picture.light_azimuth, (-180.0, 180.0), Linear),
    },
    Parameter {
        key: "picture.light_elevation",
        name: "Light elevation",
        unit: "degrees",
        help: "How far from above the light comes, seen from the camera.",
        effect: Effect::Live,
        kind: real!(picture.light_elevation, (-90.0, 90.0), Linear),
    },
    Parameter {
        key: "picture.occlusion",
        name: "Ambient occlusion",
        unit: "",
        help: "How much darker places that see little of the sky are: hollows, and places close to another object. 0 is off.",
        effect: Effect::Live,
        kind: real!(picture.occlusion, (0.0, 1.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "picture.bloom",
        name: "Bloom",
        unit: "",
        help: "How strongly bright trail shines beyond its edges. 0 is off.",
        effect: Effect::Live,
        kind: real!(picture.bloom, (0.0, 4.0), (0.0, 2.0), Linear),
    },
    Parameter {
        key: "picture.wetness",
        name: "Wetness",
        unit: "",
        help: "How wet the surface looks: how clearly it reflects the lights, and how high the trail stands on it. 0 is dry and smooth.",
        effect: Effect::Live,
        kind: real!(picture.wetness, (0.0, 1.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "picture.ground",
        name: "Ground",
        unit: "",
        help: "Is the ground under the objects drawn? Their shadow lies on it, soft where they come near.",
        effect: Effect::Live,
        kind: word!(picture.ground: Drawn),
    },
    Parameter {
        key: "picture.food",
        name: "Food",
        unit: "",
        help: "Are food and markers drawn? Food as a dome that shrinks as it is eaten; markers green where they lure and orange where they repel.",
        effect: Effect::Live,
        kind: word!(picture.food: Drawn),
    },
    Parameter {
        key: "picture.areas",
        name: "Painted areas",
        unit: "",
        help: "Are painted areas drawn? Green attracts, violet repels, red stripes are no-go.",
        effect: Effect::Live,
        kind: word!(picture.areas: Drawn),
    },
    Parameter {
        key: "picture.background",
        name: "Background",
        unit: "",
        help: "Colour behind the objects: red, green and blue as the eye sees them (sRGB). The default takes the one that goes with the colour map.",
        effect: Effect::Live,
        kind: vector!(picture.background, (0.0, 1.0)),
    },
];
