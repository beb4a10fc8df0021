//! `myxo query atlas`: where each triangle of a mesh lies in the texture.

use std::fmt::Write as _;
use std::iter::once;
use std::path::PathBuf;

use clap::Args;
use glam::DVec2;
use myxo::Result;
use myxo::mesh::surface::Surface;
use myxo::mesh::{Mesh, atlas};
use myxo::scene::settings::{AtlasMethod, Settings};

use super::{open_mesh, options_of};
use crate::cli::files::{Sink, check_unread};
use crate::cli::progress::{SettingUp, atlas_cache};
use crate::cli::{Command, Outcome, interrupt};
use crate::{console, room};

/// List where each triangle of a mesh lies in the texture
///
/// Out: a line `# width height`, then face,chart,u0,v0,u1,v1,u2,v2
///
/// Faces are counted from 0 in the order of the file, polygons cut into
/// triangles. u0 and v0 are the place of a face's first corner in the file, u1 and
/// v1 that of its second, u2 and v2 that of its third. u and v go from 0 to 1 over
/// the texture, and v goes the way of its rows. A face without area, or one that
/// is there twice, has no place and no row.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query atlas --mesh fish.obj --atlas-size 1024 --out charts.csv
  myxo query atlas --mesh builtin:torus --atlas-size 512 --atlas-method grid | head"
)]
pub struct Atlas {
    /// A model (.obj, .stl, .ply, .glb, .gltf), or builtin:NAME
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// Side of the texture, in texels, 1 to 32768, as far as memory goes
    #[arg(long, value_name = "N", default_value_t = Settings::default().atlas.size)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(atlas::MAX_SIZE)))]
    atlas_size: u32,
    /// How triangles are laid out
    #[arg(long, value_name = "WORD", default_value = Settings::default().atlas.method.word())]
    #[arg(value_parser = super::atlas_method())]
    atlas_method: AtlasMethod,
    /// Width of the gutter, in texels
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=64))]
    gutter: u32,
    /// Turns each chart by a random angle; another N gives other angles, and 0 turns none
    #[arg(long, value_name = "N", default_value_t = 0)]
    turn: u64,
    /// The file for the answer; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
}

impl Command for Atlas {
    /// Lays the mesh out and writes the answer.
    fn run(&self) -> Result<Outcome> {
        interrupt::install()?;
        let sink = Sink::create(&self.out)?;
        let mesh = open_mesh(&self.mesh)?;
        check_unread(once(&self.out), "")?;
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let options = options_of(self.atlas_method, self.atlas_size, self.gutter, self.turn);
        room::check_atlas(&options, surface.corners.len(), "--atlas-size")?;
        let atlas = SettingUp::new(&mesh.name, atlas_cache())
            .run(|control| atlas::Atlas::build_with(&surface, &options, control))
            .map_err(|error| room::atlas_error(error, "--atlas-size", "--atlas-method"))?;
        let dropped = mesh.report.file_triangles - mesh.report.triangles;
        if dropped > 0 {
            console::message(&format!(
                "{}: {dropped} faces without area, or there twice, have no place, and no row",
                mesh.name
            ));
        }
        sink.write(text(&mesh, &atlas))?;
        Ok(Outcome::Done)
    }
}

fn text(mesh: &Mesh, atlas: &atlas::Atlas) -> String {
    let mut text = format!("# {0} {0}\nface,chart,u0,v0,u1,v1,u2,v2\n", atlas.size);
    for (triangle, map) in atlas.maps.iter().enumerate() {
        let (origin, du, dv) = (map.origin.as_dvec2(), map.du.as_dvec2(), map.dv.as_dvec2());
        let ours = [origin, origin + du, origin + dv];
        let mut corners = [DVec2::ZERO; 3];
        for (position, corner) in ours.into_iter().zip(mesh.file_corners[triangle]) {
            corners[usize::from(corner)] = position / f64::from(atlas.size);
        }
        let (face, chart) = (mesh.file_triangle[triangle], atlas.chart[triangle]);
        let _ = write!(text, "{face},{chart}");
        for DVec2 { x, y } in corners {
            // The shortest text that reads back as the same double.
            let _ = write!(text, ",{x},{y}");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face that lies the other way round in the file, and one that was dropped.
    #[test]
    fn corners_are_in_file_order() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("odd.obj");
        let obj = "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 0 1 0\nf 1 2 3\nf 2 2 3\nf 1 3 4\n";
        std::fs::write(&path, obj).unwrap();
        let mesh = Mesh::load_raw(&path).unwrap();
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let options = options_of(AtlasMethod::Grid, 32, 1, 0);
        let atlas = atlas::Atlas::build(&surface, &options).unwrap();
        let text = text(&mesh, &atlas);
        let rows: Vec<Vec<f64>> = text
            .lines()
            .skip(2)
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
            .collect();
        assert!(text.starts_with("# 32 32\nface,chart,"), "{text}");
        assert_eq!(
            (rows.len(), rows[0][0], rows[1][0]),
            (2, 0.0, 2.0),
            "{text}"
        );
        // Both share the edge from the file's vertex 1 to 3, and lie side by side in one cell.
        assert_eq!(rows[0][1], rows[1][1]);
        let near = |a: &[f64], b: &[f64]| (a[0] - b[0]).abs() < 1e-4 && (a[1] - b[1]).abs() < 1e-4;
        assert!(near(&rows[0][2..4], &rows[1][2..4]), "{text}");
        assert!(near(&rows[0][6..8], &rows[1][4..6]), "{text}");
        // Corners in the surface begin with the shortest edge, so the test has a face whose corners are rotated.
        assert_ne!(mesh.file_corners[0], [0, 1, 2]);
    }
}
