//! The ways that are compared, on the particles and the trail of a simulation: recorded in turn, and what comes out of them.

use std::sync::Arc;

use glam::Vec2;
use myxo::gpu::{
    Blend, Buffer, Context, DepthTest, Domain, Format, Frames, Image, Pipeline, RasterOptions,
    RasterPipeline, Recorder, Sampled, Targets, Texels, Threads, Topology,
};
use myxo::sim::behaviour::physarums;
use myxo::sim::choices::draws::{DrawDepositsArgs, DrawDepositsDraw, DrawDepositsParams};
use myxo::sim::choices::kernels::{
    CountDeposits, CountDepositsArgs, CountDepositsParams, ReadBlock, ReadBlockArgs,
    ReadBlockParams, ReadImage, ReadImageArgs, ReadImageParams, ReadSampler, ReadSamplerArgs,
    ReadSamplerParams, ReadStorageTexels, ReadStorageTexelsArgs, ReadStorageTexelsParams,
    ReadTexels, ReadTexelsArgs, ReadTexelsParams, WalkCorrected, WalkCorrectedArgs,
    WalkCorrectedParams, WalkExactly, WalkExactlyArgs, WalkExactlyParams,
};
use myxo::sim::choices::{sensor_places, turning_strips};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::step::advance::Form;
use myxo::sim::types::{Motion, Particle};
use myxo::sim::{Simulation, Snapshot};
use myxo::{Error, Result};

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

/// One of the ways to do something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    Walk(Reach, Walking),
    /// By atomic adds, as the program does.
    Count,
    /// Drawn as points that add up.
    Draw,
    Read(Binding),
}

/// Walkers: particles and motions, as kernels read and write them.
pub struct Walkers {
    particles: Buffer<Particle>,
    particle_texels: Texels<u32>,
    motion_texels: Texels<u32>,
}

impl Walkers {
    pub fn new(ctx: &Arc<Context>, particles: &[Particle], motions: &[Motion]) -> Result<Self> {
        let particles = Buffer::from_slice_in(ctx, "choices.particles", particles, Domain::Texels)?;
        let motions = Buffer::from_slice_in(ctx, "choices.motions", motions, Domain::Texels)?;
        Ok(Self {
            particle_texels: Texels::new(&particles, 4)?,
            motion_texels: Texels::new(&motions, 4)?,
            particles,
        })
    }
}

/// Everything that the ways need.
pub struct Ways<'a> {
    ctx: &'a Arc<Context>,
    simulation: &'a Simulation,
    /// The state that all begin from.
    pub snapshot: Snapshot,
    /// World lengths of a step and to a sensor.
    speed: f32,
    sensor_offset: f32,
    attempts: u32,
    start: Walkers,
    ends: Walkers,
    walks: [[WalkPipelines; 3]; 2],
    /// What walks that are corrected read, laid out as what the program's own read.
    turning: Texels<u32>,
    count: Pipeline<CountDeposits>,
    draw: RasterPipeline<DrawDepositsDraw>,
    deposits: Buffer<u32>,
    target: Image,
    /// Where sensors read, two texels a particle.
    place_texels: Texels<f32>,
    image: Sampled,
    values: Buffer<f32>,
    read_texels: Pipeline<ReadTexels>,
    read_block: Pipeline<ReadBlock>,
    read_storage_texels: Pipeline<ReadStorageTexels>,
    read_image: Pipeline<ReadImage>,
    read_sampler: Pipeline<ReadSampler>,
}

enum WalkPipelines {
    Exact(Pipeline<WalkExactly>),
    Corrected(Pipeline<WalkCorrected>),
}

impl Walking {
    const ALL: [Self; 3] = [Self::Exact, Self::Corrected, Self::CorrectedOnce];
}

impl Way {
    /// What its times are under.
    pub fn kernel(self) -> &'static str {
        match self {
            Self::Walk(Reach::Step, Walking::Exact) => "step_exactly",
            Self::Walk(Reach::Step, Walking::Corrected) => "step_corrected",
            Self::Walk(Reach::Step, Walking::CorrectedOnce) => "step_corrected_once",
            Self::Walk(Reach::Sensor, Walking::Exact) => "reach_exactly",
            Self::Walk(Reach::Sensor, Walking::Corrected) => "reach_corrected",
            Self::Walk(Reach::Sensor, Walking::CorrectedOnce) => "reach_corrected_once",
            Self::Count => "count_deposits",
            Self::Draw => "draw_deposits",
            Self::Read(Binding::Texels) => "read_texels",
            Self::Read(Binding::Block) => "read_block",
            Self::Read(Binding::StorageTexels) => "read_storage_texels",
            Self::Read(Binding::Image) => "read_image",
            Self::Read(Binding::Sampler) => "read_sampler",
        }
    }
}

/// Why a device or a scene has not all of the ways, if it has not.
pub fn missing(ctx: &Context, texels: usize) -> Option<String> {
    let info = ctx.info();
    if !Format::R32Float.blends(ctx) {
        return Some(format!("{} cannot blend 32-bit floats", info.name));
    }
    let bytes = 4 * texels as u64;
    let most = u64::from(info.max_texel_buffer_elements).min(info.max_storage_buffer_range / 4);
    (texels as u64 > most).then(|| {
        format!(
            "its texture of {bytes} bytes is larger than one storage block or one texel buffer: set atlas.size lower"
        )
    })
}

