//! `myxo query diffuse`: how deposits spread over a surface.
//!
//! Deposits are put on the texels that particles there would use, spread by the kernels of the simulation, and the result is written texel
//! by texel.

use std::fmt::Write as _;
use std::iter::once;
use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use myxo::gpu::{Context, ContextOptions};
use myxo::mesh::Mesh;
use myxo::mesh::atlas::Atlas;
use myxo::mesh::surface::{NONE, Surface};
use myxo::mesh::walk::SurfacePoint;
use myxo::scene::settings::{AtlasMethod, Settings};
use myxo::sim::diffusion::Diffusion;
use myxo::sim::memory;
use myxo::{Error, Result};

use super::table::{Row, Table};
use super::{check_messages, open_mesh, options_of};
use crate::cli::files::{Sink, check_unread};
use crate::cli::options::DeviceOptions;
use crate::cli::progress::{Progress, SettingUp, atlas_cache};
use crate::cli::{Command, Outcome, interrupt};
use crate::{console, room};

/// Spread deposits over a mesh, without decay, and list the trail of every texel
///
/// In:  id,face,b0,b1,b2,amount
/// Out: face,b0,b1,b2,area,value,chart
///
/// Faces are counted from 0 in the order of the file, polygons cut into
/// triangles. b0, b1 and b2 are the weights of a face's first, second and third
/// corner in the file: they sum to 1, and the point is b0 v0 + b1 v1 + b2 v2.
/// A deposit adds amount / area to its texel. In every step each texel then
/// moves half the way towards the mean of the 3 x 3 texels around it. The sum of
/// value * area does not change. Out has a row for each texel that belongs to a
/// face, with the place of its middle.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query diffuse --mesh fish.obj --in spots.csv --steps 1000 --atlas-size 512 --out trail.csv
  myxo query diffuse --mesh builtin:cube --steps 100 --atlas-size 256 --turn 3 < spots.csv | head"
)]
pub struct Diffuse {
    /// A model (.obj, .stl, .ply, .glb, .gltf), or builtin:NAME
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// The deposits; - for the standard input
    #[arg(long = "in", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Steps to spread for, 0 to 1,000,000
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(..=1_000_000))]
    steps: u64,
    /// Side of the trail's texture, texels
    #[arg(long, value_name = "S")]
    atlas_size: u32,
    /// How triangles are laid out in it
    #[arg(long, value_name = "WORD", default_value = Settings::default().atlas.method.word())]
    #[arg(value_parser = super::atlas_method())]
    atlas_method: AtlasMethod,
    /// Turns each chart by a random angle that this number decides; 0 turns none
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    turn: u64,
    /// The file for the trail; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    #[command(flatten)]
    device: DeviceOptions,
}

const COLUMNS: &[&str] = &["id", "face", "b0", "b1", "b2", "amount"];
const HEADER: &str = "face,b0,b1,b2,area,value,chart";

/// Width of the gutter in texels, and the distance between the taps of diffusion.
const GUTTER: u32 = 1;

/// The share by which a texel moves towards the mean in a step.
const DIFFUSION: f32 = 0.5;

/// Weights whose sum is off from 1 by less than this count as rounded and are normalised; others are refused.
const WEIGHTS_MAY_BE_OFF: f64 = 1e-5;

impl Command for Diffuse {
    /// Reads, spreads, writes.
    fn run(&self) -> Result<Outcome> {
        let mesh = open_mesh(&self.mesh)?;
        let table = Table::read(&self.input, COLUMNS)?;
        check_unread(once(&self.out), "")?;
        let spots = table
            .rows()
            .map(|row| Spot::read(row, &mesh))
            .collect::<Result<Vec<_>>>()?;
        // Installed only after the input is read, so that Ctrl-C ends the program at once while a table is typed.
        interrupt::install()?;
        let sink = Sink::create(&self.out)?;
        let ctx = Context::new(&ContextOptions {
            device: self.device.device.clone(),
            validation: self.device.validate,
            ..ContextOptions::default()
        })?;
        let largest = memory::largest_atlas(ctx.info());
        if u64::from(self.atlas_size) > largest {
            return Err(Error::Invalid(format!(
                "--atlas-size {} is too large for {}: use at most {largest}",
                self.atlas_size,
                ctx.info().name
            )));
        }
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let options = options_of(self.atlas_method, self.atlas_size, GUTTER, self.turn);
        let atlas = SettingUp::new(&mesh.name, atlas_cache())
            .run(|control| Atlas::build_with(&surface, &options, control))
            .map_err(|error| memory::atlas_error(ctx.info(), &Settings::default(), error))
            .map_err(|error| room::atlas_error(error, "--atlas-size", "--atlas-method"))?;
        if self.device.validate {
            atlas.validate(&surface).map_err(Error::Invalid)?;
        }
        let trail = Trail::new(&atlas, &spots)?;

        let mut diffusion = Diffusion::new(&ctx, &atlas, DIFFUSION)?;
        diffusion.set(&trail.values)?;
        let mut progress = Progress::new(self.steps, &mesh.name);
        diffusion.run(self.steps, |steps| {
            (0..steps).for_each(|_| progress.step());
            !interrupt::requested()
        })?;
        progress.finish();
        if interrupt::requested() {
            return Ok(Outcome::Interrupted);
        }
        let values = diffusion.values()?;
        check_messages(&ctx)?;
        let left = trail.unit * mass(&atlas, &values);
        console::message(&format!(
            "{atlas}\ndeposited {}, and {} after {} steps",
            amount(deposited(&spots)),
            amount(left),
            self.steps
        ));
        sink.write(answer(&mesh, &atlas, &values, trail.unit))?;
        Ok(Outcome::Done)
    }
}

