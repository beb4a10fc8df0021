//! The stage: the running simulation, its renderer, and the canvas, which is drawn again only when it must be.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{Affine3A, Vec2, Vec3};
use myxo::gpu::{Context, DeviceKind, Format, GpuError, Image, Readback, Recorder};
use myxo::render::exposure::Exposure;
use myxo::render::mean::{self, Mean};
use myxo::render::network_lines::Viewpoint;
use myxo::render::pick::{self, Hit};
use myxo::render::{Camera, Canvas, Prepared, Quality, Renderer, View};
use myxo::scene::Scene;
use myxo::scene::settings::{ColorMap, Show, Strategy};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::types::{Flow, Population, Pose};
use myxo::sim::{Setup, Simulation};
use myxo::{Error, Result};

use crate::lab::marks::RunningMarks;

/// The most particles that a device which is a CPU draws while the simulation runs.
const PARTICLES_ON_CPU: u32 = 60_000;

/// While something is made that needs the device, the window's picture may be so old.
const SHOWN_FOR: Duration = Duration::from_millis(500);

/// If pictures take longer than this, in milliseconds, those of moving things are drawn plainly, and fully again once plain ones take less
/// than the other.
const PLAIN_ABOVE: f64 = 80.0;
const FULL_BELOW: f64 = 35.0;

/// A picture stands in for one that is wider or narrower by this many pixels at the most.
const MOST_BESIDE: u32 = 1024;

/// Bands of a picture that is drawn in slices. More would be quicker each, and slower together: each goes over all triangles.
const BANDS: u32 = 3;

/// An exposure that changes by less than this share from one picture to the next has settled.
const SETTLED: f32 = 1e-3;

/// Copies of the counters that may be on their way to the host.
const COUNTERS_UNDER_WAY: usize = 4;

/// Sizes of the picture and of the atlas beside it.
pub type Sizes = ([u32; 2], Option<[u32; 2]>);

/// The inputs of a picture.
#[derive(Clone, Debug, PartialEq)]
struct Drawn {
    view: View,
    step: u64,
    /// One an object.
    poses: Vec<Pose>,
    /// The size of the atlas beside it, if that is shown.
    beside: Option<[u32; 2]>,
}

/// How a picture was taken, for what is drawn over it.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureView {
    /// By this camera.
    pub camera: Camera,
    /// Its size, pixels.
    pub size: [u32; 2],
    /// From where, and of which poses.
    pub from: Viewpoint,
}

/// What an automatic exposure depends on: the step, and the share of the trail that may be clipped.
type Exposed = (u64, f32);

/// All of a scene that is made without a device.
pub struct Loaded {
    /// With its meshes.
    pub scene: Scene,
    /// Atlas, particles, tables.
    pub setup: Setup,
    /// Its data for pictures.
    pub prepared: Prepared,
    /// The state that it continues from, and the differences since.
    pub from: Option<(Arc<Checkpoint>, Vec<String>)>,
}

/// A scene that grows and is drawn.
pub struct Stage {
    ctx: Arc<Context>,
    /// The scene that runs.
    pub scene: Scene,
    /// The simulation of it.
    pub simulation: Simulation,
    /// The name of the state that it continues from, if it does not start at step 0.
    pub resumed: Option<String>,
    /// Objects that are hidden or locked.
    pub marks: RunningMarks,
    /// Remarks on oddities of the scene and their remedies, one sentence each.
    pub remarks: Vec<String>,
    /// How many times as large as it is each object is drawn, while a layout for that is on its way; empty where none is.
    pub scales: Vec<f32>,
    renderer: Renderer,
    format: Format,
    /// The canvases that the window shows.
    shown: Canvases,
    /// The canvases of the next picture, if it is drawn in slices.
    next: Canvases,
    /// Particles that the picture has, in the view of particles.
    pub particles_drawn: u32,
    /// The number of pictures drawn: the canvas is unchanged only if this number is.
    pub pictures: u64,
    /// The inputs of the picture on the canvases, if it is still worth showing.
    drawn: Option<Drawn>,
    /// The inputs of the next picture.
    coming: Option<Drawn>,
    /// How the pictures on the canvases were taken, on those that are shown and on those of the next picture; none of the flat atlas.
    picture_view: Option<PictureView>,
    next_picture_view: Option<PictureView>,
    /// The colours in which the canvases show the trail, also when their contents have changed since; none if other contents have to come
    /// at once.
    colors: Option<ColorMap>,
    /// The mean that the picture is, and the number of the picture that it was last.
    refined: Option<(Mean, u64)>,
    /// A size of pictures for whose mean there was no memory.
    not_refined: Option<[u32; 2]>,
    /// How often the contents of pictures have changed between steps.
    pub changes: u64,
    /// How often the trail was painted between steps.
    pub painted: u64,
    /// How often another state has taken the place of the one that ran.
    pub replaced: u64,
    /// Was the last picture one of moving things?
    pub drew_moving: bool,
    drawn_at: Instant,
    exposure: Readback<f32>,
    /// The trail that has the brightest colour, as of some frames ago; none before the first picture.
    pub brightest: Option<f32>,
    /// What the automatic exposure of the last picture depended on, and the number of the first picture that had this.
    exposed: Option<Exposed>,
    exposed_since: u64,
    /// What the exposure has settled for: it would change nothing more.
    settled: Option<Exposed>,
    /// Pictures that were recorded.
    recorded: u64,
    counters: Readback<Flow>,
    /// Transfers between objects, as of some frames ago.
    pub flow: Flow,
    population_counter: Readback<Population>,
    /// How many particles are alive, and counters, if their number changes; as of some frames ago.
    pub population: Option<Population>,
    flaw_counter: Readback<u32>,
    /// Pixels so far whose light was not a number, as of some frames ago.
    pub flaws: u32,
    /// Are pictures drawn plainly while something moves, because they take long?
    pub is_plain: bool,
    /// How long a full picture took when plain ones began, ms.
    full_ms: f64,
}

