//! What the picture shows: the running simulation, its renderer, and the canvas, drawn again only when it must be.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec2;
use myxo::gpu::{Context, DeviceKind, Format, Image, Readback, Recorder};
use myxo::render::pick::{self, Hit};
use myxo::render::{Canvas, Quality, Renderer, View};
use myxo::scene::Scene;
use myxo::scene::settings::{Show, Strategy};
use myxo::sim::Simulation;
use myxo::sim::types::{Flow, Pose};
use myxo::{Error, Result};

use crate::lab::loading::Loaded;
use crate::lab::marks::RunningMarks;

/// The most particles that a device which is a CPU draws while the simulation runs.
const PARTICLES_ON_CPU: u32 = 60_000;

/// While something is made that needs the device, the window's picture may be so old.
const SHOWN_FOR: Duration = Duration::from_millis(500);

/// Copies of the counters that may be on their way to the host.
const COUNTERS_UNDER_WAY: usize = 4;

/// Of the picture, and of the atlas beside it.
pub type Sizes = ([u32; 2], Option<[u32; 2]>);

/// What pictures depend on: the view, the step, the poses, and the size of the atlas beside.
type Drawn = (View, u64, Vec<Pose>, Option<[u32; 2]>);

/// A scene that grows and is drawn.
pub struct Stage {
    ctx: Arc<Context>,
    /// The scene that runs.
    pub scene: Scene,
    /// The simulation of it.
    pub simulation: Simulation,
    /// What it goes on from, if not from the beginning.
    pub resumed: Option<String>,
    /// Objects that are hidden or locked.
    pub marks: RunningMarks,
    /// What is odd about the scene and was done about it, one sentence each.
    pub remarks: Vec<String>,
    renderer: Renderer,
    format: Format,
    canvas: Option<(Quality, Canvas)>,
    /// For the atlas beside the picture.
    beside: Option<(Quality, Canvas)>,
    /// Particles that the picture has, in the view of particles.
    pub particles_drawn: u32,
    /// How many pictures were drawn: two that are shown are of the same one only if this has not changed.
    pub pictures: u64,
    /// What the canvas shows, if it is still worth showing.
    drawn: Option<Drawn>,
    drawn_at: Instant,
    exposure: Readback<f32>,
    /// The trail that has the brightest colour, as of some frames ago; none before the first picture.
    pub brightest: Option<f32>,
    counters: Readback<Flow>,
    /// Transfers between objects, as of some frames ago.
    pub flow: Flow,
}

impl Stage {
    /// Puts a scene on the device; pictures are of this format, an sRGB one.
    pub fn new(ctx: &Arc<Context>, loaded: Loaded, format: Format) -> Result<Self> {
        let Loaded {
            scene,
            setup,
            prepared,
            from,
            file: _,
        } = loaded;
        let mut simulation = Simulation::from_setup(ctx, &scene, setup)?;
        let resumed = from.map(|(checkpoint, changes)| {
            let snapshot = &checkpoint.snapshot;
            simulation.restore(snapshot)?;
            let changes = changes.iter().map(|change| format!("; {change}"));
            let changes: String = changes.collect();
            Ok::<_, Error>(format!("Going on from step {}{changes}", snapshot.step))
        });
        let resumed = resumed.transpose()?;
        let warnings = [simulation.setup().atlas.warning(), prepared.warning()];
        Ok(Self {
            resumed,
            remarks: oddities(&scene)
                .chain(warnings.into_iter().flatten())
                .collect(),
            renderer: Renderer::from_prepared(ctx, simulation.setup(), &prepared, format)?,
            ctx: Arc::clone(ctx),
            scene,
            simulation,
            format,
            canvas: None,
            beside: None,
            particles_drawn: u32::MAX,
            pictures: 0,
            drawn: None,
            drawn_at: Instant::now(),
            marks: RunningMarks::default(),
            exposure: Readback::new(ctx, "exposure", 1, COUNTERS_UNDER_WAY)?,
            brightest: None,
            counters: Readback::new(ctx, "flow", 1, COUNTERS_UNDER_WAY)?,
            flow: Flow::default(),
        })
    }

