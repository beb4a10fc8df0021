//! What the picture shows: the running simulation, its renderer, and the canvas, drawn again only when it must be.

use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use glam::Vec2;
use image::RgbaImage;
use myxo::Result;
use myxo::gpu::{
    Access, Buffer, Context, DeviceKind, Domain, Format, Frames, Image, Readback, Recorder,
};
use myxo::mesh::atlas::Control;
use myxo::render::output::Output;
use myxo::render::pick::{self, Hit};
use myxo::render::{Canvas, Quality, Renderer, View};
use myxo::scene::Scene;
use myxo::scene::settings::{Settings, Strategy};
use myxo::sim::Simulation;
use myxo::sim::types::{Flow, Pose};

/// The most particles that a device which is a CPU draws while the simulation runs.
const PARTICLES_ON_CPU: u32 = 60_000;

/// How often it is told how far the setting up of a scene is.
const TELL_EVERY: Duration = Duration::from_millis(100);

/// Copies of the counters that may be on their way to the host.
const COUNTERS_UNDER_WAY: usize = 4;

/// Shows how far the setting up of a scene is: what is being done, and the share of all that is done.
pub type Tell<'a> = &'a mut dyn FnMut(&'static str, f32) -> Result<()>;

/// A scene that grows and is drawn.
pub struct Stage {
    ctx: Arc<Context>,
    /// The scene that runs.
    pub scene: Scene,
    /// The simulation of it.
    pub simulation: Simulation,
    renderer: Renderer,
    format: Format,
    /// Where layouts are kept that take long to make.
    atlases: Option<PathBuf>,
    canvas: Option<(Quality, Canvas)>,
    /// Particles that the picture has, in the view of particles.
    pub particles_drawn: u32,
    /// What the canvas shows, if it is still worth showing.
    drawn: Option<(View, u64, Vec<Pose>)>,
    counters: Readback<Flow>,
    /// Transfers between objects, as of some frames ago.
    pub flow: Flow,
}

impl Stage {
    /// Sets a scene up; pictures are of this format, an sRGB one.
    pub fn new(
        ctx: &Arc<Context>,
        scene: Scene,
        format: Format,
        atlases: Option<PathBuf>,
        tell: Tell<'_>,
    ) -> Result<Self> {
        let simulation = set_up(ctx, &scene, atlases.as_deref(), tell)?;
        Ok(Self {
            renderer: Renderer::new(ctx, simulation.setup(), format)?,
            ctx: Arc::clone(ctx),
            scene,
            simulation,
            format,
            atlases,
            canvas: None,
            particles_drawn: u32::MAX,
            drawn: None,
            counters: Readback::new(ctx, "flow", 1, COUNTERS_UNDER_WAY)?,
            flow: Flow::default(),
        })
    }

    /// Begins again with these settings. If that fails, what runs goes on.
    pub fn restart(&mut self, settings: &Settings, tell: Tell<'_>) -> Result<()> {
        let scene = &self.scene;
        let same_meshes = scene.settings.objects.len() == settings.objects.len()
            && scene
                .settings
                .objects
                .iter()
                .zip(&settings.objects)
                .all(|(a, b)| a.mesh == b.mesh);
        let (name, settings, folder) = (scene.name.clone(), settings.clone(), scene.folder.clone());
        let scene = if same_meshes {
            Scene::from_meshes(name, settings, scene.meshes.clone(), folder)?
        } else {
            Scene::from_settings(name, settings, folder)?
        };
        self.show(scene, tell)
    }

    /// Shows another scene. If that fails, what runs goes on.
    pub fn show(&mut self, scene: Scene, tell: Tell<'_>) -> Result<()> {
        let canvas = self.canvas.take();
        let atlases = self.atlases.clone();
        match Self::new(&self.ctx, scene, self.format, atlases, tell) {
            Ok(stage) => *self = Self { canvas, ..stage },
            Err(error) => {
                self.canvas = canvas;
                return Err(error);
            }
        }
        Ok(())
    }

    /// Records the picture, unless the canvas shows it already, and gives it out.
    pub fn draw(
        &mut self,
        rec: &mut Recorder,
        view: &View,
        size: [u32; 2],
        is_moving: bool,
    ) -> Result<&Image> {
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
        let fits = |(has, canvas): &(Quality, Canvas)| *has == quality && canvas.size() == size;
        if !self.canvas.as_ref().is_some_and(fits) {
            self.drawn = None;
            self.canvas = None;
            self.canvas = Some((
                quality,
                Canvas::with_quality(&self.ctx, size, self.format, quality)?,
            ));
        }
        let (_, canvas) = self.canvas.as_ref().expect("made above");
        let step = self.simulation.step();
        self.simulation.record_poses(rec);
        let now = Some((view, step, self.simulation.poses().to_vec()));
        if self.drawn != now {
            self.renderer
                .draw(rec, self.simulation.state(), &view, canvas);
            self.drawn = now;
            let settings = self.simulation.settings();
            if settings.strategy() != Strategy::None {
                let transfers = &self.simulation.state().transfers;
                transfers.record_readback(rec, &mut self.counters, step);
            }
        }
        while let Some((_, counters)) = self.counters.poll() {
            self.flow = counters[0];
        }
        Ok(canvas.image())
    }

    /// Seconds of the objects' motion, if any moves.
    pub fn seconds(&self) -> Option<f64> {
        let mut objects = self.simulation.settings().objects.iter();
        let any_moves = objects.any(|object| !object.motion.is_still());
        any_moves.then(|| self.simulation.time())
    }

    /// The surface point under a pixel of a picture of `size`.
    pub fn pick(&self, view: &View, pixel: Vec2, size: Vec2) -> Option<Hit> {
        pick::pick(
            &self.scene.surface,
            &self.simulation.world_from_object(),
            &view.camera.ray(pixel, size),
        )
    }

    /// Draws the picture with smooth edges and every particle, waits for it, and reads it.
    pub fn photograph(
        &mut self,
        frames: &mut Frames,
        view: &View,
        size: [u32; 2],
    ) -> Result<RgbaImage> {
        let canvas = Canvas::new(&self.ctx, size, self.format)?;
        let pixels = Buffer::<[u8; 4]>::new(
            &self.ctx,
            "screenshot",
            size[0] as usize * size[1] as usize,
            Domain::Readback,
        )?;
        let mut rec = frames.begin()?;
        self.simulation.record_poses(&mut rec);
        self.renderer
            .draw(&mut rec, self.simulation.state(), view, &canvas);
        rec.copy_image(canvas.image(), &pixels);
        rec.barrier(Access::Copy, Access::Readback, &[&pixels]);
        frames.submit(rec)?;
        frames.wait_idle()?;
        let mut bytes: Vec<u8> = pixels.as_slice().as_flattened().to_vec();
        if self.format == Format::Bgra8Srgb {
            bytes.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
        }
        Ok(RgbaImage::from_raw(size[0], size[1], bytes).expect("a pixel for each of the canvas"))
    }
}

/// Sets a simulation up on another thread, and tells from this one how far it is.
fn set_up(
    ctx: &Arc<Context>,
    scene: &Scene,
    atlases: Option<&Path>,
    tell: Tell<'_>,
) -> Result<Simulation> {
    let told = Mutex::new(("setting up", 0.0));
    let told = || told.lock().unwrap_or_else(PoisonError::into_inner);
    let cancelled = AtomicBool::new(false);
    let setup = thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let control = Control {
                progress: Some(&|doing, done| *told() = (doing, done)),
                cancelled: Some(&cancelled),
                cache: atlases,
            };
            Simulation::set_up(ctx.info(), scene, &control)
        });
        let mut last = Instant::now();
        while !worker.is_finished() {
            thread::sleep(Duration::from_millis(1));
            if last.elapsed() >= TELL_EVERY {
                let (doing, done) = *told();
                if let Err(error) = tell(doing, done) {
                    cancelled.store(true, Ordering::Relaxed);
                    return Err(error);
                }
                last = Instant::now();
            }
        }
        worker.join().unwrap_or_else(|panic| resume_unwind(panic))
    })?;
    Simulation::from_setup(ctx, scene, setup)
}

