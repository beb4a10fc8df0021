//! `myxo query`: questions in CSV, answers in CSV, answered by the code that the simulation runs.

mod atlas;
mod diffuse;
mod geodesic;
mod pair;
mod sdf;
mod table;
mod transfer;
mod walks;

use std::path::Path;
use std::sync::Arc;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand, ValueEnum};
use glam::DVec3;
use myxo::gpu::{Context, ContextOptions};
use myxo::mesh::Mesh;
use myxo::mesh::atlas::AtlasOptions;
use myxo::scene::settings::{AtlasMethod, Settings, SignRule};
use myxo::sim::atlas_options;
use myxo::{Error, Result};

use super::files::Sink;
use super::options::DeviceOptions;
use super::{Command, Outcome, commands, interrupt};

/// Answer questions about meshes, CSV in and CSV out
#[derive(Clone, Debug, Args)]
pub struct Query {
    #[command(subcommand)]
    kind: Kind,
}

commands! {
    Kind {
        Atlas(atlas::Atlas),
        Diffuse(diffuse::Diffuse),
        Geodesic(geodesic::Geodesic),
        Sdf(sdf::Sdf),
        Transfer(transfer::Transfer),
    }
}

impl Command for Query {
    /// Answers the questions.
    fn run(&self) -> Result<Outcome> {
        self.kind.chosen().run()
    }
}

/// Runs `ask` on a device; fails if the validation layers complain.
fn with_device<T>(
    options: &DeviceOptions,
    ask: impl FnOnce(&Arc<Context>) -> Result<T>,
) -> Result<T> {
    let ctx = Context::new(&ContextOptions {
        device: options.device.clone(),
        validation: options.validate,
        ..ContextOptions::default()
    })?;
    let answer = ask(&ctx)?;
    check_messages(&ctx)?;
    Ok(answer)
}

/// Fails with the messages of the validation layers, if there are any.
fn check_messages(ctx: &Context) -> Result<()> {
    let messages = ctx.take_messages();
    if messages.is_empty() {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "the validation layers report: {}",
        messages.join("\n")
    )))
}

/// The mesh moved so that the middle of its box is the origin, and that middle. Far from the origin no digits are lost then.
fn about_its_middle(mesh: &Mesh) -> (DVec3, Mesh) {
    let (low, high) = mesh.bounds();
    let centre = 0.5 * (low.as_dvec3() + high.as_dvec3());
    let mut mesh = mesh.clone();
    for position in &mut mesh.positions {
        *position = (position.as_dvec3() - centre).as_vec3();
    }
    mesh.origin += centre;
    (mesh.origin, mesh)
}

/// The length of a vector whose squares may overflow.
fn length(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    if largest > 1e150 {
        largest * (v / largest).length()
    } else {
        v.length()
    }
}

/// The vector, shortened to this length if it is longer.
fn shortened(v: DVec3, longest: f64) -> DVec3 {
    let length = length(v);
    if length > longest {
        longest * (v / length)
    } else {
        v
    }
}

/// How the sign of a distance is found.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Sign {
    /// By the normal of the nearest face, edge or vertex
    Pseudonormal,
    /// By the winding number, also right where the mesh has holes
    Winding,
    /// Outside if any of equally near faces looks towards the place
    Facing,
}

impl From<Sign> for SignRule {
    fn from(sign: Sign) -> Self {
        match sign {
            Sign::Pseudonormal => Self::Pseudonormal,
            Sign::Winding => Self::Winding,
            Sign::Facing => Self::Facing,
        }
    }
}

/// Writes an answer; [`Sink::check`] was called before the work. Until here Ctrl-C ends the program at once, so no temporary file may exist
/// yet.
fn write_answer(out: &Path, answer: &str) -> Result<()> {
    interrupt::install()?;
    Sink::create(out)?.write(answer)
}

/// The mesh that `--mesh` names, in its own coordinates.
fn open_mesh(name: &Path) -> Result<Mesh> {
    Ok(match name.to_str() {
        Some(builtin) if builtin.starts_with("builtin:") => Mesh::builtin(builtin)?,
        _ => Mesh::load_raw(name)?,
    })
}

/// The ways to lay triangles out, by the words that scene files use.
fn atlas_method() -> impl TypedValueParser<Value = AtlasMethod> {
    PossibleValuesParser::new(AtlasMethod::WORDS).map(|word| {
        let mut methods = AtlasMethod::ALL.iter().copied();
        let method = methods.find(|method| method.word() == word);
        method.expect("clap lets only words through")
    })
}

/// The options of an atlas of a single mesh.
fn options_of(method: AtlasMethod, size: u32, gutter: u32, turn: u64) -> AtlasOptions {
    let mut settings = Settings::default();
    settings.atlas.method = method;
    settings.atlas.size = size;
    AtlasOptions {
        gutter,
        turn,
        ..atlas_options(&settings)
    }
}
