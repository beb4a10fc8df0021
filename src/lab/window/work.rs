//! Does the work that tools ask of the simulation: dabs of brushes along the way of the pointer, and what lies under it.

use glam::{DVec3, Vec2, Vec3};
use myxo::gpu::Recorder;
use myxo::plain_text::Shown as _;
use myxo::render::camera::Ray;
use myxo::scene::motion::Origins;
use myxo::scene::settings::PulseSettings;
use myxo::sim::paint::{Brush, Dab};
use myxo::sim::pulse::Pulse;
use myxo::sim::{mean_deposit, mean_trail};
use myxo::{Error, Result};

use std::path::{Path, PathBuf};

use super::super::edits::Probe;
use crate::lab::command::{Command, ToolRequest};
use crate::lab::facts::{PointerFacts, Under};
use crate::lab::loading::Origin;
use crate::lab::lost::is_loss;
use crate::lab::saving::{is_mesh, mesh_name};
use crate::lab::tools::food::placed;
use crate::lab::tools::handles::keep_in_place;
use crate::lab::tools::overlay::normal_towards;
use crate::lab::waiting::Waiting;
use crate::lab::window::Lab;
use crate::lab::window::depths::dabs_seen;
use crate::own_presets::preset_in;

/// Dabs of one frame, at the most.
const MOST_DABS: f32 = 6.0;
/// From one dab to the next, as a share of their radius.
const SPACING: f32 = 0.35;
impl Lab {
    /// Does what a tool asks for.
    pub(crate) fn obey_tool(&mut self, work: ToolRequest, size: [u32; 2]) -> Result<()> {
        match work {
            ToolRequest::Stroke {
                from,
                to,
                brush,
                radius,
            } => self.stroke([from, to], brush, radius, size),
            ToolRequest::Pulse { center, pulse } => return self.begin_pulse(center, &pulse),
            ToolRequest::EndStroke => self.end_stroke()?,
            ToolRequest::Undo { again } => {
                let mut commands = Vec::new();
                self.interface.undo_now(again, &mut commands);
                for command in commands {
                    self.obey(command, size)?;
                }
            }
            ToolRequest::ToStroke(last) => self.take_strokes(last)?,
            ToolRequest::StartOnPainted => self.start_on_painted()?,
            // The first would take the place of what is on its way, and the others are about an object that is.
            ToolRequest::Add(..) if self.jobs.loading.is_some() => {
                self.waiting
                    .push(Waiting::Command(Command::Tool(work), size));
            }
            ToolRequest::Remove(which) | ToolRequest::Duplicate(which, _)
                if self.is_to_come(which) =>
            {
                self.waiting
                    .push(Waiting::Command(Command::Tool(work), size));
            }
            ToolRequest::Add(mesh, ticket) => self.add_object(mesh, ticket),
            ToolRequest::Remove(which) => {
                if let Some(object) = self.object(which) {
                    self.remove_object(Box::new(object.clone()));
                }
            }
            ToolRequest::Duplicate(which, ticket) => match self.object(which) {
                Some(object) => self.duplicate_object(Box::new(object.clone()), ticket),
                None => self.interface.tools.answer(ticket, None),
            },
            ToolRequest::Scale(object, factor) => {
                let pointer = &self.clocks.facts.pointer;
                let origins = pointer.pivot_of(object);
                let grown = Origins {
                    surface: f64::from(factor) * origins.surface,
                    ..origins
                };
                if let Some(object) = self.interface.document.edited.objects.get_mut(object) {
                    let before = object.clone();
                    object.scale *= factor;
                    keep_in_place(
                        object,
                        &before,
                        pointer.time,
                        [origins, grown],
                        pointer.radius,
                    );
                    self.interface.document.begin_renewal();
                    self.renew();
                }
            }
            ToolRequest::Renew => self.renew(),
        }
        Ok(())
    }

    /// A file was dropped onto the window, or chosen in it. A load under way is finished first: files that are dropped together
    /// are all opened.
    pub fn drop_file(&mut self, path: PathBuf) {
        self.interface.notices.begin_drop();
        if let Some(folder) = path.parent() {
            self.interface.opening.begin_in(folder);
        }
        self.host.request_redraw();
        let before = self.jobs.loading.as_ref().and_then(|loading| {
            let coming = self.edits.coming.as_ref().map(|coming| &coming.what);
            // The scene that is shown is there already.
            let other = (loading.origin != Origin::Shown).then_some(&loading.name);
            coming.or(other)
        });
        if let Some(before) = before {
            let file = path.file_name().unwrap_or(path.as_os_str());
            let text = format!("{} comes after {before}", Path::new(file).shown());
            self.notify(text, false);
        }
        self.take_file(path);
    }

