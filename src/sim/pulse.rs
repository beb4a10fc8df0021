//! Pulses: waves that sweep particles along. A pulse is a shell in world space whose radius grows with the steps, so it passes
//! seams, and goes from object to object. Twin of `shaders/include/shells.glsl`.
//!
//! In the shell headings turn away from its centre, and steps become longer, up to the speed of the shell. Particles that are
//! carried stay in the shell for longer, which makes it a bright front. Pulses are on the host; each step has them as shells.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use super::ground::{Frame, place_in_object};
use super::types::{Pose, Shell};
use crate::error::{Error, Result};
use crate::mesh::surface::Triangle;
use crate::scene::settings::PulseSettings;
use crate::strict::{direction2_or, direction3_or, dot2, dot3, length3, positive, root};

/// Pulses that are live at once; one more takes the place of the oldest.
pub const MOST_PULSES: usize = 8;
/// The longest speed, width and reach of a pulse that begins, scene radii.
const FARTHEST: f32 = 1000.0;
/// The share of its reach over which a pulse becomes weaker, until it ends.
const FADING: f64 = 0.3;
/// Where the back of a shell begins, half widths from its middle.
const BACK: f32 = -0.25;
/// Narrower shells would pass particles between two steps, world lengths.
const LEAST_WIDTH: f64 = 1e-30;

/// A pulse that begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// The middle of its shell, in world space.
    pub center: Vec3,
    /// World length by which the shell grows in a step. Lengths in scene files times the radius of the [`Setup`](super::Setup) are
    /// world lengths.
    pub speed: f32,
    /// Thickness of the shell, a world length.
    pub width: f32,
    /// The shell's radius at which it has ended, a world length.
    pub reach: f32,
    /// How far particles in the shell turn, and how much of its speed they take, 0 to 1.
    pub strength: f32,
}

/// A pulse that has begun, as snapshots and checkpoints hold it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LivePulse {
    /// As in [`Pulse`].
    pub center: [f32; 3],
    /// As in [`Pulse`].
    pub speed: f32,
    /// As in [`Pulse`].
    pub width: f32,
    /// As in [`Pulse`].
    pub reach: f32,
    /// As in [`Pulse`].
    pub strength: f32,
    /// Nothing.
    pub pad0: u32,
    /// The number of its first step.
    pub first_step: u64,
}

impl Pulse {
    /// The pulse of these settings, about this place of the world.
    #[must_use]
    pub fn new(settings: &PulseSettings, center: Vec3, scene_radius: f32) -> Self {
        Self {
            center,
            speed: settings.speed * scene_radius,
            width: settings.width * scene_radius,
            reach: settings.reach * scene_radius,
            strength: settings.strength,
        }
    }

    /// Makes sure that the numbers are in their ranges, in a scene of this radius.
    ///
    /// # Errors
    /// Names the first that is not, and its range.
    pub fn check(&self, scene_radius: f32) -> Result<()> {
        if !self.center.is_finite() {
            return Err(Error::Invalid(
                "a pulse must begin at a finite place".to_owned(),
            ));
        }
        let lengths = [
            ("a speed", self.speed),
            ("a width", self.width),
            ("a reach", self.reach),
        ];
        for (what, value) in lengths {
            let radii = value / scene_radius;
            if !(value.is_normal() && value > 0.0 && radii <= FARTHEST) {
                return Err(Error::Invalid(format!(
                    "a pulse cannot have {what} of {radii} scene radii: choose one above 0, up to {FARTHEST}"
                )));
            }
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(Error::Invalid(format!(
                "a pulse cannot have a strength of {}: choose 0 to 1",
                self.strength
            )));
        }
        Ok(())
    }

    /// The pulse once it has begun.
    #[must_use]
    pub fn beginning_at(&self, first_step: u64) -> LivePulse {
        LivePulse {
            center: self.center.to_array(),
            speed: self.speed,
            width: self.width,
            reach: self.reach,
            strength: self.strength,
            pad0: 0,
            first_step,
        }
    }
}

impl LivePulse {
    /// What has begun.
    #[must_use]
    pub fn pulse(&self) -> Pulse {
        Pulse {
            center: Vec3::from_array(self.center),
            speed: self.speed,
            width: self.width,
            reach: self.reach,
            strength: self.strength,
        }
    }

    /// Radius of the middle of its shell in a step.
    fn radius_in(&self, step: u64) -> f64 {
        step.saturating_sub(self.first_step) as f64 * f64::from(self.speed)
    }

    /// Has it passed its reach before a step?
    #[must_use]
    pub fn has_ended(&self, step: u64) -> bool {
        self.radius_in(step) >= f64::from(self.reach)
    }

    /// Its shell in a step.
    #[must_use]
    pub fn shell_in(&self, step: u64) -> Shell {
        let (radius, reach) = (self.radius_in(step), f64::from(self.reach));
        let left = ((reach - radius) / (FADING * reach)).clamp(0.0, 1.0);
        let half_width = (0.5 * f64::from(self.width)).max(LEAST_WIDTH);
        Shell {
            center: Vec3::from_array(self.center),
            radius: radius as f32,
            narrow: (1.0 / half_width) as f32,
            strength: (f64::from(self.strength) * left) as f32,
            speed: self.speed,
            pad0: 0.0,
        }
    }
}

/// A particle's heading, and the length of its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// In the triangle's tangent frame.
    pub heading: Vec2,
    /// A world length.
    pub length: f32,
}

/// Turns a particle and lengthens its step in each shell that it is in. `corners` are those of its triangle, in object space.
#[must_use]
pub fn swept(
    shells: &[Shell],
    (shape, corners): (&Triangle, [Vec3; 3]),
    pose: &Pose,
    [u, v]: [f32; 2],
    mut sweep: Sweep,
) -> Sweep {
    let frame = Frame::of(corners);
    let place = frame.position(shape, [u, v]);
    for shell in shells {
        let away = place - place_in_object(pose, shell.center);
        let x = (length3(away) - shell.radius) * shell.narrow;
        let inside = positive(1.0 - x * x);
        let weight = shell.strength * (inside * inside);
        if weight <= 0.0 {
            continue;
        }
        // At the back of the shell particles turn round.
        let is_behind = x < BACK;
        // Shorter where the surface lies across.
        let outward = direction3_or(away, Vec3::ZERO);
        let flat = Vec2::new(dot3(outward, frame.p), dot3(outward, frame.h));
        let target = if is_behind { -flat } else { flat };
        let turned = sweep.heading + weight * (target - sweep.heading);
        sweep.heading = direction2_or(turned, sweep.heading);
        if is_behind {
            continue;
        }
        let more = positive(shell.speed - sweep.length) * root(dot2(flat, flat));
        sweep.length += weight * more;
    }
    sweep
}