impl<'a> Ways<'a> {
    /// On what the simulation has come to.
    pub fn new(ctx: &'a Arc<Context>, simulation: &'a Simulation) -> Result<Self> {
        let setup = simulation.setup();
        let snapshot = simulation.snapshot()?;
        let means = Means::of_host(false, 1);
        let plan = Plan::new(simulation.settings(), setup, simulation.step(), means);
        let params = plan.advance(plan.terms(), Form::All).params;
        let own = physarums(simulation.settings(), setup)[0];
        let places = sensor_places(setup, &params, &own, &snapshot.particles, &snapshot.motions);
        let place_buffer = Buffer::from_slice_in(ctx, "choices.places", &places, Domain::Texels)?;
        let turning = turning_strips(&setup.surface, &setup.strips);
        let turning = Buffer::from_slice_in(ctx, "choices.turning", &turning, Domain::Texels)?;
        let walks = |reach| {
            let pipeline = |walking| {
                let name = Way::Walk(reach, walking).kernel();
                Ok::<_, Error>(match walking {
                    Walking::Exact => WalkPipelines::Exact(Pipeline::named(ctx, &(), name)?),
                    _ => WalkPipelines::Corrected(Pipeline::named(ctx, &(), name)?),
                })
            };
            let [exact, corrected, once] = Walking::ALL.map(pipeline);
            Ok::<_, Error>([exact?, corrected?, once?])
        };
        let options = RasterOptions {
            color: Format::R32Float,
            depth: false,
            blend: Blend::Add,
            topology: Topology::Points,
            ..RasterOptions::default()
        };
        let size = [setup.atlas.pitch, setup.atlas.size];
        let image = Sampled::new(ctx, "choices.trail", size)?;
        let mut frames = Frames::new(ctx, 1)?;
        let mut rec = frames.begin()?;
        let trail = &simulation.state().trail.front;
        rec.copy_to_sampled(trail, &image);
        frames.submit(rec)?;
        frames.wait_idle()?;
        Ok(Self {
            ctx,
            simulation,
            speed: own.speed,
            sensor_offset: own.sensor_offset,
            attempts: params.attempts,
            start: Walkers::new(ctx, &snapshot.particles, &snapshot.motions)?,
            ends: Walkers::new(ctx, &snapshot.particles, &snapshot.motions)?,
            walks: [walks(Reach::Step)?, walks(Reach::Sensor)?],
            turning: Texels::new(&turning, 4)?,
            count: Pipeline::new(ctx, &())?,
            draw: RasterPipeline::new(ctx, &(), options)?,
            deposits: Buffer::zeroed(ctx, "choices.deposits", snapshot.deposits.len())?,
            target: Image::new(ctx, "choices.target", size, Format::R32Float, 1)?,
            place_texels: Texels::new(&place_buffer, 4)?,
            image,
            values: Buffer::zeroed(ctx, "choices.values", snapshot.particles.len())?,
            read_texels: Pipeline::new(ctx, &())?,
            read_block: Pipeline::new(ctx, &())?,
            read_storage_texels: Pipeline::new(ctx, &())?,
            read_image: Pipeline::new(ctx, &())?,
            read_sampler: Pipeline::new(ctx, &())?,
            snapshot,
        })
    }

    /// World length of a walk.
    pub fn length(&self, reach: Reach) -> f32 {
        match reach {
            Reach::Step => self.speed,
            Reach::Sensor => self.sensor_offset,
        }
    }

    /// Records one way, on the state that all begin from.
    pub fn record(&self, rec: &mut Recorder, way: Way) {
        match way {
            Way::Walk(reach, walking) => {
                self.walk(rec, reach, walking, &self.start, &self.ends);
            }
            Way::Count => self.count(rec),
            Way::Draw => self.draw(rec),
            Way::Read(binding) => self.read(rec, binding),
        }
    }

    fn walk(
        &self,
        rec: &mut Recorder,
        reach: Reach,
        walking: Walking,
        from: &Walkers,
        to: &Walkers,
    ) {
        let state = self.simulation.state();
        let particle_count = from.particles.len() as u32;
        let threads = Threads(particle_count);
        let way = self.length(reach);
        match &self.walks[reach as usize][walking as usize] {
            WalkPipelines::Exact(pipeline) => rec.dispatch(
                pipeline,
                threads,
                WalkExactlyArgs {
                    particles_before: &from.particle_texels,
                    motions_before: &from.motion_texels,
                    strips: &state.surface.strips,
                    particles: &to.particle_texels,
                    motions: &to.motion_texels,
                },
                WalkExactlyParams {
                    particle_count,
                    attempts: self.attempts,
                    way,
                },
            ),
            WalkPipelines::Corrected(pipeline) => rec.dispatch(
                pipeline,
                threads,
                WalkCorrectedArgs {
                    particles_before: &from.particle_texels,
                    motions_before: &from.motion_texels,
                    strips: &self.turning,
                    particles: &to.particle_texels,
                    motions: &to.motion_texels,
                },
                WalkCorrectedParams {
                    particle_count,
                    attempts: match walking {
                        Walking::CorrectedOnce => 1,
                        _ => self.attempts,
                    },
                    way,
                },
            ),
        }
    }

