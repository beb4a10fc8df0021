//! The command line: one file a subcommand, and what they share.
//!
//! Data goes to the standard output or to files that options name; messages and progress go to the standard error.

mod atlas;
mod bench;
mod compare;
mod damaged;
mod export;
mod files;
mod info;
mod interrupt;
mod lab;
mod letters;
mod network;
mod options;
mod outputs;
mod pixels;
mod profile;
mod progress;
mod query;
mod ratios;
mod render;
mod scenes;
mod selftest;
mod session;
mod sweep;

use std::ffi::{OsStr, OsString};
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};
use myxo::mesh::atlas::AtlasError;
use myxo::plain_text::is_control;
use myxo::scene::builtin::SCENES;
use myxo::{Error, Result, signals};

/// Physarum on the surfaces of 3D objects.
///
/// Without a subcommand, `myxo` opens the lab with the scene `oats`.
#[derive(Debug, Parser)]
#[command(name = "myxo", version, max_term_width = 100, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Commands>,
}

const AFTER_HELP: &str = "\
Examples:
  myxo                                           open the lab
  myxo render torus --steps 400 --out torus.png  a picture without a window
  myxo export torus --steps 400 --out torus.glb  the same as a model, as data, as a scene
  myxo network oats --steps 800 --out oats.json  the network as a graph
  myxo sweep study.toml --out study              many runs, and a table of them
  myxo profile cube --steps 200                  GPU time of every kernel
  myxo bench --quick                             how times grow with particles, texture, objects, ...
  myxo atlas suzanne --out atlas.png             how a mesh lies in the texture
  myxo scenes                                    built-in scenes and presets
  myxo info                                      devices, and what is missing
  myxo selftest                                  do results on this machine match the reference hashes?

SCENE is a built-in name, a .toml file, a model (.obj, .stl, .ply, .glb, .gltf), or a built-in
mesh with or without options (builtin:torus?tube=0.2).

Exit codes:
  0    done
  1    failed; the reason is on the standard error (compare: the states differ)
  2    the command line could not be understood (compare: a report could not be read)
  130  interrupted by Ctrl-C; files are finished";

/// A command: the options that clap has read, and what it does with them.
trait Command {
    /// Runs the command.
    fn run(&self) -> Result<Outcome>;

    /// The exit code if [`Command::run`] fails.
    fn exit_code_of_failure(&self) -> u8 {
        1
    }
}

/// Declares an enum of commands, one line each: its variant gives the command its name, its options are a [`Command`].
macro_rules! commands {
    ($name:ident { $($command:ident($options:ty),)+ }) => {
        // Without a comment for documentation: clap would print it in the help.
        #[derive(Clone, Debug, Subcommand)]
        enum $name {
            $($command($options),)+
        }

        impl $name {
            /// The chosen command.
            fn chosen(&self) -> &dyn Command {
                match self {
                    $(Self::$command(options) => options,)+
                }
            }
        }
    };
}
use commands;

use crate::console;
use crate::measured::{counters, host, measures, report, settings, table, times, tracing};

commands! {
    Commands {
        Lab(lab::Lab),
        Render(render::Render),
        Export(export::ExportCommand),
        Profile(profile::Profile),
        Network(network::Network),
        Sweep(sweep::Sweep),
        Bench(bench::Bench),
        Atlas(atlas::Atlas),
        Query(query::Query),
        Compare(compare::Compare),
        Scenes(scenes::Scenes),
        Info(info::Info),
        Selftest(selftest::SelfTest),
        SweepWorker(sweep::SweepWorker),
    }
}

/// How a command that did not fail has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// As asked.
    Done,
    /// The compared states differ.
    Differs,
    /// Partly failed; the errors have been printed.
    Failed,
    /// Ended early by Ctrl-C; the results so far are kept.
    Interrupted,
}

impl Outcome {
    fn exit_code(self) -> ExitCode {
        match self {
            Self::Done => ExitCode::SUCCESS,
            Self::Differs | Self::Failed => ExitCode::from(1),
            Self::Interrupted => ExitCode::from(interrupt::EXIT_CODE),
        }
    }
}

/// Reads the command line, runs the command, and returns the exit code.
pub fn main() -> ExitCode {
    signals::ignore_file_size_limit();
    console::log();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return print_clap_message(&with_hint(error)),
    };
    let lab = lab::Lab::default();
    let command = (cli.command.as_ref()).map_or(&lab as &dyn Command, Commands::chosen);
    match command.run() {
        Ok(outcome) => outcome.exit_code(),
        // The reader of the output has closed it, as `head` does.
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error @ Error::Atlas(AtlasError::Cancelled)) => {
            console::message(&format!("myxo: {error}"));
            Outcome::Interrupted.exit_code()
        }
        Err(error) => {
            console::message(&format!("myxo: {error}"));
            ExitCode::from(command.exit_code_of_failure())
        }
    }
}

