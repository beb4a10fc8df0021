//! What the interface shows and cannot change.

use myxo::sim::types::Flow;

use super::checks::Check;
use super::hands::HandFacts;
use super::history::History;
use super::out::OutFacts;

/// A scene that is on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Waiting {
    /// What the user calls it.
    pub name: String,
    /// What is being done.
    pub doing: &'static str,
    /// The share of all that is done, 0 to 1.
    pub done: f32,
    /// The user does not want it any more; it ends as soon as it can.
    pub is_cancelled: bool,
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
    /// Of the step's time, 0 to 1.
    pub share: f64,
}

/// What had grown, and can come back.
#[derive(Clone, Debug, PartialEq)]
pub struct Before {
    /// Of its scene.
    pub name: String,
    /// Steps taken.
    pub step: u64,
}

/// What the interface shows and cannot change.
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
    /// Steps a second, lately.
    pub steps_per_second: f64,
    /// Pictures a second, lately.
    pub frames_per_second: f64,
    /// GPU time of a step; `None` where the device has no timestamps.
    pub step_ms: Option<f64>,
    /// GPU time of each kernel.
    pub kernels: Vec<KernelTime>,
    /// The same for the last frames with steps, one by one.
    pub history: History,
    /// The device's name and driver.
    pub device: String,
    /// Device memory that the program has taken, bytes.
    pub memory: u64,
    /// Particles that the picture shows, in the view of particles.
    pub particles_drawn: u32,
    /// The trail that has the brightest colour, once there is a picture.
    pub brightest: Option<f32>,
    /// Transfers between objects.
    pub flow: Flow,
    /// What the last check of the invariants has found, where they are checked.
    pub check: Option<Check>,
    /// Triangles of all objects.
    pub triangles: usize,
    /// Texels that triangles own.
    pub texels: usize,
    /// Does anything attract, repel or forbid?
    pub has_areas: bool,
    /// What was left and can come back, if anything.
    pub before: Option<Before>,
    /// What is being loaded, if anything is.
    pub loading: Option<Waiting>,
    /// What the hands need to know.
    pub hand: HandFacts,
    /// What is being taken out.
    pub out: OutFacts,
    /// How often the window has answered while steps were under way.
    pub answers_within_steps: u64,
}