    /// A mesh that was dropped joins the scene, a preset gives it its look; everything else is opened.
    pub(crate) fn take_file(&mut self, path: PathBuf) {
        let has_to_wait = self.runner.is_within_slices() || self.jobs.loading.is_some();
        if has_to_wait || !self.waiting.is_empty() {
            self.waiting.push(Waiting::File(path));
            self.host.request_redraw();
        } else if is_mesh(&path) && self.runner.stage.is_some() {
            let ticket = self.interface.tools.ask();
            self.add_object(mesh_name(&path), ticket);
        } else if let Some(text) = preset_in(&path) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            self.take_look(&name, &text);
        } else {
            self.open_file(path);
        }
    }

    /// Lists the dabs between two pixels of the picture, from where the surface is seen there.
    fn stroke(&mut self, [from, to]: [Vec2; 2], brush: Brush, radius: f32, size: [u32; 2]) {
        let Some(stage) = &self.runner.stage else {
            return;
        };
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        let view = &self.interface.document.view;
        let eye = view.camera.eye();
        let radius = radius * stage.scene.radius;
        let pixels = stage.pick(view, to, size).map(|hit| {
            let half_height = (0.5 * view.camera.vertical_fov).tan();
            radius / (2.0 * half_height * hit.distance) * size.y
        });
        let spacing = SPACING * pixels.unwrap_or(40.0).max(1.0);
        let count = (from.distance(to) / spacing).ceil().clamp(1.0, MOST_DABS);
        let brush = share_of(brush, count);
        let pixels = (1..=count as u32).map(|i| from.lerp(to, i as f32 / count));
        let middles: Vec<Ray> = pixels.map(|pixel| view.camera.ray(pixel, size)).collect();
        let poses = stage.drawn_poses();
        let dabs = dabs_seen(
            &stage.scene.surface,
            &poses,
            &stage.marks,
            &middles,
            |center| Dab {
                brush,
                center,
                radius,
                eye: Some(eye),
                ring: None,
                number: 0,
            },
        );
        for mut dab in dabs {
            dab.number = self.edits.dab_count;
            self.edits.dab_count = dab.number.wrapping_add(1);
            self.edits.dabs.push(dab);
        }
    }

    /// A pulse begins with the next step.
    fn begin_pulse(&mut self, center: Vec3, pulse: &PulseSettings) -> Result<()> {
        let Some(stage) = &mut self.runner.stage else {
            return Ok(());
        };
        let pulse = Pulse::new(pulse, center, stage.scene.radius);
        let begun = stage.simulation.pulse(&pulse);
        begun.or_else(|error| self.report_unless_lost("no pulse has begun", error))
    }

    /// Records what was painted since it was last called.
    pub(crate) fn record_dabs(&mut self, rec: &mut Recorder) -> Result<()> {
        let dabs = std::mem::take(&mut self.edits.dabs);
        let Some(stage) = &mut self.runner.stage else {
            return Ok(());
        };
        for dab in dabs {
            let strokes = &mut self.edits.strokes;
            if let Some(text) = strokes.before(rec, &stage.simulation, dab.brush) {
                (self.interface.notices).say(self.host.context(), text, false);
            }
            match stage.simulation.paint_on_scaled(rec, &dab, &stage.scales) {
                Ok(painted) => {
                    self.edits.strokes.painted(&painted);
                    match dab.brush {
                        _ if painted.count() == 0 => {}
                        Brush::Trail { .. } | Brush::Erase { .. } => stage.trail_is_painted(),
                        _ => stage.forget_picture(),
                    }
                }
                Err(Error::Invalid(problem)) => {
                    (self.interface.notices).say(self.host.context(), problem, true)
                }
                // Nothing was painted, and the scene continues.
                Err(error) if is_loss(&error) => return Err(error),
                Err(error) => {
                    let text = format!("nothing was painted: {error}");
                    (self.interface.notices).say(self.host.context(), text, true);
                }
            }
        }
        Ok(())
    }

    /// Records what was painted since the last frame, and what the probe wants to know.
    pub(crate) fn record_tools(&mut self, rec: &mut Recorder) -> Result<()> {
        self.record_dabs(rec)?;
        let Some(stage) = &self.runner.stage else {
            return Ok(());
        };
        let Some(under) = self.clocks.facts.pointer.under.as_ref() else {
            return Ok(());
        };
        if self.interface.tools.probe {
            if self.edits.probe.is_none() {
                match Probe::new(&self.runner.ctx) {
                    Ok(probe) => self.edits.probe = Some(probe),
                    Err(error) => {
                        self.interface.tools.probe = false;
                        return self.report_unless_lost("there is no probe", error);
                    }
                }
            }
            if let Some(probe) = &mut self.edits.probe {
                let pitch = stage.simulation.setup().atlas.pitch;
                let [column, row] = under.texel;
                probe.record(rec, stage, (row * pitch + column) as usize);
            }
        }
        Ok(())
    }

    /// Gives the interface what lies under the pointer and where objects are.
    pub(crate) fn look_under_pointer(&mut self, size: [u32; 2]) {
        self.follow_marks();
        let Some(stage) = &self.runner.stage else {
            self.clocks.facts.pointer = PointerFacts::default();
            return;
        };
        let simulation = &stage.simulation;
        self.clocks.facts.has_areas = simulation.state().bias.is_some();
        self.clocks.facts.has_looks = simulation.state().looks.is_some();
        self.clocks.facts.pulses = simulation.pulses().len();
        let (settings, setup) = (simulation.settings(), simulation.setup());
        let begun = settings.particles.count;
        let particles = stage.population.map_or(begun, |now| now.living);
        let trail_unit = trail_unit(
            mean_trail(settings, setup, particles),
            mean_deposit(settings, setup, particles),
        );
        let size = Vec2::new(size[0] as f32, size[1] as f32);
        let view = &self.interface.document.view;
        let (poses, drawn) = (simulation.world_from_object(), stage.drawn_poses());
        let pixel = self.interface.tools.pointer;
        let hit = pixel.and_then(|pixel| Some((pixel, stage.pick(view, pixel, size)?)));
        if let Some(probe) = &mut self.edits.probe {
            while let Some((_, values)) = probe.readback.poll() {
                probe.last = values.try_into().ok();
            }
        }
        let last = self.edits.probe.as_ref().and_then(|probe| probe.last);
        let under = hit.map(|(pixel, hit)| {
            let surface = &setup.surface;
            let object = surface.triangles[hit.triangle as usize].object as usize;
            let corners = surface.corners[hit.triangle as usize]
                .map(|vertex| surface.positions[vertex as usize]);
            let [a, b, c] = corners;
            let corners = corners.map(|corner| drawn[object].transform_point3(corner));
            let texel = setup.atlas.texel_of(hit.triangle, hit.u, hit.v);
            // A value read a little beside is better than none.
            let has_bias = simulation.state().bias.is_some();
            let has_distance = settings.objects.len() > 1;
            Under {
                pixel,
                triangle: hit.triangle,
                uv: [hit.u, hit.v],
                texel: [texel % setup.atlas.pitch, texel / setup.atlas.pitch],
                object,
                position: hit.position,
                in_object: a + hit.u * (b - a) + hit.v * (c - a),
                normal: normal_towards(corners, view.camera.eye()),
                trail: last.map(|[trail, ..]| trail),
                distance: last
                    .filter(|_| has_distance)
                    .map(|[_, distance, _]| distance / setup.radius),
                bias: last.filter(|_| has_bias).map(|[.., bias]| bias),
            }
        });
        self.clocks.facts.pointer = PointerFacts {
            looked: pixel,
            under,
            foods: placed(
                &self.interface.document.edited,
                settings,
                &setup.food_set.marks,
                &setup.origins,
                &drawn,
                setup.radius,
            ),
            poses,
            origins: setup.origins.clone(),
            middles: (setup.origins.iter().zip(&setup.distance.trees.objects))
                .map(|(origins, tree)| match origins.surface == DVec3::ZERO {
                    true => Vec3::ZERO,
                    false => tree.low.midpoint(tree.high),
                })
                .collect(),
            time: simulation.time(),
            trail_unit,
            radius: setup.radius,
            reach: settings.distance.reach,
        };
    }
}