/// Saves a picture as `screenshot_000001.png`, or under the next number that is free, and says where.
pub fn save_screenshot(folder: &Path, picture: &RgbaImage) -> Result<PathBuf> {
    let path = (1..)
        .map(|number| folder.join(format!("screenshot_{number:06}.png")))
        .find(|path| !path.exists())
        .expect("numbers do not end");
    let mut file = Output::create(&path, picture.dimensions(), 1.0)?;
    file.frame(picture)?;
    file.finish()?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::gpu::ContextOptions;
    use myxo::scene::Overrides;

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
        let mut stage =
            Stage::new(&ctx, scene, Format::Rgba8Srgb, None, &mut |_, _| Ok(())).unwrap();
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let all = Strategy::ALL.iter();
        for &strategy in all.clone().chain(all.rev()) {
            let mut settings = stage.simulation.settings().clone();
            settings.transfer.strategy = strategy;
            stage.simulation.apply(&settings).unwrap();
            for _ in 0..4 {
                let mut rec = frames.begin().unwrap();
                stage.simulation.record_step(&mut rec);
                stage.draw(&mut rec, &view, [64, 48], true).unwrap();
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

    #[test]
    fn screenshots_are_numbered_and_nothing_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let picture = RgbaImage::from_pixel(3, 2, image::Rgba([9, 8, 7, 255]));
        let names: Vec<_> = (0..2)
            .map(|_| save_screenshot(folder.path(), &picture).unwrap())
            .map(|path| path.file_name().unwrap().to_owned())
            .collect();
        assert_eq!(names, ["screenshot_000001.png", "screenshot_000002.png"]);
        let read = image::open(folder.path().join("screenshot_000002.png"))
            .unwrap()
            .into_rgba8();
        assert_eq!(read, picture);
        let no_folder = folder.path().join("screenshot_000002.png");
        let error = save_screenshot(&no_folder, &picture).unwrap_err();
        assert!(
            error.to_string().contains("screenshot_000001.png"),
            "{error}"
        );
    }
}