impl Stage {
    /// Puts a scene on the device; pictures are of this format, an sRGB one.
    pub fn new(ctx: &Arc<Context>, loaded: Loaded, format: Format) -> Result<Self> {
        let Loaded {
            scene,
            setup,
            prepared,
            from,
        } = loaded;
        let mut simulation = Simulation::from_setup(ctx, &scene, setup)?;
        let resumed = from.map(|(checkpoint, changes)| {
            let snapshot = &checkpoint.snapshot;
            simulation.restore(snapshot)?;
            let changes = changes.iter().map(|change| format!("; {change}"));
            let changes: String = changes.collect();
            Ok::<_, Error>(format!("Continues from step {}{changes}", snapshot.step))
        });
        let resumed = resumed.transpose()?;
        let warnings = [simulation.setup().atlas.warning(), prepared.warning()];
        Ok(Self {
            resumed,
            remarks: oddities(&scene)
                .chain(warnings.into_iter().flatten())
                .chain(simulation.setup().diffusion_warnings(&scene.settings))
                .collect(),
            renderer: Renderer::from_prepared(ctx, simulation.setup(), &prepared, format)?,
            scales: Vec::new(),
            ctx: Arc::clone(ctx),
            scene,
            simulation,
            format,
            shown: Canvases::default(),
            next: Canvases::default(),
            particles_drawn: u32::MAX,
            pictures: 0,
            drawn: None,
            coming: None,
            picture_view: None,
            next_picture_view: None,
            colors: None,
            refined: None,
            not_refined: None,
            changes: 0,
            painted: 0,
            replaced: 0,
            drew_moving: false,
            drawn_at: Instant::now(),
            marks: RunningMarks::default(),
            exposure: Readback::new(ctx, "exposure", 1, COUNTERS_UNDER_WAY)?,
            brightest: None,
            exposed: None,
            exposed_since: 0,
            settled: None,
            recorded: 0,
            counters: Readback::new(ctx, "flow", 1, COUNTERS_UNDER_WAY)?,
            flow: Flow::default(),
            population_counter: Readback::new(ctx, "living", 1, COUNTERS_UNDER_WAY)?,
            population: None,
            flaw_counter: Readback::new(ctx, "flaws", 1, COUNTERS_UNDER_WAY)?,
            flaws: 0,
            is_plain: false,
            full_ms: 0.0,
        })
    }

    /// Takes over the canvases of the old stage.
    pub fn take_canvases(&mut self, left: Option<Self>) {
        if let Some(left) = left {
            (self.shown, self.next) = (left.shown, left.next);
            (self.pictures, self.colors) = (left.pictures, left.colors);
        }
    }

    /// Records the picture, and the atlas beside it if that has a size, unless the canvases show them already, and gives
    /// them out.
    pub fn draw(
        &mut self,
        rec: &mut Recorder,
        view: &View,
        sizes: Sizes,
        is_moving: bool,
    ) -> Result<(&Image, Option<&Image>)> {
        let (quality, now) = self.next_picture(view, sizes, is_moving);
        if (self.shown).fit((&self.ctx, self.format), quality, sizes)? {
            self.drawn = None;
        }
        if self.drawn.as_ref() != Some(&now) {
            self.forget_mean_of(&now);
            self.drew_moving = is_moving;
            self.record(rec, &now, 1);
            self.colors = Some(now.view.color_map);
            self.picture_view = self.view_of_picture(view, sizes);
            self.drawn = Some(now);
            self.pictures += 1;
            self.drawn_at = Instant::now();
        }
        self.read_back();
        Ok(self.picture())
    }

    /// Frees the memory of a mean when steps go on.
    fn forget_mean_of(&mut self, now: &Drawn) {
        if (self.drawn.as_ref()).is_some_and(|drawn| drawn.step != now.step) {
            self.refined = None;
        }
    }

