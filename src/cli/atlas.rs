//! `myxo atlas`: how meshes lie in the texture, as a picture and in numbers. It needs no device.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use clap::builder::PossibleValuesParser;
use image::codecs::png::PngEncoder;
use myxo::mesh::atlas::{self, AtlasOptions, AtlasStatistics};
use myxo::plain_text::{Shown as _, counted, escaped};
use myxo::render::charts;
use myxo::scene::Scene;
use myxo::scene::parameters::grouped;
use myxo::scene::settings::AtlasMethod;
use myxo::sim::atlas_options;
use myxo::{Error, Result};
use serde_json::{Map, Value, json};

use super::files::Sink;
use super::options::SceneOptions;
use super::progress::{SettingUp, atlas_cache};
use super::report::Report;
use super::{Command, Outcome, interrupt};
use crate::{console, room};

/// Pixels along a side that a picture has at most.
const LARGEST_PICTURE: u32 = 16_384;
/// What `--out` calls the standard output.
const STDOUT: &str = "-";

/// Show how meshes lie in the texture: a picture, and numbers
///
/// In the picture each chart has a colour, and its gutter a darker shade of it. Light lines are seams, amber ones open
/// borders. Several scenes give a table with a line for each.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo atlas suzanne --out atlas.png             a picture, and numbers
  myxo atlas fish.glb --size 2048 --gutter 2     numbers alone
  myxo atlas builtin:cube --size 64 --scale 8 --out cube.png
  myxo atlas cube torus assets/suzanne.glb       a table
  myxo atlas torus --method grid --json")]
pub struct Atlas {
    /// A built-in name, a .toml file, a model, or a built-in mesh such as builtin:torus?tube=0.2. May be repeated
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Writes the layout as a PNG, each texel a pixel; - for the standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Pixels along the side of each texel in the picture
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    scale: u32,
    /// Prints JSON instead of text
    #[arg(long)]
    json: bool,
    /// Side of the texture, in texels, 1 to 32768, as far as memory goes; as --set atlas.size=N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(atlas::MAX_SIZE)))]
    size: Option<u32>,
    /// How triangles are laid out; as --set atlas.method=WORD
    #[arg(long, value_name = "WORD", value_parser = PossibleValuesParser::new(AtlasMethod::WORDS))]
    method: Option<String>,
    /// Width of the gutter, in texels, instead of the diffusion distance
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    gutter: Option<u32>,
    /// Turns each chart by a random angle; another N gives other angles, and 0 turns none
    #[arg(long, value_name = "N")]
    turn: Option<u64>,
    /// Makes the layout even if one is cached, and caches none
    #[arg(long)]
    fresh: bool,
    #[command(flatten)]
    options: SceneOptions,
}

/// One scene's layout in numbers.
struct Row {
    name: String,
    objects: usize,
    glued_pairs: usize,
    options: AtlasOptions,
    statistics: AtlasStatistics,
    seconds: f64,
    phases: Vec<(&'static str, f64)>,
}

impl Command for Atlas {
    /// Lays the scenes out and prints the numbers.
    fn run(&self) -> Result<Outcome> {
        interrupt::install()?;
        let out = self
            .out
            .as_deref()
            .map(|path| self.sink(path))
            .transpose()?;
        let mut rows = Vec::new();
        let mut picture = None;
        for scene in &self.scenes {
            let scene = self.load(scene)?;
            let options = self.atlas_options(&scene);
            room::check_atlas(&options, scene.surface.corners.len(), self.size_option())?;
            if out.is_some() {
                self.check_picture(&options)?;
            }
            let (row, atlas) = self.lay_out(&scene, options)?;
            if out.is_some() {
                picture = Some(png(&charts::picture(&scene.surface, &atlas, self.scale)));
            }
            rows.push(row);
            if interrupt::requested() {
                return Ok(Outcome::Interrupted);
            }
        }
        let text = if self.json {
            as_json(&rows)
        } else if let [row] = rows.as_slice() {
            as_text(row)
        } else {
            as_table(&rows)
        };
        if let (Some(sink), Some(picture)) = (out, picture) {
            sink.write(picture)?;
        }
        // If the picture goes to the standard output, the numbers go to the standard error.
        if self.out.as_deref().is_some_and(is_stdout) {
            console::message(&text);
        } else {
            console::print(&text)?;
        }
        Ok(Outcome::Done)
    }
}

impl Atlas {
    /// The file or stream of the picture.
    fn sink(&self, path: &Path) -> Result<Sink> {
        if self.scenes.len() > 1 {
            return Err(Error::Invalid(format!(
                "--out writes the picture of one scene, and there are {}: give one, or omit --out",
                self.scenes.len()
            )));
        }
        let ending = path.extension().unwrap_or_default();
        if !ending.eq_ignore_ascii_case("png") && !is_stdout(path) {
            return Err(Error::Invalid(format!(
                "{}: pictures of an atlas are PNG files: give it a name that ends in .png",
                path.shown()
            )));
        }
        Sink::create(path)
    }