/// The sum of all deposits.
fn deposited(spots: &[Spot]) -> f64 {
    // The sum of no numbers at all is -0.
    spots.iter().fold(0.0, |sum, spot| sum + spot.amount)
}

/// An amount with as few digits as possible, very large and very small ones with an exponent.
fn amount(amount: f64) -> String {
    match amount {
        0.0 => "0".to_owned(),
        _ if (1e-6..1e15).contains(&amount.abs()) => amount.to_string(),
        _ => format!("{amount:e}"),
    }
}

/// A deposit.
#[derive(Clone, Copy, Debug)]
struct Spot {
    point: SurfacePoint,
    amount: f64,
}

impl Spot {
    fn read(row: Row<'_>, mesh: &Mesh) -> Result<Self> {
        let wrong = |problem: String| Error::Invalid(format!("{}: {problem}", row.place()));
        let face = row.integer(1)?;
        let weights = DVec3::new(row.number(2)?, row.number(3)?, row.number(4)?);
        let amount = row.number(5)?;
        let sum = weights.element_sum();
        if weights.min_element() < -WEIGHTS_MAY_BE_OFF || (sum - 1.0).abs() > WEIGHTS_MAY_BE_OFF {
            return Err(wrong("b0, b1, b2 are not weights that sum to 1".to_owned()));
        }
        if amount < 0.0 {
            return Err(wrong("the amount is negative".to_owned()));
        }
        let weights = weights.max(DVec3::ZERO);
        let weights = weights / weights.element_sum();
        let point = u32::try_from(face)
            .ok()
            .and_then(|face| mesh.point_from_file(face, weights.to_array()))
            .ok_or_else(|| wrong(format!("the mesh has no face {face} to deposit on")))?;
        Ok(Self { point, amount })
    }
}

/// The deposits as a trail.
#[derive(Debug)]
struct Trail {
    /// Per texel, in `unit`s.
    values: Vec<f32>,
    /// The trail if the deposits were spread evenly. With it as the unit, the device computes with numbers near 1, whatever the amounts
    /// are.
    unit: f64,
}

impl Trail {
    fn new(atlas: &Atlas, spots: &[Spot]) -> Result<Self> {
        let area: f64 = atlas.area.iter().map(|&area| f64::from(area)).sum();
        let mut unit = deposited(spots) / area;
        if !unit.is_finite() {
            return Err(Error::Invalid(
                "the amounts sum to more than a number can hold".to_owned(),
            ));
        }
        if unit == 0.0 {
            unit = 1.0;
        }
        let mut sums = vec![0.0; atlas.texel_count()];
        let mut add = |texel: u32, amount: f64| {
            sums[texel as usize] += amount / f64::from(atlas.area[texel as usize]);
        };
        for spot in spots {
            let SurfacePoint { triangle, u, v } = spot.point;
            let texel = atlas.texel_of(triangle, u as f32, v as f32);
            let amount = spot.amount / unit;
            if atlas.owner[texel as usize] != NONE {
                add(texel, amount);
                continue;
            }
            // Into the owned texels that the gutter texel is filled from.
            let seam = atlas.seams.binary_search_by_key(&texel, |seam| seam.texel);
            let seam = &atlas.seams[seam.expect("a triangle lies in owned and gutter texels")];
            for (source, weight) in seam.source.into_iter().zip(seam.weights()) {
                add(source, f64::from(weight) * amount);
            }
        }
        Ok(Self {
            values: sums.into_iter().map(|sum: f64| sum as f32).collect(),
            unit,
        })
    }
}

/// The sum of value times area.
fn mass(atlas: &Atlas, values: &[f32]) -> f64 {
    let masses = values.iter().zip(&atlas.area);
    masses
        .map(|(&value, &area)| f64::from(value) * f64::from(area))
        .sum()
}

/// The rows of all owned texels.
fn answer(mesh: &Mesh, atlas: &Atlas, values: &[f32], unit: f64) -> String {
    let mut text = format!("{HEADER}\n");
    for (texel, &value) in values.iter().enumerate() {
        let Some((triangle, u, v)) = atlas.surface_point_of(texel as u32) else {
            continue;
        };
        let (u, v) = (f64::from(u), f64::from(v));
        let (face, [b0, b1, b2]) = mesh.point_to_file(SurfacePoint { triangle, u, v });
        let area = f64::from(atlas.area[texel]);
        let value = unit * f64::from(value);
        let chart = atlas.chart[triangle as usize];
        let _ = writeln!(text, "{face},{b0},{b1},{b2},{area},{value},{chart}");
    }
    text
}

#[cfg(test)]
mod tests;