    /// Do the canvases show this already?
    pub fn has_picture(&self, view: &View, sizes: Sizes, is_moving: bool) -> bool {
        let (quality, now) = self.next_picture(view, sizes, is_moving);
        self.drawn.as_ref() == Some(&now) && self.shown.fits(quality, sizes)
    }

    /// Would a resting picture be smoother for another one?
    pub fn can_refine(&self) -> bool {
        let (Some(drawn), Some((_, canvas))) = (&self.drawn, &self.shown.picture) else {
            return false;
        };
        let is_possible = !drawn.view.show.is_flat() && self.not_refined != Some(canvas.size());
        is_possible && self.refined_count() < mean::FINE
    }

    /// Of how many pictures the picture is the mean.
    pub fn refined_count(&self) -> u32 {
        match &self.refined {
            Some((mean, number)) if *number == self.pictures => mean.count(),
            _ => 1,
        }
    }

    /// Records another picture, a part of a pixel beside the one that is shown, and makes that the mean of all so far. Leaves it where
    /// there is no memory for that.
    pub fn refine(&mut self, rec: &mut Recorder) {
        let Some(mut drawn) = self.drawn.clone().filter(|_| self.can_refine()) else {
            return;
        };
        let count = self.refined_count();
        let (canvas, _) = self.shown.canvases();
        let size = canvas.size();
        let kept = self.refined.take().map(|(mean, _)| mean);
        let kept = kept.filter(|mean| mean.size() == size);
        let Some(mut mean) = kept.or_else(|| Mean::new(&self.ctx, size).ok()) else {
            self.not_refined = Some(size);
            return;
        };
        if count == 1 {
            mean.restart();
            mean.record(rec, canvas.image());
        }
        drawn.view.camera = mean::within_pixel(&drawn.view.camera, size, count);
        if let Exposure::Auto { adaptation, .. } = &mut drawn.view.exposure {
            *adaptation = 0.0;
        }
        drawn.beside = None;
        self.drew_moving = false;
        self.record(rec, &drawn, 1);
        mean.record(rec, self.shown.canvases().0.image());
        self.pictures += 1;
        self.refined = Some((mean, self.pictures));
    }

    /// Records the picture in slices of the recording, beside what is shown, which stays until [`Self::show_next`].
    pub fn draw_in_slices(
        &mut self,
        rec: &mut Recorder,
        view: &View,
        sizes: Sizes,
        is_moving: bool,
    ) -> Result<()> {
        let (quality, now) = self.next_picture(view, sizes, is_moving);
        (self.next).fit((&self.ctx, self.format), quality, sizes)?;
        std::mem::swap(&mut self.shown, &mut self.next);
        self.forget_mean_of(&now);
        self.drew_moving = is_moving;
        self.record(rec, &now, BANDS);
        std::mem::swap(&mut self.shown, &mut self.next);
        self.next_picture_view = self.view_of_picture(view, sizes);
        self.coming = Some(now);
        self.read_back();
        Ok(())
    }

    /// The picture that was drawn in slices is whole, and is shown from now on.
    pub fn show_next(&mut self) {
        std::mem::swap(&mut self.shown, &mut self.next);
        self.picture_view = self.next_picture_view.take();
        self.drawn = self.coming.take();
        if let Some(drawn) = &self.drawn {
            self.colors = Some(drawn.view.color_map);
        }
        self.pictures += 1;
        self.drawn_at = Instant::now();
    }

    /// How a picture is taken now.
    fn view_of_picture(&self, view: &View, (size, _): Sizes) -> Option<PictureView> {
        (!view.show.is_flat()).then(|| PictureView {
            camera: view.camera,
            size,
            from: self.viewpoint(&view.camera),
        })
    }

    /// How the picture that the canvas shows was taken, if it is one of the scene. Steps may have moved objects since then.
    pub fn picture_view(&self) -> Option<&PictureView> {
        self.picture_view.as_ref()
    }

    /// From where this camera sees the scene, as it would be drawn now.
    pub fn viewpoint(&self, camera: &Camera) -> Viewpoint {
        Viewpoint {
            eye: camera.eye(),
            poses: self.drawn_poses(),
            hidden: self.marks.hidden.clone(),
        }
    }