/// Prints help, the version or a usage error. Help that cannot be written is an error.
fn print_clap_message(error: &clap::Error) -> ExitCode {
    let is_plain = |argument: OsString| !argument.to_string_lossy().contains(is_control);
    let printed = if std::env::args_os().all(is_plain) {
        error.print().and_then(|()| std::io::stdout().flush())
    } else {
        // Names of files that the shell has filled in may hold control characters.
        console::message(&error.to_string());
        Ok(())
    };
    match printed {
        Err(source) if !error.use_stderr() && source.kind() != std::io::ErrorKind::BrokenPipe => {
            let error = Error::io("write to", console::STDOUT)(source);
            console::message(&format!("myxo: {error}"));
            Outcome::Failed.exit_code()
        }
        _ => ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(1)),
    }
}

/// If a scene stands in the place of a command, the hint says how to open it.
fn with_hint(mut error: clap::Error) -> clap::Error {
    if error.kind() != ErrorKind::InvalidSubcommand {
        return error;
    }
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    let is_scene = SCENES.iter().any(|scene| scene.name == word) || Path::new(word).is_file();
    if is_scene {
        let hint = format!("to open it in the window: myxo lab {word}");
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(vec![hint.into()]),
        );
    }
    error
}

/// Takes a standard output that its reader has closed, as `head` does, for success: the exit code is then that of the work.
fn unless_closed(printed: Result<()>) -> Result<()> {
    match printed {
        Err(error) if is_closed_pipe(&error) => Ok(()),
        printed => printed,
    }
}

fn is_closed_pipe(error: &Error) -> bool {
    matches!(error, Error::Io { path, source, .. }
        if path.as_os_str() == OsStr::new(console::STDOUT) && source.kind() == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn a_scene_without_a_command_gives_a_hint_how_to_open_it() {
        let hint_for = |word: &str| {
            let parsed = Cli::try_parse_from(["myxo", word]);
            with_hint(parsed.expect_err(word)).to_string()
        };
        for word in ["cube", concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")] {
            let text = hint_for(word);
            assert!(text.contains(&format!("myxo lab {word}")), "{text}");
        }
        assert!(!hint_for("cuboid").contains("myxo lab"));
        assert!(hint_for("rendr").contains("render"));
    }

    /// clap's own check of names, defaults and conflicts.
    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_has_examples_and_explains_its_options() {
        fn check(command: &clap::Command) {
            // What the program runs itself.
            if command.is_hide_set() {
                return;
            }
            let name = command.get_name();
            assert!(command.get_about().is_some(), "{name} says what it does");
            for argument in command.get_arguments() {
                assert!(
                    argument.get_help().is_some(),
                    "{name}: {} says what it does",
                    argument.get_id()
                );
            }
            if command.has_subcommands() {
                command.get_subcommands().for_each(check);
            } else {
                let examples = command
                    .get_after_help()
                    .map(ToString::to_string)
                    .unwrap_or_default();
                assert!(
                    examples.starts_with("Examples:\n  myxo ") && examples.contains(name),
                    "{name}: {examples}"
                );
            }
        }
        Cli::command().get_subcommands().for_each(check);
    }

    /// The examples in the help are command lines that the program takes.
    #[test]
    fn every_example_parses() {
        fn examples(command: &clap::Command, found: &mut Vec<String>) {
            let text = command
                .get_after_help()
                .map(ToString::to_string)
                .unwrap_or_default();
            found.extend(
                text.lines()
                    .filter_map(|line| line.strip_prefix("  "))
                    .filter(|line| line.starts_with("myxo"))
                    .map(str::to_owned),
            );
            command
                .get_subcommands()
                .for_each(|command| examples(command, found));
        }
        let mut found = Vec::new();
        examples(&Cli::command(), &mut found);
        assert!(found.len() > 15, "{found:#?}");
        for example in found {
            // Explanations stand behind several blanks; quotes, pipes and the like are removed as a shell would.
            let line = example.split("  ").next().unwrap_or_default();
            let line = line
                .split(['<', '>', '|', '&'])
                .next()
                .unwrap_or_default()
                .replace('\'', "");
            if let Err(error) = Cli::try_parse_from(line.split_whitespace()) {
                panic!("{line}: {error}");
            }
        }
    }

    #[test]
    fn exit_codes_are_as_documented() {
        for code in ["0 ", "1 ", "2 ", "130 "] {
            assert!(
                AFTER_HELP
                    .lines()
                    .any(|line| line.trim_start().starts_with(code)),
                "{code}"
            );
        }
        assert_eq!(Outcome::Interrupted.exit_code(), ExitCode::from(130));
        assert_eq!(Outcome::Differs.exit_code(), ExitCode::from(1));
    }

    #[test]
    fn sizes_are_read_as_people_write_them() {
        let size = |text: &str| {
            text.parse::<options::Size>()
                .ok()
                .map(|size| (size.width, size.height))
        };
        assert_eq!(size("1280x720"), Some((1280, 720)));
        assert_eq!(size("16384X1"), Some((16_384, 1)));
        for wrong in ["", "1280", "0x5", "5x0", "16385x1", "axb", "1x2x3", "-1x5"] {
            assert_eq!(size(wrong), None, "{wrong}");
        }
    }
}