    /// Goes on with the canvas of the stage that is left.
    pub fn take_canvas(&mut self, left: Option<Self>) {
        if let Some(left) = left {
            (self.canvas, self.beside) = (left.canvas, left.beside);
            self.pictures = left.pictures;
        }
    }

    /// Records the picture, and the atlas beside it if that has a size, unless the canvases show them already, and gives
    /// them out.
    pub fn draw(
        &mut self,
        rec: &mut Recorder,
        view: &View,
        (size, beside): Sizes,
        is_moving: bool,
    ) -> Result<(&Image, Option<&Image>)> {
        let is_cpu = self.ctx.info().kind == DeviceKind::Cpu;
        let quality = if is_cpu && is_moving {
            Quality::Quick
        } else {
            Quality::Smooth
        };
        let mut view = *view;
        if is_cpu && is_moving {
            view.most_particles = PARTICLES_ON_CPU;
        }
        self.particles_drawn = self.renderer.particles_drawn(&view);
        for (canvas, size) in [(&mut self.canvas, Some(size)), (&mut self.beside, beside)] {
            let has = canvas.as_ref().map(|(has, canvas)| (*has, canvas.size()));
            if has == size.map(|size| (quality, size)) {
                continue;
            }
            self.drawn = None;
            *canvas = None;
            if let Some(size) = size {
                let new = Canvas::with_quality(&self.ctx, size, self.format, quality)?;
                *canvas = Some((quality, new));
            }
        }
        let (_, canvas) = self.canvas.as_ref().expect("made above");
        let beside_canvas = self.beside.as_ref().map(|(_, canvas)| canvas);
        let step = self.simulation.step();
        self.simulation.record_poses(rec);
        let now = Some((view, step, self.simulation.poses().to_vec(), beside));
        if self.drawn != now {
            let mut atlas = view;
            atlas.show = Show::Atlas;
            let pictures = std::iter::once((view, canvas));
            let pictures: Vec<_> = pictures.chain(beside_canvas.map(|c| (atlas, c))).collect();
            self.renderer
                .draw_beside(rec, self.simulation.state(), &pictures);
            (self.renderer).record_brightest(rec, &mut self.exposure, step);
            self.drawn = now;
            self.pictures += 1;
            self.drawn_at = Instant::now();
            let settings = self.simulation.settings();
            if settings.strategy() != Strategy::None {
                let transfers = &self.simulation.state().transfers;
                transfers.record_readback(rec, &mut self.counters, step);
            }
        }
        while let Some((_, brightest)) = self.exposure.poll() {
            self.brightest = brightest.first().copied();
        }
        while let Some((_, counters)) = self.counters.poll() {
            self.flow = counters[0];
        }
        Ok((canvas.image(), beside_canvas.map(Canvas::image)))
    }

    /// What the canvas shows has changed between steps.
    pub fn forget_picture(&mut self) {
        self.drawn = None;
    }

    /// Does the canvas show what this camera and view last saw?
    pub fn has_drawn(&self, view: &View, (size, beside): Sizes) -> bool {
        let fits = |(_, canvas): &(Quality, Canvas)| canvas.size() == size;
        let is_of = |(drawn, _, _, drawn_beside): &Drawn| {
            drawn.camera == view.camera && drawn.show == view.show && *drawn_beside == beside
        };
        self.canvas.as_ref().is_some_and(fits) && self.drawn.as_ref().is_some_and(is_of)
    }

    /// Does the canvas show nearly what it would if it were drawn again? So it does for a while, as long as the camera
    /// stays.
    pub fn shows(&self, view: &View, sizes: Sizes) -> bool {
        self.has_drawn(view, sizes) && self.drawn_at.elapsed() < SHOWN_FOR
    }

    /// What was drawn last; see [`Self::shows`].
    pub fn picture(&self) -> (&Image, Option<&Image>) {
        let (_, canvas) = self.canvas.as_ref().expect("it was drawn");
        let beside = self.beside.as_ref();
        (canvas.image(), beside.map(|(_, canvas)| canvas.image()))
    }