    /// How well the next picture is drawn, and what it depends on.
    fn next_picture(&self, view: &View, (_, beside): Sizes, is_moving: bool) -> (Quality, Drawn) {
        let is_quick = is_moving && self.ctx.info().kind == DeviceKind::Cpu;
        let mut view = *view;
        let quality = match is_quick {
            true => Quality::Quick,
            false => Quality::Smooth,
        };
        if is_quick {
            view.most_particles = PARTICLES_ON_CPU;
        }
        view.is_plain = is_moving && self.is_plain;
        let second = &self.simulation.settings().second_look;
        view.second_colors = second.look().map(|look| look.color_map);
        let step = self.simulation.step();
        if let Exposure::Auto {
            clipped_share,
            adaptation,
        } = &mut view.exposure
            && self.settled == Some((step, *clipped_share))
        {
            *adaptation = 0.0;
        }
        let poses = (self
            .simulation
            .shown_poses()
            .into_iter()
            .zip(self.factors()))
        .map(|(pose, factor)| pose.scaled(factor))
        .collect();
        let now = Drawn {
            view,
            step,
            poses,
            beside,
        };
        (quality, now)
    }

    /// Records a picture into the canvases that are shown.
    fn record(&mut self, rec: &mut Recorder, now: &Drawn, bands: u32) {
        let Drawn {
            view, step, poses, ..
        } = now;
        self.recorded += 1;
        let exposed = match view.exposure {
            Exposure::Auto { clipped_share, .. } => Some((*step, clipped_share)),
            Exposure::Fixed(_) => None,
        };
        if self.exposed != exposed {
            (self.exposed, self.exposed_since) = (exposed, self.recorded);
            self.settled = None;
        }
        self.particles_drawn = self.renderer.particles_drawn(view);
        self.simulation.record_poses(rec);
        let true_poses = self.simulation.poses().to_vec();
        let is_scaled = *poses != true_poses;
        if is_scaled {
            self.simulation.record_shown_poses(rec, poses);
        }
        let mut atlas = *view;
        atlas.show = Show::Atlas;
        let (picture, beside) = self.shown.canvases();
        let beside = beside.filter(|_| now.beside.is_some());
        let pictures = std::iter::once((*view, picture));
        let pictures: Vec<_> = pictures.chain(beside.map(|c| (atlas, c))).collect();
        let state = self.simulation.state();
        self.renderer.draw_in_bands(rec, state, &pictures, bands);
        if is_scaled {
            self.simulation.record_shown_poses(rec, &true_poses);
        }
        (self.renderer).record_brightest(rec, &mut self.exposure, self.recorded);
        (self.flaw_counter).record(rec, self.renderer.flaws(), self.recorded);
        let settings = self.simulation.settings();
        if settings.strategy() != Strategy::None || settings.physarum.rules().is_crowded() {
            let transfers = &self.simulation.state().transfers;
            transfers.record_readback(rec, &mut self.counters, *step);
        }
        if let Some(growth) = &self.simulation.state().growth {
            (self.population_counter).record(rec, &growth.population, *step);
        }
    }

    /// Takes what has arrived on the host.
    fn read_back(&mut self) {
        while let Some((number, brightest)) = self.exposure.poll() {
            let before = self.brightest.replace(brightest[0]);
            let change = before.map(|before| (brightest[0] - before).abs());
            let is_small = change.is_some_and(|change| change <= SETTLED * brightest[0]);
            // The picture before had the same trail to be exposed for.
            if is_small && number > self.exposed_since {
                self.settled = self.exposed;
            }
        }
        while let Some((_, flaws)) = self.flaw_counter.poll() {
            self.flaws = flaws[0];
        }
        while let Some((_, counters)) = self.counters.poll() {
            self.flow = counters[0];
        }
        while let Some((_, counters)) = self.population_counter.poll() {
            self.population = Some(counters[0]);
        }
    }

    /// Why pictures have no bloom, if they have none.
    pub fn undeveloped(&self) -> Option<String> {
        let (_, canvas) = self.shown.picture.as_ref()?;
        canvas.warning()
    }

    /// Pictures take so long now, in milliseconds: on a slow device their quality falls before their rate does.
    pub fn follow_times(&mut self, draw_ms: Option<f64>) {
        let Some(ms) = draw_ms else {
            return;
        };
        if !self.is_plain && ms > PLAIN_ABOVE {
            (self.is_plain, self.full_ms) = (true, ms);
        }
        // Where full pictures took far too long, plain ones have to be quick: it does not go back and forth.
        let beyond = (self.full_ms - PLAIN_ABOVE).max(0.0);
        if self.is_plain && ms + beyond < FULL_BELOW {
            self.is_plain = false;
        }
    }

    /// The contents of the canvas have changed between steps.
    pub fn forget_picture(&mut self) {
        self.changes += 1;
        self.drawn = None;
        // What is drawn in slices now is no longer right, either.
        self.coming = None;
        // It may have become brighter or darker.
        (self.exposed, self.settled) = (None, None);
    }

    /// Another state has taken the place of the one that ran.
    pub fn state_is_replaced(&mut self) {
        self.replaced += 1;
        self.forget_picture();
    }

    /// A brush has changed the trail.
    pub fn trail_is_painted(&mut self) {
        self.painted += 1;
        self.forget_picture();
    }

    /// The picture of the state that is there again, as at the end of a preview, is to come before steps.
    pub fn owe_picture(&mut self) {
        self.forget_picture();
        self.colors = None;
    }

