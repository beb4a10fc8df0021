//! Facts that the interface shows and cannot change.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ColorImage;
use glam::{Affine3A, Vec2, Vec3};
use myxo::plain_text::{counted, with_commas};
use myxo::render::network_lines::{NetworkLines, Sight, Viewpoint};
use myxo::scene::motion::Origins;
use myxo::scene::settings::ColorMap;
use myxo::sim::graph::Measures;
use myxo::sim::types::{Flow, Population};

use crate::lab::history::History;
use crate::lab::job::Progress;

/// A scene that is being loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadingFacts {
    /// Its name in the interface.
    pub name: String,
    /// How far it is.
    pub progress: Progress,
    /// It is the scene that is shown, with other settings or objects.
    pub is_shown: bool,
}

/// One kernel's time.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelTime {
    /// As the shader is called.
    pub name: String,
    /// Dispatches in a step.
    pub per_step: f64,
    /// Mean time in a step, milliseconds.
    pub mean_ms: f64,
    /// 95 % of the steps that have any are not longer.
    pub p95_ms: f64,
    /// The share of the step's time, 0 to 1.
    pub share: f64,
}

/// Recent GPU times of steps and pictures, milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    /// GPU time of a step; `None` if the device has no timestamps.
    pub step_ms: Option<f64>,
    /// The part of it outside kernels: barriers and timestamps.
    pub between_ms: f64,
    /// GPU time of a picture, with the interface.
    pub draw_ms: Option<f64>,
    /// From one picture that is shown to the next, less what the GPU takes for its steps and for itself: the host, and waiting.
    pub host_ms: Option<f64>,
    /// Times of the kernels.
    pub kernels: Vec<KernelTime>,
    /// Times of each kernel in each of the last frames with steps.
    pub history: History,
}

/// A state that was left and can come back.
#[derive(Clone, Debug, PartialEq)]
pub struct Before {
    /// The name of its scene.
    pub name: String,
    /// Steps taken.
    pub step: u64,
}

/// A state that is kept.
#[derive(Clone, Debug)]
pub struct KeptFacts {
    /// No two states of a window share it.
    pub number: u64,
    /// Steps taken.
    pub step: u64,
    /// When it was kept.
    pub since: Instant,
    /// The user has kept it.
    pub by_user: bool,
    /// What it looked like.
    pub picture: Arc<ColorImage>,
}

/// The network of a state, for its lines over the picture.
#[derive(Clone, Debug)]
pub struct NetworkFacts {
    /// The steps that the state had taken.
    pub step: u64,
    /// How often another state had come in the place of the running one until then.
    pub replaced: u64,
    /// Measures of the graph, without those between foods.
    pub measures: Measures,
    /// Its lines and nodes.
    pub lines: NetworkLines,
    /// Finds what the scene's objects hide of them.
    pub sight: Arc<Sight>,
    /// From where it was first found which of their points are visible.
    pub from: Viewpoint,
    /// Which they were.
    pub visible: Vec<bool>,
}

impl NetworkFacts {
    /// The measures as a line of text.
    pub fn text(&self) -> String {
        let Measures {
            nodes,
            edges,
            length,
            cycles,
            ..
        } = self.measures;
        format!(
            "step {}: {}, {} of {length:.2} radii, {}",
            with_commas(self.step as f64),
            counted(nodes, "node", "nodes"),
            counted(edges, "edge", "edges"),
            counted(cycles, "cycle", "cycles")
        )
    }

    /// Step and measures as numbers, for tests.
    pub fn numbers(&self) -> String {
        let Measures {
            nodes,
            edges,
            length,
            cycles,
            ..
        } = self.measures;
        format!("{} {nodes} {edges} {length:.4} {cycles}", self.step)
    }
}

/// Facts that the interface shows and cannot change.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// The scene's name.
    pub scene: String,
    /// The window was asked to fill the screen.
    pub full_screen: bool,
    /// Steps taken.
    pub step: u64,
    /// Seconds of the objects' motion, if any moves.
    pub seconds: Option<f64>,
    /// Steps a second, of the last interval.
    pub steps_per_second: f64,
    /// Pictures a second, of the last interval.
    pub frames_per_second: f64,
    /// Recent times of steps and pictures.
    pub times: Times,
    /// The times that are shown instead of those that come.
    pub frozen: Option<Times>,
    /// The device's name and driver.
    pub device: String,
    /// Does the device measure GPU times?
    pub has_timestamps: bool,
    /// Device memory that the program has taken, bytes.
    pub memory: u64,
    /// Particles that the picture shows, in the view of particles.
    pub particles_drawn: u32,
    /// The trail that has the brightest colour, once there is a picture.
    pub brightest: Option<f32>,
    /// Pixels whose light was not a number.
    pub flaws: u32,
    /// Why pictures of this size have no bloom, if they have none.
    pub undeveloped: Option<String>,
    /// Are pictures drawn plainly, because the device is slow?
    pub is_plain: bool,
    /// Transfers between objects.
    pub flow: Flow,
    /// How many particles are alive, and counters, if their number changes.
    pub population: Option<Population>,
    /// The result of the last check of the invariants, if they are checked.
    pub check: Option<Check>,
    /// Triangles of all objects.
    pub triangles: usize,
    /// Texels that triangles own.
    pub texels: usize,
    /// Does anything attract, repel or forbid?
    pub has_areas: bool,
    /// Why only the colours of looks are previewed; none if the scene runs with them.
    pub only_colors: Option<&'static str>,
    /// The look that is previewed, once the picture has its steps.
    pub steps_of: Option<String>,
    /// States that are kept, the first one first.
    pub kept: Vec<KeptFacts>,
    /// Has any place the second look?
    pub has_looks: bool,
    /// Pulses that have begun and not ended.
    pub pulses: usize,
    /// The state that was left and can come back, if any.
    pub before: Option<Before>,
    /// The scene that is being loaded, if any.
    pub loading: Option<LoadingFacts>,
    /// Facts for the tools.
    pub pointer: PointerFacts,
    /// The network, while its lines are shown and once it is found. None while the scene runs with a look that is previewed.
    pub network: Option<Arc<NetworkFacts>>,
    /// Does the scene run with a look that is previewed?
    pub runs_preview: bool,
    /// Recordings and exports under way.
    pub exports: ExportFacts,
    /// The colours of the picture, if there is one; for tests.
    pub drawn_colors: Option<ColorMap>,
    /// How often the window has answered while steps were under way.
    pub answers_within_steps: u64,
}