    fn load(&self, scene: &Path) -> Result<Scene> {
        let mut overrides = self.options.overrides();
        overrides.set.extend(
            self.method
                .iter()
                .map(|word| format!("atlas.method={word}")),
        );
        let scene = Scene::load(scene, &overrides)?;
        let odd = scene.meshes.iter().map(|mesh| (&mesh.name, &mesh.report));
        for (name, report) in odd.filter(|(_, report)| !report.oddities().is_empty()) {
            console::message(&format!("{}: {report}", escaped(name)));
        }
        Ok(scene)
    }

    fn atlas_options(&self, scene: &Scene) -> AtlasOptions {
        let options = atlas_options(&scene.settings);
        AtlasOptions {
            size: self.size.unwrap_or(options.size),
            gutter: self.gutter.unwrap_or(options.gutter),
            turn: self.turn.unwrap_or(options.turn),
            ..options
        }
    }

    /// The option that sets the texture's side.
    fn size_option(&self) -> &'static str {
        if self.size.is_some() {
            "--size"
        } else {
            "atlas.size"
        }
    }

    /// The option that sets the method.
    fn method_option(&self) -> &'static str {
        if self.method.is_some() {
            "--method"
        } else {
            "atlas.method"
        }
    }

    fn check_picture(&self, options: &AtlasOptions) -> Result<()> {
        let side = u64::from(options.size) * u64::from(self.scale);
        if side <= LARGEST_PICTURE.into() {
            return Ok(());
        }
        let advice = match LARGEST_PICTURE / options.size {
            0 => "omit --out, or use a smaller --size".to_owned(),
            scale => format!("use --scale {scale} at most"),
        };
        Err(Error::Invalid(format!(
            "the picture would be {side} x {side} pixels, and {LARGEST_PICTURE} a side is the most: {advice}"
        )))
    }

    fn lay_out(&self, scene: &Scene, options: AtlasOptions) -> Result<(Row, atlas::Atlas)> {
        let cache = (!self.fresh).then(atlas_cache).flatten();
        let setting_up = SettingUp::new(&scene.name, cache);
        let begun = Instant::now();
        let atlas = setting_up
            .run(|control| atlas::Atlas::build_with(&scene.surface, &options, control))
            .map_err(|error| room::atlas_error(error, self.size_option(), self.method_option()))?;
        if let Some(warning) = atlas.warning() {
            console::message(&format!("{}: {warning}", escaped(&scene.name)));
        }
        let (seconds, phases) = (begun.elapsed().as_secs_f64(), setting_up.seconds());
        let row = Row {
            name: scene.name.clone(),
            objects: scene.settings.objects.len(),
            // Both half-edges of a pair are listed.
            glued_pairs: scene.surface.glued.len() / 2,
            statistics: atlas.statistics(&scene.surface),
            seconds,
            phases,
            options: AtlasOptions {
                size: atlas.size,
                gutter: atlas.gutter,
                ..options
            },
        };
        Ok((row, atlas))
    }
}

fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == STDOUT
}

fn png(picture: &image::RgbaImage) -> Vec<u8> {
    let rgb = image::DynamicImage::from(picture.clone()).into_rgb8();
    let mut bytes = Vec::new();
    rgb.write_with_encoder(PngEncoder::new(&mut bytes))
        .expect("pictures of this size can be encoded in memory");
    bytes
}

/// With three decimals; `-` for a value that is not finite.
fn decimals(value: f64) -> String {
    if value.is_finite() {
        format!("{value:.3}")
    } else {
        "-".to_owned()
    }
}