    /// Does the canvas show what this camera and view last saw?
    pub fn has_drawn(&self, view: &View, (size, beside): Sizes) -> bool {
        let fits = |(_, canvas): &(Quality, Canvas)| canvas.size() == size;
        let is_of = |drawn: &Drawn| {
            let seen = &drawn.view;
            seen.camera == view.camera && seen.show == view.show && drawn.beside == beside
        };
        self.shown.picture.as_ref().is_some_and(fits) && self.drawn.as_ref().is_some_and(is_of)
    }

    /// Can the canvas stand in for a picture that is wider or narrower, until that is drawn? It can if a panel has come or gone beside it.
    pub fn stands_in(&self, view: &View, (size, beside): Sizes) -> bool {
        let is_beside = |(_, canvas): &(Quality, Canvas)| {
            let [width, height] = canvas.size();
            height == size[1] && (1..=MOST_BESIDE).contains(&width.abs_diff(size[0]))
        };
        let is_alone = |drawn: &Drawn| {
            drawn.view.show == view.show && drawn.beside.is_none() && beside.is_none()
        };
        self.shown.picture.as_ref().is_some_and(is_beside)
            && self.drawn.as_ref().is_some_and(is_alone)
    }

    /// Is the picture on the canvas still recent enough? It is for a while, as long as camera and colours stay.
    pub fn shows(&self, view: &View, sizes: Sizes) -> bool {
        let is_recent = self.drawn_at.elapsed() < SHOWN_FOR;
        is_recent && self.has_drawn(view, sizes) && self.has_colors(view.color_map)
    }

    /// Does the canvas show the trail in other colours than these, or a state that is no longer there?
    pub fn has_other_colors(&self, colors: ColorMap) -> bool {
        self.shown.picture.is_some() && !self.has_colors(colors)
    }

    /// Does the canvas show the trail in these colours?
    pub fn has_colors(&self, colors: ColorMap) -> bool {
        self.colors == Some(colors)
    }

    /// The colours in which the canvas shows the trail.
    pub fn colors(&self) -> Option<ColorMap> {
        self.colors
    }

    /// Do the canvases have these sizes?
    pub fn has_sizes(&self, sizes: Sizes) -> bool {
        let quality = self.shown.picture.as_ref().map(|(quality, _)| *quality);
        quality.is_some_and(|quality| self.shown.fits(quality, sizes))
    }

    /// Are there canvases, of other sizes than these?
    pub fn is_resized(&self, sizes: Sizes) -> bool {
        self.shown.picture.is_some() && !self.has_sizes(sizes)
    }

