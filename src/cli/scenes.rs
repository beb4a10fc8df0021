//! `myxo scenes`: what is built in, and every key of a scene file.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use myxo::Result;
use myxo::mesh::builtin::BUILTINS;
use myxo::scene::Scene;
use myxo::scene::builtin::{PRESETS, SCENES};
use myxo::scene::parameters::{
    Effect, FOOD_PARAMETERS, Kind, OBJECT_PARAMETERS, PARAMETERS, PULSE_PARAMETERS, Parameter,
};
use myxo::scene::settings::{FoodSettings, ObjectSettings, PulseSettings, Settings};

use super::options::SceneOptions;
use super::{Command, Outcome};
use crate::console;
use crate::own_presets::{OwnPresets, summary};

/// List built-in scenes, presets and meshes, or print a scene as a file
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo scenes                            names of scenes, presets and meshes
  myxo scenes --keys                     every key of a scene file: unit, range, default, meaning
  myxo scenes torus > mine.toml          a scene file to begin with
  myxo scenes cube --preset cells > cells.toml")]
pub struct Scenes {
    /// Prints this scene as a file, every key written out
    #[arg(conflicts_with = "keys")]
    scene: Option<PathBuf>,
    /// Lists every key of a scene file
    #[arg(long)]
    keys: bool,
    #[command(flatten)]
    options: SceneOptions,
}

impl Command for Scenes {
    /// Prints the lists or the scene.
    fn run(&self) -> Result<Outcome> {
        let text = match &self.scene {
            Some(scene) => as_file(Scene::read(scene, &self.options.overrides())?),
            None if self.keys => keys(),
            None => names(),
        };
        console::print(&text)?;
        Ok(Outcome::Done)
    }
}

/// A scene as a file that loads from any folder, if it comes from another one than the current one.
fn as_file((_, mut settings, folder): (String, Settings, PathBuf)) -> String {
    if !folder.as_os_str().is_empty() {
        Scene::make_paths_whole(&mut settings, &folder);
    }
    settings.to_toml()
}

fn names() -> String {
    let mut text = String::new();
    for (title, list) in [("Scenes", SCENES), ("Presets (--preset)", PRESETS)] {
        let _ = writeln!(text, "{title}:");
        for entry in list {
            let _ = writeln!(text, "  {:<10} {}", entry.name, entry.summary());
        }
        text.push('\n');
    }
    let own = OwnPresets::read(OwnPresets::folder());
    if !own.all().is_empty() {
        let _ = writeln!(text, "Presets of your own (--preset):");
        for own in own.all() {
            let _ = match &own.problem {
                Some(problem) => writeln!(text, "  {:<10} cannot be used: {problem}", own.name),
                None => writeln!(text, "  {:<10} {}", own.name, summary(&own.text)),
            };
        }
        text.push('\n');
    }
    let _ = writeln!(text, "Meshes (object.mesh):");
    for (name, what) in BUILTINS {
        let _ = writeln!(text, "  builtin:{name:<10} {what}");
    }
    text
}

fn keys() -> String {
    let mut text = String::new();
    for parameter in PARAMETERS {
        describe(&mut text, parameter, parameter.key, &Settings::default());
    }
    let object = ObjectSettings::default();
    let texts = [
        (
            "name",
            &object.name,
            "The name of the object. Empty takes the mesh's name.",
        ),
        (
            "mesh",
            &object.mesh,
            "builtin:NAME, or a path relative to the scene file.",
        ),
    ];
    for (key, default, meaning) in texts {
        let _ = writeln!(
            text,
            "object.N.{key} = \"{default}\"\n    {meaning}\n    A text; restarts."
        );
    }
    text += "object.N.motion.keyframes = []\n    Where the object is at given times: { time = 0, position = [0, 0, 0], rotation = [0, 0, 0] }, times ascending, in seconds; position in world units and rotation in degrees, on top of the object's own.\n    A list of tables.\n";
    text += "object.N.distance_to = []\n    The names of the objects that this one has distances to. Empty for all others.\n    A list of texts; restarts.\n";
    text += "object.N.glue = []\n    Pairs of border edges that are one edge, although they lie apart: [face, edge, other face, other edge]. Faces are counted from 0, polygons cut into triangles; edge 0 goes from a face's first corner to its second.\n    A list of lists of four whole numbers; restarts.\n";
    for parameter in OBJECT_PARAMETERS {
        describe(
            &mut text,
            parameter,
            &format!("object.N.{}", parameter.key),
            &object,
        );
    }
    let food = FoodSettings::default();
    for parameter in FOOD_PARAMETERS {
        describe(
            &mut text,
            parameter,
            &format!("food.N.{}", parameter.key),
            &food,
        );
    }
    let pulse = PulseSettings::default();
    for parameter in PULSE_PARAMETERS {
        describe(
            &mut text,
            parameter,
            &format!("pulse.N.{}", parameter.key),
            &pulse,
        );
    }
    text
}

fn describe<T>(text: &mut String, parameter: &Parameter<T>, key: &str, defaults: &T) {
    let effect = match parameter.effect {
        Effect::Live => "changes while running",
        Effect::Restart => "restarts",
    };
    let value = parameter.value(defaults);
    let quote = if matches!(parameter.kind, Kind::Choice { .. } | Kind::Text { .. }) {
        "\""
    } else {
        ""
    };
    let Parameter { name, help, .. } = parameter;
    let allowed = parameter.allowed();
    let _ = writeln!(
        text,
        "{key} = {quote}{value}{quote}\n    {name}: {help}\n    {allowed}; {effect}."
    );
}