fn as_text(row: &Row) -> String {
    let Row {
        name,
        options,
        statistics: s,
        ..
    } = row;
    let percent = |part: f64, all: f64| format!("{:.1} %", 100.0 * part / all);
    let texels = f64::from(options.size).powi(2);
    let share = |count: u64| {
        let share = percent(count as f64, texels);
        format!("{}, {share}", counted(count as usize, "texel", "texels"))
    };
    let three = |values: [f64; 3]| values.map(decimals).join("  ");
    let flat = match s.flat_triangles {
        0 => String::new(),
        1 => "; 1 triangle has no area in the texture".to_owned(),
        n => format!(
            "; {} triangles have no area in the texture",
            grouped(n as f64)
        ),
    };
    let glued = match row.glued_pairs {
        0 => String::new(),
        n => format!("; {} of edges glued", counted(n, "pair", "pairs")),
    };
    let phases: String = row
        .phases
        .iter()
        .map(|(doing, seconds)| format!("; {doing} {seconds:.3}"))
        .collect();
    let rows = [
        ("method", options.method.word().to_owned()),
        (
            "size",
            format!("{0} x {0} texels, gutter {1}", options.size, options.gutter),
        ),
        ("charts", grouped(f64::from(s.charts))),
        (
            "seam edges",
            format!("{}{glued}", grouped(s.seam_edges as f64)),
        ),
        ("utilisation", percent(s.utilisation, 1.0)),
        ("owned", share(s.owned_texels)),
        ("gutter", share(s.gutter_texels)),
        ("empty", share(s.empty_texels)),
        (
            "texels per area",
            format!(
                "{}   times the mean; 5, 50 and 95 % of the surface have less",
                three(s.area_percentiles)
            ),
        ),
        (
            "stretch",
            format!(
                "{}   longest over shortest; worst {}{flat}",
                three(s.stretch_percentiles),
                decimals(s.worst_stretch)
            ),
        ),
        (
            "without a centre",
            format!(
                "{} no texel's centre",
                match s.unowned_triangles {
                    1 => "1 triangle holds".to_owned(),
                    n => format!("{} triangles hold", grouped(n as f64)),
                }
            ),
        ),
        ("seconds", format!("{:.3}{phases}", row.seconds)),
    ];
    let objects = match row.objects {
        1 => "one object".to_owned(),
        n => format!("{n} objects"),
    };
    let mut text = format!(
        "{}: {} of {objects}\n",
        escaped(name),
        counted(s.triangles, "triangle", "triangles")
    );
    for (what, value) in rows {
        let _ = writeln!(text, "  {what:<18} {value}");
    }
    text
}

const COLUMNS: [&str; 10] = [
    "scene",
    "triangles",
    "method",
    "charts",
    "utilisation",
    "area 5 %",
    "area 95 %",
    "stretch 95 %",
    "no centre",
    "seconds",
];

/// A Markdown table that is readable as it is.
fn as_table(rows: &[Row]) -> String {
    let cells: Vec<[String; COLUMNS.len()]> = rows
        .iter()
        .map(|row| {
            let s = &row.statistics;
            [
                escaped(&row.name).into_owned(),
                grouped(s.triangles as f64),
                row.options.method.word().to_owned(),
                grouped(f64::from(s.charts)),
                format!("{:.3}", s.utilisation),
                decimals(s.area_percentiles[0]),
                decimals(s.area_percentiles[2]),
                decimals(s.stretch_percentiles[2]),
                grouped(s.unowned_triangles as f64),
                format!("{:.2}", row.seconds),
            ]
        })
        .collect();
    let width = |column: usize| {
        let widest = cells.iter().map(|row| row[column].chars().count()).max();
        widest.unwrap_or(0).max(COLUMNS[column].len())
    };
    let widths: Vec<usize> = (0..COLUMNS.len()).map(width).collect();
    let mut text = String::new();
    let mut line = |cells: &[&str]| {
        text.push('|');
        for (column, cell) in cells.iter().enumerate() {
            let width = widths[column];
            let _ = match column {
                0 | 2 => write!(text, " {cell:<width$} |"),
                _ => write!(text, " {cell:>width$} |"),
            };
        }
        text.push('\n');
    };
    line(&COLUMNS);
    line(&std::array::from_fn::<_, { COLUMNS.len() }, _>(
        |column| match column {
            0 | 2 => "---",
            _ => "--:",
        },
    ));
    for row in &cells {
        line(&row.each_ref().map(String::as_str));
    }
    let sizes = rows
        .iter()
        .map(|row| (row.options.size, row.options.gutter));
    let mut sizes: Vec<_> = sizes.collect();
    sizes.dedup();
    let size = match sizes.as_slice() {
        [(size, gutter)] => format!("{size} x {size} texels, gutter {gutter}. "),
        _ => String::new(),
    };
    let host = Report::of_this_host();
    let _ = writeln!(
        text,
        "\n{size}Area: texels of a triangle per area of the surface, over the mean. Stretch: longest over shortest in a \
         triangle's map.\nNo centre: triangles that hold no texel's centre. Seconds: everything, on {}.",
        host.processor.as_deref().unwrap_or("this machine"),
    );
    text
}

