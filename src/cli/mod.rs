//! The command line: one file a subcommand, and what they share.
//!
//! Data goes to the standard output or to files that options name; messages and progress go to the standard error.

mod compare;
mod console;
mod files;
mod info;
mod interrupt;
mod lab;
mod options;
mod profile;
mod query;
mod render;
mod report;
mod scenes;

use std::ffi::OsStr;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use myxo::Error;

/// Physarum on the surfaces of moving 3D objects.
///
/// Without a subcommand, `myxo` opens the lab with the scene `torus`.
#[derive(Debug, Parser)]
#[command(name = "myxo", version, max_term_width = 100, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const AFTER_HELP: &str = "\
Examples:
  myxo                                           open the lab
  myxo render torus --steps 400 --out torus.png  a picture without a window
  myxo profile cube --steps 200                  GPU time of every kernel
  myxo scenes                                    built-in scenes and presets
  myxo info                                      devices, and what is missing

SCENE is a built-in name, a .toml file, or a model (.obj, .glb, .gltf).

Exit codes:
  0    done
  1    failed; the reason is on the standard error (compare: the states differ)
  2    the command line could not be understood (compare: a report could not be read)
  130  interrupted by Ctrl-C; files are finished";

#[derive(Debug, Subcommand)]
enum Command {
    Lab(lab::Lab),
    Render(render::Render),
    Profile(profile::Profile),
    Query(query::Query),
    Compare(compare::Compare),
    Scenes(scenes::Scenes),
    Info(info::Info),
}

/// How a command that did not fail has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// As asked.
    Done,
    /// With the answer no: what was compared differs.
    Differs,
    /// Early, by Ctrl-C; what there was has been kept.
    #[expect(dead_code, reason = "long runs end with it")]
    Interrupted,
}

impl Outcome {
    fn exit_code(self) -> ExitCode {
        match self {
            Self::Done => ExitCode::SUCCESS,
            Self::Differs => ExitCode::from(1),
            Self::Interrupted => ExitCode::from(interrupt::EXIT_CODE),
        }
    }
}

/// Reads the command line, does what it says, and gives the exit code.
pub fn main() -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("warn")).format_timestamp(None).init();
    let cli = Cli::parse();
    let result = match &cli.command {
        None => lab::Lab::default().run(),
        Some(Command::Lab(lab)) => lab.run(),
        Some(Command::Render(render)) => render.run(),
        Some(Command::Profile(profile)) => profile.run(),
        Some(Command::Query(query)) => query.run(),
        Some(Command::Compare(compare)) => compare.run(),
        Some(Command::Scenes(scenes)) => scenes.run(),
        Some(Command::Info(info)) => info.run(),
    };
    match result {
        Ok(outcome) => outcome.exit_code(),
        // Whoever reads the output has read enough, as `head` does.
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            console::message(&format!("myxo: {error}"));
            ExitCode::from(if matches!(cli.command, Some(Command::Compare(_))) { 2 } else { 1 })
        }
    }
}

fn is_closed_pipe(error: &Error) -> bool {
    matches!(error, Error::Io { path, source, .. }
        if path.as_os_str() == OsStr::new(console::STDOUT) && source.kind() == std::io::ErrorKind::BrokenPipe)
}

/// What stands where a command needs a part of the program that this build lacks.
fn not_built_in(part: &str) -> Error {
    Error::Invalid(format!("{part} is not built into this myxo: build a later version"))
}

#[cfg(test)]
mod tests;