    /// Where walkers are after so many walks straight on.
    pub fn walked(
        &self,
        reach: Reach,
        walking: Walking,
        particles: &[Particle],
        motions: &[Motion],
        times: u32,
    ) -> Result<Vec<Particle>> {
        let mut pair = [
            Walkers::new(self.ctx, particles, motions)?,
            Walkers::new(self.ctx, particles, motions)?,
        ];
        let mut frames = Frames::new(self.ctx, 1)?;
        for _ in 0..times {
            let mut rec = frames.begin()?;
            self.walk(&mut rec, reach, walking, &pair[0], &pair[1]);
            frames.submit(rec)?;
            pair.swap(0, 1);
        }
        frames.wait_idle()?;
        Ok(self.ctx.download(&pair[0].particles)?)
    }

    fn count(&self, rec: &mut Recorder) {
        let state = self.simulation.state();
        rec.fill(&self.deposits, 0);
        let particle_count = self.start.particles.len() as u32;
        rec.dispatch(
            &self.count,
            Threads(particle_count),
            CountDepositsArgs {
                particles: &self.start.particle_texels,
                strips: &state.surface.strips,
                deposits: &self.deposits,
            },
            CountDepositsParams {
                particle_count,
                pitch: self.simulation.setup().atlas.pitch,
            },
        );
    }

    fn draw(&self, rec: &mut Recorder) {
        let [width, height] = self.target.size();
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
        rec.pass_as_kernel(Way::Draw.kernel(), &targets, |pass| {
            pass.draw(
                &self.draw,
                self.start.particles.len() as u32,
                1,
                DrawDepositsArgs {
                    particles: &self.start.particle_texels,
                    strips: &self.simulation.state().surface.strips,
                },
                DrawDepositsParams {
                    pixel: 2.0 / Vec2::new(width as f32, height as f32),
                },
            );
        });
    }

    /// How many particles each texel has, as counted and as drawn last.
    pub fn counts(&self) -> Result<[Vec<u32>; 2]> {
        let mut frames = Frames::new(self.ctx, 1)?;
        let [width, height] = self.target.size();
        let texels = (width * height) as usize;
        let drawn: Buffer<f32> = Buffer::zeroed(self.ctx, "choices.drawn", texels)?;
        let mut rec = frames.begin()?;
        rec.copy_image(&self.target, &drawn);
        frames.submit(rec)?;
        frames.wait_idle()?;
        let drawn = self.ctx.download(&drawn)?;
        let drawn = drawn.into_iter().map(|count| count as u32).collect();
        Ok([self.ctx.download(&self.deposits)?, drawn])
    }

    fn read(&self, rec: &mut Recorder, binding: Binding) {
        let trail = &self.simulation.state().trail;
        let particle_count = self.values.len() as u32;
        let threads = Threads(particle_count);
        let pitch = self.simulation.setup().atlas.pitch;
        let (places, values) = (&self.place_texels, &self.values);
        match binding {
            Binding::Texels => rec.dispatch(
                &self.read_texels,
                threads,
                ReadTexelsArgs {
                    places,
                    values,
                    trail: &trail.front.texels,
                },
                ReadTexelsParams {
                    particle_count,
                    pitch,
                },
            ),
            Binding::Block => rec.dispatch(
                &self.read_block,
                threads,
                ReadBlockArgs {
                    places,
                    values,
                    trail: &trail.front,
                },
                ReadBlockParams {
                    particle_count,
                    pitch,
                },
            ),
            Binding::StorageTexels => rec.dispatch(
                &self.read_storage_texels,
                threads,
                ReadStorageTexelsArgs {
                    places,
                    values,
                    trail: &trail.front.low,
                },
                ReadStorageTexelsParams {
                    particle_count,
                    pitch,
                },
            ),
            Binding::Image => rec.dispatch(
                &self.read_image,
                threads,
                ReadImageArgs {
                    places,
                    values,
                    trail: &self.image,
                },
                ReadImageParams { particle_count },
            ),
            Binding::Sampler => {
                let [width, height] = self.image.image().size();
                rec.dispatch(
                    &self.read_sampler,
                    threads,
                    ReadSamplerArgs {
                        places,
                        values,
                        trail: &self.image,
                    },
                    ReadSamplerParams {
                        particle_count,
                        texel: 1.0 / Vec2::new(width as f32, height as f32),
                    },
                );
            }
        }
    }

    /// What sensors read, one sum a particle.
    pub fn read_alone(&self, binding: Binding) -> Result<Vec<f32>> {
        let mut frames = Frames::new(self.ctx, 1)?;
        let mut rec = frames.begin()?;
        self.read(&mut rec, binding);
        frames.submit(rec)?;
        frames.wait_idle()?;
        Ok(self.ctx.download(&self.values)?)
    }
}
