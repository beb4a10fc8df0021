//! The ways that are compared: recorded on particles and a trail, and what comes out of them.

use std::sync::Arc;

use glam::Vec2;
use myxo::Result;
use myxo::gpu::{
    Blend, Buffer, Context, DepthTest, Domain, Format, Frames, GpuResult, Image, Pipeline,
    RasterOptions, RasterPipeline, Recorder, Sampled, Targets, Texels, Threads, Topology,
};
use myxo::scene::Settings;
use myxo::sim::Setup;
use myxo::sim::behaviour::physarums;
use myxo::sim::types::{Motion, Particle};

use super::tables::{sensor_places, turning_strips};
use draws::{DrawDepositsArgs, DrawDepositsDraw, DrawDepositsParams};
use kernels::{
    CountDeposits, CountDepositsArgs, CountDepositsParams, ReadBlock, ReadBlockArgs,
    ReadBlockParams, ReadImage, ReadImageArgs, ReadImageParams, ReadSampler, ReadSamplerArgs,
    ReadSamplerParams, ReadStorageTexels, ReadStorageTexelsArgs, ReadStorageTexelsParams,
    ReadTexels, ReadTexelsArgs, ReadTexelsParams, WalkCorrected, WalkCorrectedArgs,
    WalkCorrectedParams, WalkExactly, WalkExactlyArgs, WalkExactlyParams,
};

/// Typed handles of `shaders/choices/*.comp`, as the build generates them.
#[allow(
    clippy::identity_op,
    clippy::derivable_impls,
    dead_code,
    reason = "generated"
)]
pub mod kernels {
    include!(concat!(env!("OUT_DIR"), "/choices.rs"));
}

/// The same of what is drawn.
#[allow(
    clippy::identity_op,
    clippy::derivable_impls,
    dead_code,
    reason = "generated"
)]
pub mod draws {
    include!(concat!(env!("OUT_DIR"), "/choices_draws.rs"));
}

/// How far walks go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// As particles do in a step.
    Step,
    /// As far as sensors look.
    Sensor,
}

/// How walks find their way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walking {
    /// As the program does.
    Exact,
    /// First the whole length, then corrections, as many as edge-crossing attempts.
    Corrected,
    /// One correction only.
    CorrectedOnce,
}

/// How the trail is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    /// As the program does.
    Texels,
    Block,
    StorageTexels,
    /// Texel by texel.
    Image,
    /// Between texels by the device's own sampler.
    Sampler,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Does {
    Walk(Reach, Walking),
    /// By atomic adds, as the program does.
    Count,
    /// Drawn as points that add up.
    Draw,
    Read(Binding),
}

/// One of the ways to do something.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// What it does. Those of one word are compared with each other; the first is the program's own.
    pub of: &'static str,
    pub how: &'static str,
    /// What its times are under.
    pub kernel: &'static str,
    pub does: Does,
}

const fn way(of: &'static str, how: &'static str, kernel: &'static str, does: Does) -> Way {
    Way {
        of,
        how,
        kernel,
        does,
    }
}

pub const STEP: &str = "step";
pub const TO_A_SENSOR: &str = "way to a sensor";
pub const DEPOSITS: &str = "deposits";
pub const READINGS: &str = "readings";

pub const WAYS: [Way; 13] = {
    use Binding::*;
    use Does::*;
    use Reach::*;
    use Walking::*;
    let [exact, corrected, once] = ["exact edge test", "corrected afterwards", "corrected once"];
    [
        way(STEP, exact, "step_exactly", Walk(Step, Exact)),
        way(STEP, corrected, "step_corrected", Walk(Step, Corrected)),
        way(STEP, once, "step_corrected_once", Walk(Step, CorrectedOnce)),
        way(TO_A_SENSOR, exact, "reach_exactly", Walk(Sensor, Exact)),
        way(
            TO_A_SENSOR,
            corrected,
            "reach_corrected",
            Walk(Sensor, Corrected),
        ),
        way(
            TO_A_SENSOR,
            once,
            "reach_corrected_once",
            Walk(Sensor, CorrectedOnce),
        ),
        way(DEPOSITS, "atomic adds", "count_deposits", Count),
        way(DEPOSITS, "drawn points", "draw_deposits", Draw),
        way(READINGS, "texel buffer", "read_texels", Read(Texels)),
        way(READINGS, "storage block", "read_block", Read(Block)),
        way(
            READINGS,
            "storage texels",
            "read_storage_texels",
            Read(StorageTexels),
        ),
        way(READINGS, "image", "read_image", Read(Image)),
        way(READINGS, "sampler", "read_sampler", Read(Sampler)),
    ]
};