    /// The last picture; see [`Self::shows`].
    pub fn picture(&self) -> (&Image, Option<&Image>) {
        let (picture, beside) = self.shown.canvases();
        (picture.image(), beside.map(Canvas::image))
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

    /// How many times as large as it is each object is drawn.
    fn factors(&self) -> impl Iterator<Item = f32> {
        self.scales.iter().copied().chain(std::iter::repeat(1.0))
    }

    /// World from object, one an object, as they are drawn: also those that are drawn larger than they run.
    pub fn drawn_poses(&self) -> Vec<Affine3A> {
        let poses = self.simulation.world_from_object().into_iter();
        let scaled = |(pose, factor)| pose * Affine3A::from_scale(Vec3::splat(factor));
        poses.zip(self.factors()).map(scaled).collect()
    }

    /// The surface point under a pixel of a picture of `size`, where the picture shows it.
    pub fn pick(&self, view: &View, pixel: Vec2, size: Vec2) -> Option<Hit> {
        pick::pick_among(
            &self.scene.surface,
            &self.drawn_poses(),
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

/// The canvas of the picture, and of the atlas beside it if that is shown.
#[derive(Default)]
struct Canvases {
    picture: Option<(Quality, Canvas)>,
    beside: Option<(Quality, Canvas)>,
    /// When smooth ones are tried again for which there was no memory.
    again: Option<Instant>,
}

impl Canvases {
    /// Are they of this quality and these sizes?
    fn fits(&self, quality: Quality, (size, beside): Sizes) -> bool {
        let has = |canvas: &Option<(Quality, Canvas)>| {
            (canvas.as_ref()).map(|(quality, canvas)| (*quality, canvas.size()))
        };
        let wanted = [Some(size), beside].map(|size| size.map(|size| (quality, size)));
        [has(&self.picture), has(&self.beside)] == wanted && !self.is_due()
    }

    fn is_due(&self) -> bool {
        self.again.is_some_and(|again| again <= Instant::now())
    }

    /// Makes the canvases again that do not fit. Returns true if it made one.
    fn fit(
        &mut self,
        (ctx, format): (&Arc<Context>, Format),
        quality: Quality,
        (size, beside): Sizes,
    ) -> Result<bool> {
        let is_due = self.is_due();
        if is_due {
            self.again = None;
        }
        let mut is_new = false;
        for (canvas, size) in [(&mut self.picture, Some(size)), (&mut self.beside, beside)] {
            let has = canvas.as_ref().map(|(has, canvas)| (*has, canvas.size()));
            if has == size.map(|size| (quality, size)) && !is_due {
                continue;
            }
            is_new = true;
            *canvas = None;
            if let Some(size) = size {
                let (made, is_whole) = canvas_of(ctx, size, format, quality)?;
                *canvas = Some((quality, made));
                if !is_whole {
                    self.again = Some(Instant::now() + AGAIN_AFTER);
                }
            }
        }
        Ok(is_new)
    }

    fn canvases(&self) -> (&Canvas, Option<&Canvas>) {
        let (_, picture) = self.picture.as_ref().expect("it was drawn");
        (picture, self.beside.as_ref().map(|(_, canvas)| canvas))
    }
}

/// After so long canvases are made again for which there was no memory. Earlier ones are free then.
const AGAIN_AFTER: Duration = Duration::from_secs(1);

/// A canvas of this quality and true, or a quick one and false where there is no memory for that: while the size of the window changes,
/// earlier canvases are still in use.
fn canvas_of(
    ctx: &Arc<Context>,
    size: [u32; 2],
    format: Format,
    quality: Quality,
) -> Result<(Canvas, bool)> {
    let new = |quality| Canvas::with_quality(ctx, size, format, quality);
    match new(quality) {
        Err(GpuError::OutOfMemory { .. }) if quality != Quality::Quick => {
            Ok((new(Quality::Quick)?, false))
        }
        made => Ok((made?, true)),
    }
}

/// Remarks on oddities of a scene's meshes, each mesh once.
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
    use crate::lab::on_device::{self, SMALL, context, run};
    use myxo::gpu::{Buffer, Domain, Frames};
    use myxo::sim::paint::{Brush, Dab};

    fn trio() -> Option<(Arc<Context>, Stage)> {
        let ctx = context()?;
        let set = [&SMALL[..], &["transfer.threshold=0.01"]].concat();
        let stage = on_device::stage(&ctx, "trio", &set);
        Some((ctx, stage))
    }

    const SIZES: Sizes = ([64, 48], None);

    /// The pixels that a recording comes to.
    fn pixels(
        ctx: &Arc<Context>,
        frames: &mut Frames,
        stage: &mut Stage,
        record: impl FnOnce(&mut Recorder, &mut Stage),
    ) -> Vec<[u8; 4]> {
        let [width, height] = SIZES.0.map(|side| side as usize);
        let name = "pixels";
        let read = Buffer::new(ctx, name, width * height, Domain::Readback).unwrap();
        let mut rec = frames.begin().unwrap();
        record(&mut rec, stage);
        rec.copy_image(stage.picture().0, &read);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        read.as_slice().to_vec()
    }

    fn drawn(ctx: &Arc<Context>, stage: &mut Stage, frames: &mut Frames) -> Vec<[u8; 4]> {
        let view = View::of(&stage.scene, Vec2::new(64.0, 48.0));
        pixels(ctx, frames, stage, |rec, stage| {
            stage.draw(rec, &view, SIZES, true).unwrap();
        })
    }

    /// Would catch: bands that miss a row, and a picture that is shown in parts; and one that does not go before steps though its state is no
    /// longer there, or does though only its contents have changed.
    #[test]
    fn a_picture_in_slices_is_the_same_and_shown_when_it_is_whole() {
        let Some((ctx, mut stage)) = trio() else {
            return;
        };
        let view = View::of(&stage.scene, Vec2::new(64.0, 48.0));
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut answers = Frames::new(&ctx, 1).unwrap();
        let before = drawn(&ctx, &mut stage, &mut frames);
        run(&mut frames, &mut stage.simulation, 20);

        assert!(!stage.has_picture(&view, SIZES, true));
        let mut rec = frames.begin().unwrap();
        rec.slice(Duration::from_millis(12), frames.timings());
        stage.draw_in_slices(&mut rec, &view, SIZES, true).unwrap();
        let mut slices = 0;
        while frames.run_slice(&mut rec).unwrap() {
            slices += 1;
            let between = pixels(&ctx, &mut answers, &mut stage, |_, _| {});
            assert!(between == before, "after {slices} slices");
        }
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        assert!(slices > BANDS, "{slices}");
        stage.show_next();
        assert!(stage.has_picture(&view, SIZES, true));
        let shown = pixels(&ctx, &mut answers, &mut stage, |_, _| {});
        let is_owed = |stage: &Stage| stage.has_other_colors(view.color_map);
        assert!(!is_owed(&stage));
        stage.forget_picture();
        assert!(!is_owed(&stage));
        let whole = drawn(&ctx, &mut stage, &mut frames);
        assert!(shown == whole && shown != before);
        stage.owe_picture();
        assert!(is_owed(&stage));
        drawn(&ctx, &mut stage, &mut frames);
        assert!(!is_owed(&stage) && stage.has_other_colors(ColorMap::Ice));
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Would catch: lines over a picture by the poses before its steps, or by those of steps that it does not show yet.
    #[test]
    fn how_a_picture_was_taken_is_kept_while_objects_move_on() {
        let Some((ctx, mut stage)) = trio() else {
            return;
        };
        // One of its objects swings.
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let view = View::of(&stage.scene, Vec2::new(64.0, 48.0));
        let seen = |stage: &Stage| stage.picture_view().expect("there is a picture").clone();
        assert_eq!(stage.picture_view(), None);
        run(&mut frames, &mut stage.simulation, 5);
        drawn(&ctx, &mut stage, &mut frames);
        let first = seen(&stage);
        assert_eq!((first.camera, first.size), (view.camera, SIZES.0));
        assert_eq!(first.from, stage.viewpoint(&view.camera));
        run(&mut frames, &mut stage.simulation, 5);
        assert_eq!(seen(&stage), first, "the picture is still the one before");
        assert_ne!(stage.drawn_poses(), first.from.poses);
        // The next one comes in slices.
        let mut rec = frames.begin().unwrap();
        rec.slice(Duration::from_millis(12), frames.timings());
        stage.draw_in_slices(&mut rec, &view, SIZES, true).unwrap();
        assert_eq!(seen(&stage), first, "it is not whole");
        while frames.run_slice(&mut rec).unwrap() {}
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        stage.forget_picture();
        stage.show_next();
        assert_eq!(seen(&stage).from, stage.viewpoint(&view.camera));
        // The flat atlas is taken by no camera.
        let mut flat = view;
        flat.show = Show::Atlas;
        let mut rec = frames.begin().unwrap();
        stage.draw(&mut rec, &flat, SIZES, true).unwrap();
        frames.submit(rec).unwrap();
        assert_eq!(stage.picture_view(), None);
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Would catch: a resting picture that is refined for ever, or to another picture; a mean that goes on after the scene has changed; and
    /// one whose edges stay as jagged as before.
    #[test]
    fn a_resting_picture_is_refined_and_begins_again_after_a_change() {
        let Some((ctx, mut stage)) = trio() else {
            return;
        };
        let mut view = View::of(&stage.scene, Vec2::new(64.0, 48.0));
        view.exposure = Exposure::Fixed(2.0);
        let mut frames = Frames::new(&ctx, 1).unwrap();
        run(&mut frames, &mut stage.simulation, 10);
        let refined = |frames: &mut Frames, stage: &mut Stage, view: &View| {
            let plain = pixels(&ctx, frames, stage, |rec, stage| {
                stage.draw(rec, view, SIZES, false).unwrap();
            });
            let mut last = plain.clone();
            let mut count = 1;
            while stage.can_refine() {
                last = pixels(&ctx, frames, stage, |rec, stage| stage.refine(rec));
                count += 1;
                assert_eq!(stage.refined_count(), count);
                assert!(stage.has_picture(view, SIZES, false));
            }
            assert_eq!(count, mean::FINE);
            (plain, last)
        };
        let difference = |a: &[[u8; 4]], b: &[[u8; 4]]| {
            let differences = a.as_flattened().iter().zip(b.as_flattened());
            let sum: u32 = differences.map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
            f64::from(sum) / (4 * a.len()) as f64
        };
        let (plain, smooth) = refined(&mut frames, &mut stage, &view);
        let refinement = difference(&plain, &smooth);
        assert!((0.01..2.5).contains(&refinement), "{refinement}");
        let mut turned = view;
        turned.camera.yaw += 1.0;
        let (other, _) = refined(&mut frames, &mut stage, &turned);
        assert!(difference(&plain, &other) > 2.0 * refinement);
        let (plain_again, smooth_again) = refined(&mut frames, &mut stage, &view);
        assert!(plain_again == plain && smooth_again == smooth);
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Draws with an automatic exposure, as one frame after the other does, until it changes nothing more; the brightest trail then.
    fn settle(stage: &mut Stage, frames: &mut Frames, view: &mut View) -> f32 {
        for picture in 0..200 {
            view.exposure = Exposure::Auto {
                clipped_share: 0.01,
                // No frame is exactly as long as the one before.
                adaptation: 0.5 + 1e-3 * (picture % 2) as f32,
            };
            if stage.has_picture(view, SIZES, true) {
                return stage.brightest.expect("it was drawn");
            }
            (frames.run(|rec| stage.draw(rec, view, SIZES, true).map(|_| ())))
                .unwrap()
                .unwrap();
        }
        panic!("it is drawn for ever");
    }

    /// Would catch: a paused picture that is drawn for ever, and an exposure that stays where a fixed one has put it.
    #[test]
    fn exposures_settle_and_follow_again_after_fixed_ones() {
        let Some((ctx, mut stage)) = trio() else {
            return;
        };
        let mut frames = Frames::new(&ctx, 1).unwrap();
        run(&mut frames, &mut stage.simulation, 10);
        let mut view = View::of(&stage.scene, Vec2::new(64.0, 48.0));
        let before = settle(&mut stage, &mut frames, &mut view);
        assert!(before > 0.0, "{before}");
        view.exposure = Exposure::Fixed(20.0 * before);
        for yaw in [0.1, 0.2, 0.3] {
            view.camera.yaw = yaw;
            (frames.run(|rec| stage.draw(rec, &view, SIZES, true).map(|_| ())))
                .unwrap()
                .unwrap();
        }
        let after = settle(&mut stage, &mut frames, &mut view);
        assert!((after / before - 1.0).abs() < 0.02, "{after}, not {before}");
        // After a trail was painted or erased, the exposure is set again.
        stage.forget_picture();
        assert_eq!(stage.settled, None);
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Through all strategies and back, between frames that are under way, as the panel does it.
    #[test]
    fn strategies_change_while_it_is_drawn() {
        let Some((ctx, mut stage)) = trio() else {
            return;
        };
        let view = View::of(&stage.scene, Vec2::new(64.0, 48.0));
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

    /// Would catch: a picture with larger objects whose poses stay for the next step.
    #[test]
    fn larger_objects_are_drawn_and_the_state_continues_unchanged() {
        let mut pictures = Vec::new();
        let states = [false, true].map(|is_scaled| {
            let (ctx, mut stage) = trio()?;
            let mut frames = Frames::new(&ctx, 1).unwrap();
            for _ in 0..3 {
                let mut rec = frames.begin().unwrap();
                stage.simulation.record_step(&mut rec);
                frames.submit(rec).unwrap();
                if is_scaled {
                    stage.scales = vec![1.0, 1.5, 1.0];
                }
                pictures.push(drawn(&ctx, &mut stage, &mut frames));
            }
            // As large as they are again, the picture is the one without.
            stage.scales.clear();
            pictures.push(drawn(&ctx, &mut stage, &mut frames));
            assert_eq!(ctx.messages(), [""; 0]);
            Some(stage.simulation.snapshot().unwrap().hash())
        });
        if let [Some(as_it_is), Some(scaled)] = &states {
            assert_eq!(as_it_is, scaled, "pictures changed the state");
            assert!((0..3).all(|i| pictures[i] != pictures[4 + i]));
            assert!(pictures[3] == pictures[7]);
        }
    }

    /// Would catch: clicks and brushes that meet a larger object where it is before its layout has come.
    #[test]
    fn a_larger_object_is_picked_and_painted_where_it_is_drawn() {
        let Some((ctx, mut stage)) = trio() else {
            return;
        };
        let size = Vec2::new(64.0, 48.0);
        let view = View::of(&stage.scene, size);
        let pixels: Vec<Vec2> = (0..48)
            .flat_map(|y| (0..64).map(move |x| Vec2::new(x as f32, y as f32)))
            .collect();
        let hits = |stage: &Stage| -> Vec<Option<Hit>> {
            let hits = pixels.iter().map(|pixel| stage.pick(&view, *pixel, size));
            hits.collect()
        };
        let count = |hits: &[Option<Hit>]| hits.iter().flatten().count();
        let before = hits(&stage);
        stage.scales = vec![1.0, 2.0, 1.0];
        let drawn = hits(&stage);
        assert!(count(&drawn) > count(&before), "more pixels show it");
        // Where only the larger one is, a brush paints the triangle that is picked.
        let both = pixels.iter().zip(before).zip(drawn);
        let mut beside = both
            .filter_map(|((pixel, before), hit)| Some((pixel, hit?)).filter(|_| before.is_none()));
        let (_, hit) = beside.next_back().expect("it is larger");
        let dab = Dab {
            brush: Brush::Trail { amount: 5.0 },
            center: hit.position,
            radius: 0.1 * stage.scene.radius,
            eye: Some(view.camera.eye()),
            ring: None,
            number: 0,
        };
        let setup = stage.simulation.setup();
        let texels =
            (dab.texels_on_scaled(setup, stage.simulation.poses(), &stage.scales)).unwrap();
        let object = setup.surface.triangles[hit.triangle as usize].object;
        assert_eq!(object, 1);
        let strongest = texels.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        let strongest = strongest.expect("something is painted");
        assert!(
            strongest.object == object && strongest.weight > 0.5,
            "{strongest:?}"
        );
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let painted = frames.run(|rec| {
            let scales = stage.scales.clone();
            stage.simulation.paint_on_scaled(rec, &dab, &scales)
        });
        assert_eq!(painted.unwrap().unwrap().count(), texels.len() as u32);
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
