//! Options that several commands take.

use std::path::{Path, PathBuf};

use clap::Args;
use myxo::Result;
use myxo::scene::{Overrides, Scene, builtin};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sweep::{LONGEST_SIDE, picture_size};

use super::files;
use crate::own_presets::OwnPresets;

/// Options that change a scene.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Scene")]
pub struct SceneOptions {
    /// Sets a key of the scene file; `myxo scenes --keys` lists them. May be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Takes the look of a preset: one that `myxo scenes` lists, or a .toml file
    #[arg(long, value_name = "NAME|FILE")]
    pub preset: Option<String>,
    /// Everything random depends on it: the same scene and seed give the same bits
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

impl SceneOptions {
    /// In the form that scenes take: preset, then `--set`, then the seed.
    pub fn overrides(&self) -> Overrides {
        Overrides {
            preset: self.preset.clone().map(named_preset),
            set: self.set.clone(),
            seed: self.seed,
        }
    }
}

/// The preset of this name; for one that was kept in the window, its file.
fn named_preset(wanted: String) -> String {
    if builtin::preset(&wanted).is_some() || Path::new(&wanted).is_file() {
        return wanted;
    }
    let own = OwnPresets::folder().map(|folder| folder.join(format!("{wanted}.toml")));
    let own = own.filter(|own| own.is_file());
    own.and_then(|own| own.into_os_string().into_string().ok())
        .unwrap_or(wanted)
}

/// The device, and its checks.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Device")]
pub struct DeviceOptions {
    /// Computes on this device: its number or a part of its name, as `myxo info` lists them
    #[arg(long, value_name = "N|NAME")]
    pub device: Option<String>,
    /// Turns on Vulkan's validation layers; slower. render, export, network and profile also check the invariants of the state after every
    /// step, and lab once a second at the most
    #[arg(long)]
    pub validate: bool,
    /// Asks the driver what it has compiled.
    #[arg(skip)]
    pub compiler_reports: bool,
}

/// Options for the state of a run: what is saved, and what it continues from.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "State")]
pub struct StateOptions {
    /// Writes the whole state here at the end, also when interrupted
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Continues from the state in this file, with its own scene if none is named
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Lets outputs replace files that the run reads, such as --checkpoint the file of --resume
    #[arg(long)]
    pub overwrite_input: bool,
    /// Lists the state hash every N steps
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub hash_every: Option<u32>,
    /// Lists measures of the network every N steps and at the end: its length, pieces and more; where there is a --report, it has them, too
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub measure_every: Option<u32>,
}

/// The options of every command with a scene.
#[derive(Clone, Debug, Default, Args)]
pub struct CommonOptions {
    #[command(flatten)]
    pub scene: SceneOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub state: StateOptions,
}

impl CommonOptions {
    /// Loads the scene, and makes sure that the files of [`StateOptions`] are there and can be written. Without a scene it loads that of
    /// the checkpoint.
    pub fn load(&self, scene: Option<&Path>) -> Result<Scene> {
        let overrides = self.scene.overrides();
        let resume = self.state.resume.as_deref();
        let scene = match (scene, resume) {
            (None, Some(path)) => {
                files::check_readable(path)?;
                Checkpoint::read(path)?.own_scene(path, &overrides)?
            }
            (scene, _) => {
                // clap has checked that one is given.
                let scene = Scene::load(scene.unwrap_or("".as_ref()), &overrides)?;
                resume.map(files::check_readable).transpose()?;
                scene
            }
        };
        if let Some(path) = &self.state.checkpoint {
            files::check_writable(path)?;
        }
        Ok(scene)
    }
}

impl CommonOptions {
    /// Refuses outputs that the run has read so far, and the checkpoint, unless the user allows it.
    pub fn check_outputs<'a>(&'a self, outputs: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
        if self.state.overwrite_input {
            return Ok(());
        }
        let or = ", or allow it by --overwrite-input";
        files::check_unread(outputs.chain(&self.state.checkpoint), or)
    }
}

/// Width and height of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// 1 to 16,384.
    pub width: u32,
    /// 1 to 16,384.
    pub height: u32,
}

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [width, height] = picture_size(text).ok_or_else(|| {
            format!("WIDTHxHEIGHT is expected, such as 1280x720, each side 1 to {LONGEST_SIDE}")
        })?;
        Ok(Self { width, height })
    }
}