fn as_json(rows: &[Row]) -> String {
    let values: Vec<Value> = rows.iter().map(row_as_json).collect();
    let value = match values.as_slice() {
        [only] => only.clone(),
        _ => Value::Array(values),
    };
    serde_json::to_string_pretty(&value).expect("numbers are plain") + "\n"
}

fn row_as_json(row: &Row) -> Value {
    let s = &row.statistics;
    let phases = row.phases.iter();
    let phases = phases.map(|(doing, seconds)| ((*doing).to_owned(), json!(seconds)));
    // Numbers that are not finite become null: there are flat triangles then.
    json!({
        "scene": row.name,
        "objects": row.objects,
        "triangles": s.triangles,
        "method": row.options.method.word(),
        "size": row.options.size,
        "gutter": row.options.gutter,
        "charts": s.charts,
        "seam_edges": s.seam_edges,
        "glued_pairs": row.glued_pairs,
        "utilisation": s.utilisation,
        "owned_texels": s.owned_texels,
        "gutter_texels": s.gutter_texels,
        "empty_texels": s.empty_texels,
        "area_percentiles": s.area_percentiles,
        "stretch_percentiles": s.stretch_percentiles,
        "worst_stretch": s.worst_stretch,
        "unowned_triangles": s.unowned_triangles,
        "flat_triangles": s.flat_triangles,
        "seconds": row.seconds,
        "phases": phases.collect::<Map<String, Value>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str) -> Row {
        Row {
            name: name.to_owned(),
            objects: 1,
            glued_pairs: 0,
            options: AtlasOptions {
                size: 64,
                gutter: 1,
                ..AtlasOptions::default()
            },
            statistics: AtlasStatistics {
                triangles: 27_648,
                charts: 9,
                utilisation: 0.7125,
                owned_texels: 2900,
                gutter_texels: 96,
                empty_texels: 1100,
                area_percentiles: [0.9, 1.0, 1.1],
                stretch_percentiles: [1.0, 1.01, 1.2],
                worst_stretch: f64::INFINITY,
                unowned_triangles: 3,
                flat_triangles: 1,
                seam_edges: 120,
            },
            seconds: 0.5,
            phases: vec![("packing", 0.25)],
        }
    }

    #[test]
    fn numbers_are_printed_with_their_meaning() {
        let text = as_text(&row("torus"));
        for part in [
            "torus: 27,648 triangles of one object\n",
            "seam edges         120\n",
            "utilisation        71.2 %\n",
            "gutter             96 texels, 2.3 %\n",
            "0.900  1.000  1.100   times the mean",
            "worst -; 1 triangle has no area in the texture\n",
            "3 triangles hold no texel's centre\n",
            "seconds            0.500; packing 0.250\n",
        ] {
            assert!(text.contains(part), "{part}\nis not in\n{text}");
        }
    }

    #[test]
    fn none_and_one_have_words_of_their_own() {
        let mut row = row("sliver");
        row.glued_pairs = 1;
        row.statistics = AtlasStatistics {
            triangles: 1,
            owned_texels: 1,
            unowned_triangles: 1,
            area_percentiles: [f64::NAN; 3],
            stretch_percentiles: [f64::INFINITY; 3],
            ..row.statistics
        };
        let text = as_text(&row);
        for part in [
            "sliver: 1 triangle of one object\n",
            "seam edges         120; 1 pair of edges glued\n",
            "owned              1 texel, 0.0 %\n",
            "texels per area    -  -  -   times",
            "stretch            -  -  -   longest",
            "1 triangle holds no texel's centre\n",
        ] {
            assert!(text.contains(part), "{part}\nis not in\n{text}");
        }
    }

    #[test]
    fn a_table_has_a_line_for_each_scene() {
        let text = as_table(&[row("torus"), row("a longer name")]);
        let lines: Vec<&str> = text.lines().take(4).collect();
        assert!(
            lines.iter().all(|line| line.len() == lines[0].len()),
            "{text}"
        );
        assert!(
            lines[0].starts_with("| scene         | triangles | method |"),
            "{text}"
        );
        assert!(lines[3].contains(" 0.713 |"), "{text}");
        assert!(text.contains("64 x 64 texels, gutter 1. "), "{text}");
    }

    #[test]
    fn json_is_one_object_or_a_list() {
        let parse = |rows: &[Row]| serde_json::from_str::<Value>(&as_json(rows)).unwrap();
        let one = parse(&[row("torus")]);
        assert_eq!(one["charts"], 9);
        assert_eq!(one["phases"]["packing"], 0.25);
        assert_eq!(one["worst_stretch"], Value::Null);
        assert_eq!(one["flat_triangles"], 1);
        assert_eq!(parse(&[row("a"), row("b")])[1]["scene"], "b");
    }
}
