//! The trail's diffusion alone, without particles, deposits and decay, for `myxo query diffuse`.

use std::sync::Arc;

use super::buffers::{self, Counts};
use super::kernels::{
    Diffuse, DiffuseArgs, DiffuseConstants, DiffuseParams, DiffuseSeams, DiffuseSeamsArgs,
    DiffuseSeamsConstants, DiffuseSeamsParams,
};
use super::memory;
use super::spread::spreading;
use super::texel_paths::TexelPaths;
use super::texture::{PingPong, SpreadTables};
use crate::error::{Error, Result};
use crate::gpu::{Context, Frames, Pipeline, Recorder, Threads};
use crate::mesh::atlas::Atlas;

/// Steps that are submitted to the device together.
const BATCH: u64 = 16;

/// The largest distance between the taps of `diffuse.comp`, texels: it reads no farther than the next four.
const GREATEST_DISTANCE: u32 = 4;

/// A trail on an atlas that only spreads.
pub struct Diffusion {
    ctx: Arc<Context>,
    diffuse: Pipeline<Diffuse>,
    diffuse_seams: Pipeline<DiffuseSeams>,
    params: DiffuseParams,
    seams_params: DiffuseSeamsParams,
    tables: SpreadTables,
    deposits: PingPong<u32>,
    /// The trail, and the target of its next step.
    trail: PingPong<f32>,
}

impl Diffusion {
    /// An empty trail that spreads by `diffusion` a step, at most as much as one pass takes on the atlas, over the taps that the atlas was made for.
    ///
    /// # Errors
    /// When the device fails, a buffer is larger than it allows, or the atlas was made for taps that are too far apart.
    ///
    /// # Panics
    /// When the diffusion is greater.
    pub fn new(ctx: &Arc<Context>, atlas: &Atlas, diffusion: f32) -> Result<Self> {
        assert!(
            (0.0..=atlas.greatest_diffusion).contains(&diffusion),
            "{diffusion}"
        );
        let distance = taps_distance(atlas.taps)?;
        memory::check_atlas(ctx.info(), atlas, atlas.size)?;
        let texels = atlas.texel_count();
        let (params, seams_params) = spreading(atlas);
        let paths = TexelPaths::of(ctx.info(), texels as u64);
        let constants = DiffuseConstants {
            distance,
            own_rates: false,
            paths,
        };
        let seams_constants = DiffuseSeamsConstants {
            own_rates: false,
            paths,
        };
        let counts = Counts {
            texels: texels as u64,
            ..Counts::default()
        };
        Ok(Self {
            diffuse: Pipeline::new(ctx, &constants)?,
            diffuse_seams: Pipeline::new(ctx, &seams_constants)?,
            params: DiffuseParams {
                diffusion,
                ..params
            },
            seams_params: DiffuseSeamsParams {
                diffusion,
                ..seams_params
            },
            tables: SpreadTables::new(ctx, atlas)?,
            deposits: PingPong::of(
                ctx,
                buffers::DEPOSITS_FRONT.zeroed(ctx, &counts)?,
                buffers::DEPOSITS_BACK.zeroed(ctx, &counts)?,
            )?,
            trail: PingPong::of(
                ctx,
                buffers::TRAIL_FRONT.zeroed(ctx, &counts)?,
                buffers::TRAIL_BACK.zeroed(ctx, &counts)?,
            )?,
            ctx: ctx.clone(),
        })
    }

    /// Sets the value of every texel.
    ///
    /// # Errors
    /// When the device fails.
    pub fn set(&mut self, trail: &[f32]) -> Result<()> {
        Ok(self.ctx.upload(&self.trail.front, trail)?)
    }

    /// The value of every texel; of owned ones, gutters are not filled.
    ///
    /// # Errors
    /// When the device fails.
    pub fn values(&self) -> Result<Vec<f32>> {
        Ok(self.ctx.download(&self.trail.front)?)
    }

    /// Spreads for `steps` steps. Reports at intervals how many more are done, and stops when the callback returns `false`.
    ///
    /// # Errors
    /// When the device fails.
    pub fn run(&mut self, steps: u64, mut go_on: impl FnMut(u64) -> bool) -> Result<()> {
        let mut frames = Frames::new(&self.ctx, 2)?;
        let mut left = steps;
        while left > 0 {
            let batch = left.min(BATCH);
            let mut rec = frames.begin()?;
            for _ in 0..batch {
                self.record(&mut rec);
                self.trail.swap();
            }
            frames.submit(rec)?;
            left -= batch;
            if !go_on(batch) {
                break;
            }
        }
        Ok(frames.wait_idle()?)
    }

    fn record(&self, rec: &mut Recorder) {
        rec.dispatch(
            &self.diffuse,
            Threads(self.params.lane_count),
            DiffuseArgs {
                blocks: &self.tables.blocks,
                trail: &self.trail.front,
                deposits: &self.deposits.front,
                density: &self.tables.density,
                next_trail: &self.trail.back,
                previous_deposits: &self.deposits.back,
                objects: None,
                rates: None,
            },
            self.params,
        );
        rec.dispatch(
            &self.diffuse_seams,
            Threads(self.seams_params.row_count),
            DiffuseSeamsArgs {
                rows: &self.tables.rows,
                entries: &self.tables.entries,
                trail: &self.trail.front,
                deposits: &self.deposits.front,
                next_trail: &self.trail.back,
                objects: None,
                rates: None,
            },
            self.seams_params,
        );
    }
}

/// How far from each other the taps are, as the kernel takes it.
fn taps_distance(taps: u32) -> Result<i32> {
    if taps > GREATEST_DISTANCE {
        return Err(Error::Invalid(format!(
            "trails spread over the taps that the atlas was made for, which are {taps} texels apart: use {GREATEST_DISTANCE} at most"
        )));
    }
    Ok(taps as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn taps_are_no_farther_apart_than_the_kernel_looks() {
        for taps in 1..=4 {
            assert_eq!(taps_distance(taps).ok(), Some(taps as i32));
        }
        for taps in [5, 64] {
            let message = taps_distance(taps).unwrap_err().to_string();
            assert!(message.ends_with("use 4 at most"), "{message}");
        }
    }
}