impl Facts {
    /// The times that are shown.
    pub fn shown_times(&self) -> &Times {
        self.frozen.as_ref().unwrap_or(&self.times)
    }
}

/// The point under the pointer.
#[derive(Clone, Debug, PartialEq)]
pub struct Under {
    /// The pixel that was asked about.
    pub pixel: Vec2,
    /// Global triangle id.
    pub triangle: u32,
    /// Weights of the corners B and C.
    pub uv: [f32; 2],
    /// Column and row in the atlas.
    pub texel: [u32; 2],
    /// Which object.
    pub object: usize,
    /// In world space, where the picture shows it.
    pub position: Vec3,
    /// In the coordinates of the object that runs.
    pub in_object: Vec3,
    /// Unit normal of the triangle, turned to the eye.
    pub normal: Vec3,
    /// The trail at the texel, when it has come from the device.
    pub trail: Option<f32>,
    /// Signed distance to the other objects, scene radii, when it has come from the device; none with one object.
    pub distance: Option<f32>,
    /// The painted bias that sensors read there, once something was painted, when it has come from the device.
    pub bias: Option<f32>,
}

/// Facts that the window provides to the tools.
#[derive(Clone, Debug, Default)]
pub struct PointerFacts {
    /// The pixel that was looked at last, if any was asked for.
    pub looked: Option<Vec2>,
    /// Under the pointer, if it was asked for and there is something.
    pub under: Option<Under>,
    /// World from object, one an object, as they run.
    pub poses: Vec<Affine3A>,
    /// Origins of coordinates, one an object.
    pub origins: Vec<Origins>,
    /// Positions of handles, relative to these origins, which rotations and scalings keep fixed: the object's own origin, or if
    /// its surface is far from that, the middle of its box.
    pub middles: Vec<Vec3>,
    /// Position in world space and drawn size of each food and marker; scattered ones last.
    pub foods: Vec<(Vec3, f32)>,
    /// Seconds of the objects' motion.
    pub time: f64,
    /// What brushes measure trail by, in trail units: its mean once it grows no more, within bounds.
    pub trail_unit: f32,
    /// Scene radius, world units.
    pub radius: f32,
    /// Reach of signed distances, scene radii.
    pub reach: f32,
}

impl PointerFacts {
    /// The pivot of an object's rotations and scalings, as origins of its coordinates.
    pub fn pivot_of(&self, object: usize) -> Origins {
        let mut origins = self.origins.get(object).copied().unwrap_or_default();
        origins.surface += self.middle_of(object).as_dvec3();
        origins
    }

    /// The position of its handles relative to its origin.
    pub fn middle_of(&self, object: usize) -> Vec3 {
        self.middles.get(object).copied().unwrap_or_default()
    }
}

/// An export under way, for the interface.
#[derive(Clone, Debug, PartialEq)]
pub struct Making {
    /// The file's name.
    pub name: String,
    /// How far it is, in words.
    pub doing: String,
    /// The share that is done, if that is known.
    pub done: Option<f32>,
    /// Would it be whole if it ended now?
    pub can_finish: bool,
    /// The user does not want it any more.
    pub is_cancelled: bool,
}

/// Exports under way, for the interface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportFacts {
    /// A recording under way.
    pub recording: Option<Recorded>,
    /// Anything else.
    pub making: Option<Making>,
    /// The length so far of the film that is being made, seconds.
    pub filmed: Option<f64>,
    /// The window closes when all of it is whole.
    pub ends: bool,
}

/// The progress of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Its length.
    pub seconds: f64,
    /// Frames that it has by now.
    pub frames: u64,
    /// How many of these show another picture than the one before.
    pub different: u64,
    /// Pictures for which there was no time; those before them are shown in their places.
    pub dropped: u64,
    /// It was stopped, and the rest is being written.
    pub is_ending: bool,
}

impl Recorded {
    /// The number of frames that repeat the picture before.
    pub fn repeated(&self) -> u64 {
        self.frames.saturating_sub(self.different)
    }

    /// Is most of it still?
    pub fn is_mostly_repeated(&self) -> bool {
        2 * self.repeated() > self.frames
    }

    /// The remarks behind its name in a notice.
    pub fn remarks(&self) -> String {
        let Self {
            different, dropped, ..
        } = *self;
        let mut text = String::new();
        if dropped > 0 {
            text += &format!("; {dropped} pictures came too fast and were left out");
        }
        let repeated = self.repeated();
        if repeated > 0 {
            text += &format!("; {different} different pictures, {repeated} repeated");
        }
        if self.is_mostly_repeated() {
            text += ". Where the window is slow, Film (Ctrl E) leaves none out";
        }
        text
    }
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The steps that had been taken.
    pub step: u64,
    /// How long it took.
    pub took: Duration,
    /// The share of checks in the time until the next one.
    pub share: f64,
    /// The problem, if any. The first problem stays.
    pub problem: Option<String>,
}