/// What all ways begin from.
#[derive(Clone)]
pub struct State {
    pub particles: Vec<Particle>,
    pub motions: Vec<Motion>,
    /// One value a texel.
    pub trail: Vec<f32>,
}

/// A walk straight on.
#[derive(Clone, Copy, Debug)]
pub struct Walk {
    pub reach: Reach,
    pub walking: Walking,
    /// World length.
    pub length: f32,
    /// Edges that it may cross.
    pub attempts: u32,
}

/// Particles and motions, as kernels read and write them.
struct Walkers {
    particles: Buffer<Particle>,
    motions: Buffer<Motion>,
    particle_texels: Texels<u32>,
    motion_texels: Texels<u32>,
}

impl Walkers {
    fn new(ctx: &Arc<Context>, particles: &[Particle], motions: &[Motion]) -> GpuResult<Self> {
        let particles = Buffer::from_slice_in(ctx, "choices.particles", particles, Domain::Texels)?;
        let motions = Buffer::from_slice_in(ctx, "choices.motions", motions, Domain::Texels)?;
        Ok(Self {
            particle_texels: Texels::new(&particles, 4)?,
            motion_texels: Texels::new(&motions, 4)?,
            particles,
            motions,
        })
    }

    fn count(&self) -> u32 {
        self.particles.len() as u32
    }
}

/// Everything that the ways need.
pub struct Ways {
    ctx: Arc<Context>,
    /// Texels from one row of the atlas to the next, and rows.
    size: [u32; 2],
    /// World lengths of a step and to a sensor.
    lengths: [f32; 2],
    attempts: u32,
    start: Walkers,
    ends: Walkers,
    exact: [Pipeline<WalkExactly>; 2],
    corrected: [[Pipeline<WalkCorrected>; 2]; 2],
    strips: Texels<u32>,
    /// What walks that are corrected read, laid out as what the program's own read.
    turning: Texels<u32>,
    count: Pipeline<CountDeposits>,
    draw: RasterPipeline<DrawDepositsDraw>,
    deposits: Buffer<u32>,
    target: Image,
    trail: Buffer<f32>,
    trail_texels: Texels<f32>,
    image: Sampled,
    /// The places that sensors read, two texels a particle.
    places: Texels<f32>,
    values: Buffer<f32>,
    read_texels: Pipeline<ReadTexels>,
    read_block: Pipeline<ReadBlock>,
    read_storage_texels: Pipeline<ReadStorageTexels>,
    read_image: Pipeline<ReadImage>,
    read_sampler: Pipeline<ReadSampler>,
}