    /// Seconds of the objects' motion, if any moves.
    pub fn seconds(&self) -> Option<f64> {
        let mut objects = self.simulation.settings().objects.iter();
        let any_moves = objects.any(|object| !object.motion.is_still());
        any_moves.then(|| self.simulation.time())
    }

    /// Objects are hidden and locked like this from now on.
    pub fn follow(&mut self, marks: RunningMarks) {
        if self.marks == marks {
            return;
        }
        self.renderer.hide(&marks.hidden);
        let spared = marks.hidden.iter().zip(&marks.locked);
        let spared: Vec<bool> = spared.map(|(hidden, locked)| *hidden || *locked).collect();
        self.simulation.spare(&spared);
        self.marks = marks;
        self.forget_picture();
    }

    /// The surface point under a pixel of a picture of `size`.
    pub fn pick(&self, view: &View, pixel: Vec2, size: Vec2) -> Option<Hit> {
        pick::pick_among(
            &self.scene.surface,
            &self.simulation.world_from_object(),
            |object| !self.marks.is_hidden(object),
            &view.camera.ray(pixel, size),
        )
    }

    /// Records some rows of a picture of its own.
    pub fn draw_rows(
        &mut self,
        rec: &mut Recorder,
        view: &View,
        canvas: &Canvas,
        rows: std::ops::Range<u32>,
    ) {
        self.simulation.record_poses(rec);
        self.renderer
            .draw_rows(rec, self.simulation.state(), view, canvas, rows);
    }
}

/// What is odd about the meshes of a scene, each mesh once.
fn oddities(scene: &Scene) -> impl Iterator<Item = String> {
    let odd = scene.meshes.iter().filter_map(|mesh| {
        let oddities = mesh.report.oddities();
        (!oddities.is_empty()).then(|| format!("{}: {}", mesh.name, oddities.join("; ")))
    });
    let odd = odd.chain(scene.coarse_objects());
    odd.collect::<BTreeSet<String>>().into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::gpu::{ContextOptions, Frames};
    use myxo::mesh::atlas::Control;
    use myxo::render::Prepared;
    use myxo::scene::Overrides;
    use std::path::Path;

    /// Through all strategies and back, between frames that are under way, as the panel does it.
    #[test]
    fn strategies_change_while_it_is_drawn() {
        let ctx = match Context::new(&ContextOptions {
            validation: true,
            ..ContextOptions::default()
        }) {
            Ok(ctx) => ctx,
            Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
                return eprintln!("skipped: {error}");
            }
            Err(error) => panic!("{error}"),
        };
        let set = [
            "particles.count=3000",
            "atlas.size=128",
            "transfer.threshold=0.01",
        ];
        let overrides = Overrides {
            set: set.map(str::to_owned).into(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new("trio"), &overrides).unwrap();
        let view = View::of(&scene, Vec2::new(64.0, 48.0));
        let setup = Simulation::set_up(ctx.info(), &scene, &Control::default()).unwrap();
        let prepared = Prepared::for_quick(&setup);
        let loaded = Loaded {
            scene,
            setup,
            prepared,
            from: None,
            file: None,
        };
        let mut stage = Stage::new(&ctx, loaded, Format::Rgba8Srgb).unwrap();
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let all = Strategy::ALL.iter();
        for &strategy in all.clone().chain(all.rev()) {
            let mut settings = stage.simulation.settings().clone();
            settings.transfer.strategy = strategy;
            stage.simulation.apply(&settings).unwrap();
            for _ in 0..4 {
                let mut rec = frames.begin().unwrap();
                stage.simulation.record_step(&mut rec);
                stage.draw(&mut rec, &view, ([64, 48], None), true).unwrap();
                frames.submit(rec).unwrap();
            }
        }
        frames.wait_idle().unwrap();
        let state = stage.simulation.snapshot().unwrap();
        state.validate(stage.simulation.setup()).unwrap();
        assert_eq!(state.step, 48);
        assert!(stage.flow.arrived > 0, "the panel hears of them");
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