/// What brushes measure trail by: its mean, but at least what is left in a step, and at most what is left in a thousand. Trail that is gone
/// at once has a mean of nothing, and trail that lasts one that it would not come to for long.
fn trail_unit(mean: f64, deposit: f64) -> f32 {
    let within = mean.max(deposit).min(1000.0 * deposit);
    (within as f32).clamp(1e-3, 1e4)
}

/// One of `count` dabs that together do what one would.
fn share_of(brush: Brush, count: f32) -> Brush {
    let part = |share: f32| 1.0 - (1.0 - share).max(0.0).powf(1.0 / count);
    match brush {
        Brush::Trail { amount } => Brush::Trail {
            amount: amount / count,
        },
        Brush::Attract { amount } => Brush::Attract {
            amount: amount / count,
        },
        Brush::Erase { share } => Brush::Erase { share: part(share) },
        Brush::Particles { share } => Brush::Particles { share: part(share) },
        Brush::Look { amount } => Brush::Look {
            amount: amount / count,
        },
        Brush::NoGo => Brush::NoGo,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: brushes without effect where trail is gone at once, and one dab that covers all where nothing decays.
    #[test]
    fn brushes_measure_by_a_mean_within_bounds() {
        for (mean, deposit, unit) in [
            (6.0, 2.0, 6.0),
            (0.0, 2.0, 2.0),
            (f64::INFINITY, 2.0, 2000.0),
            (f64::INFINITY, 200.0, 1e4),
            (0.0, 0.0, 1e-3),
        ] {
            assert_eq!(trail_unit(mean, deposit), unit, "{mean}, {deposit}");
        }
    }

    #[test]
    fn dabs_of_a_stroke_do_together_what_one_would() {
        let Brush::Trail { amount } = share_of(Brush::Trail { amount: 6.0 }, 4.0) else {
            panic!("another brush")
        };
        assert_eq!(amount, 1.5);
        let Brush::Erase { share } = share_of(Brush::Erase { share: 0.5 }, 3.0) else {
            panic!("another brush")
        };
        assert!(((1.0 - share).powi(3) - 0.5).abs() < 1e-6);
        assert_eq!(share_of(Brush::NoGo, 5.0), Brush::NoGo);
    }
}