impl Ways {
    /// On a state of a scene with one object.
    pub fn new(
        ctx: &Arc<Context>,
        settings: &Settings,
        setup: &Setup,
        state: &State,
    ) -> Result<Self> {
        let own = physarums(settings, setup)[0];
        let attempts = settings.physarum.edge_crossing_attempts;
        let places = sensor_places(&setup.strips, attempts, &own, state);
        let turning = turning_strips(&setup.surface, &setup.strips);
        let places = Buffer::from_slice_in(ctx, "choices.places", &places, Domain::Texels)?;
        let turning = Buffer::from_slice_in(ctx, "choices.turning", &turning, Domain::Texels)?;
        let strips = Buffer::from_slice_in(ctx, "choices.strips", &setup.strips, Domain::Texels)?;
        let trail = Buffer::from_slice_in(ctx, "choices.trail", &state.trail, Domain::Texels)?;
        let size = [setup.atlas.pitch, setup.atlas.size];
        let image = Sampled::new(ctx, "choices.image", size)?;
        Frames::new(ctx, 1)?.run(|rec| rec.copy_to_sampled(&trail, &image))?;
        let exact = |name| Pipeline::named(ctx, &(), name);
        let corrected = |name| Pipeline::named(ctx, &(), name);
        let points = RasterOptions {
            color: Format::R32Float,
            depth: false,
            blend: Blend::Add,
            topology: Topology::Points,
            ..RasterOptions::default()
        };
        Ok(Self {
            ctx: Arc::clone(ctx),
            size,
            lengths: [own.speed, own.sensor_offset],
            attempts,
            start: Walkers::new(ctx, &state.particles, &state.motions)?,
            ends: Walkers::new(ctx, &state.particles, &state.motions)?,
            exact: [exact("step_exactly")?, exact("reach_exactly")?],
            corrected: [
                [
                    corrected("step_corrected")?,
                    corrected("step_corrected_once")?,
                ],
                [
                    corrected("reach_corrected")?,
                    corrected("reach_corrected_once")?,
                ],
            ],
            strips: Texels::new(&strips, 4)?,
            turning: Texels::new(&turning, 4)?,
            count: Pipeline::new(ctx, &())?,
            draw: RasterPipeline::new(ctx, &(), points)?,
            deposits: Buffer::zeroed(ctx, "choices.deposits", state.trail.len())?,
            target: Image::new(ctx, "choices.target", size, Format::R32Float, 1)?,
            trail_texels: Texels::new(&trail, 1)?,
            trail,
            image,
            places: Texels::new(&places, 4)?,
            values: Buffer::zeroed(ctx, "choices.values", state.particles.len())?,
            read_texels: Pipeline::new(ctx, &())?,
            read_block: Pipeline::new(ctx, &())?,
            read_storage_texels: Pipeline::new(ctx, &())?,
            read_image: Pipeline::new(ctx, &())?,
            read_sampler: Pipeline::new(ctx, &())?,
        })
    }

    /// A walk of the scene's length and edge-crossing attempts.
    pub fn walk(&self, reach: Reach, walking: Walking) -> Walk {
        Walk {
            reach,
            walking,
            length: self.lengths[reach as usize],
            attempts: match walking {
                Walking::CorrectedOnce => 1,
                _ => self.attempts,
            },
        }
    }

    /// Records one way, on the state that all begin from.
    pub fn record(&self, rec: &mut Recorder, does: Does) {
        match does {
            Does::Walk(reach, walking) => {
                self.record_walk(rec, self.walk(reach, walking), &self.start, &self.ends);
            }
            Does::Count => self.record_count(rec),
            Does::Draw => self.record_drawing(rec),
            Does::Read(binding) => self.record_reading(rec, binding),
        }
    }

    fn record_walk(&self, rec: &mut Recorder, walk: Walk, from: &Walkers, to: &Walkers) {
        let (attempts, way, reach) = (walk.attempts, walk.length, walk.reach as usize);
        let particle_count = from.count();
        let threads = Threads(particle_count);
        if walk.walking == Walking::Exact {
            let args = WalkExactlyArgs {
                particles_before: &from.particle_texels,
                motions_before: &from.motion_texels,
                strips: &self.strips,
                particles: &to.particle_texels,
                motions: &to.motion_texels,
            };
            let params = WalkExactlyParams {
                particle_count,
                attempts,
                way,
            };
            rec.dispatch(&self.exact[reach], threads, args, params);
        } else {
            let args = WalkCorrectedArgs {
                particles_before: &from.particle_texels,
                motions_before: &from.motion_texels,
                strips: &self.turning,
                particles: &to.particle_texels,
                motions: &to.motion_texels,
            };
            let params = WalkCorrectedParams {
                particle_count,
                attempts,
                way,
            };
            let is_once = walk.walking == Walking::CorrectedOnce;
            let pipeline = &self.corrected[reach][usize::from(is_once)];
            rec.dispatch(pipeline, threads, args, params);
        }
    }

    /// The places of walkers after so many straight walks.
    pub fn walked(
        &self,
        walk: Walk,
        times: u32,
        particles: &[Particle],
        motions: &[Motion],
    ) -> Result<(Vec<Particle>, Vec<Motion>)> {
        let mut pair = [
            Walkers::new(&self.ctx, particles, motions)?,
            Walkers::new(&self.ctx, particles, motions)?,
        ];
        let mut frames = Frames::new(&self.ctx, 1)?;
        for _ in 0..times {
            let mut rec = frames.begin()?;
            self.record_walk(&mut rec, walk, &pair[0], &pair[1]);
            frames.submit(rec)?;
            pair.swap(0, 1);
        }
        frames.wait_idle()?;
        let particles = self.ctx.download(&pair[0].particles)?;
        Ok((particles, self.ctx.download(&pair[0].motions)?))
    }

    fn record_count(&self, rec: &mut Recorder) {
        rec.fill(&self.deposits, 0);
        let particle_count = self.start.count();
        let args = CountDepositsArgs {
            particles: &self.start.particle_texels,
            strips: &self.strips,
            deposits: &self.deposits,
        };
        let params = CountDepositsParams {
            particle_count,
            pitch: self.size[0],
        };
        rec.dispatch(&self.count, Threads(particle_count), args, params);
    }

    fn record_drawing(&self, rec: &mut Recorder) {
        let targets = Targets {
            color: &self.target,
            resolve: None,
            depth: None,
            depth_test: DepthTest::Greatest,
            clear: Some([0.0; 4]),
        };
        // A step's kernels leave zeros behind, whichever way deposits come, so clearing is on neither side.
        rec.pass("clear", &targets, |_| {});
        let targets = Targets {
            clear: None,
            ..targets
        };
        rec.pass_as_kernel("draw_deposits", &targets, |pass| {
            let args = DrawDepositsArgs {
                particles: &self.start.particle_texels,
                strips: &self.strips,
            };
            let params = DrawDepositsParams {
                pixel: 2.0 / self.size_in_texels(),
            };
            pass.draw(&self.draw, self.start.count(), 1, args, params);
        });
    }

    fn size_in_texels(&self) -> Vec2 {
        let [width, height] = self.size;
        Vec2::new(width as f32, height as f32)
    }

    /// How many particles each texel has, by atomic adds and by drawing.
    pub fn counts(&self) -> Result<[Vec<u32>; 2]> {
        let drawn: Buffer<f32> = Buffer::zeroed(&self.ctx, "choices.drawn", self.deposits.len())?;
        Frames::new(&self.ctx, 1)?.run(|rec| {
            self.record_count(rec);
            self.record_drawing(rec);
            rec.copy_image(&self.target, &drawn);
        })?;
        let drawn = self.ctx.download(&drawn)?.into_iter();
        let drawn = drawn.map(|count| count as u32).collect();
        Ok([self.ctx.download(&self.deposits)?, drawn])
    }

    fn record_reading(&self, rec: &mut Recorder, binding: Binding) {
        let particle_count = self.values.len() as u32;
        let pitch = self.size[0];
        let (places, values) = (&self.places, &self.values);
        macro_rules! read {
            ($pipeline:ident, $Args:ident, $trail:ident, $Params:ident, $($param:ident $(: $value:expr)?),*) => {
                rec.dispatch(
                    &self.$pipeline,
                    Threads(particle_count),
                    $Args { places, values, trail: &self.$trail },
                    $Params { particle_count, $($param $(: $value)?),* },
                )
            };
        }
        match binding {
            Binding::Texels => read!(
                read_texels,
                ReadTexelsArgs,
                trail_texels,
                ReadTexelsParams,
                pitch
            ),
            Binding::Block => read!(read_block, ReadBlockArgs, trail, ReadBlockParams, pitch),
            Binding::StorageTexels => read!(
                read_storage_texels,
                ReadStorageTexelsArgs,
                trail_texels,
                ReadStorageTexelsParams,
                pitch
            ),
            Binding::Image => read!(read_image, ReadImageArgs, image, ReadImageParams,),
            Binding::Sampler => read!(
                read_sampler,
                ReadSamplerArgs,
                image,
                ReadSamplerParams,
                texel: 1.0 / self.size_in_texels()
            ),
        }
    }

    /// What sensors read, one sum a particle.
    pub fn readings(&self, binding: Binding) -> Result<Vec<f32>> {
        Frames::new(&self.ctx, 1)?.run(|rec| self.record_reading(rec, binding))?;
        Ok(self.ctx.download(&self.values)?)
    }
}
