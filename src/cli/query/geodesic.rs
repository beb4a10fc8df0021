//! `myxo query geodesic`: straight walks on one mesh.
//!
//! Rows speak of the file's triangles, corners in file order and directions in space; walks speak of our triangles,
//! `uv` and headings in the tangent frame. This file translates both ways, in double precision, and leaves the walking
//! to an engine.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use glam::{DVec2, DVec3};
use myxo::Result;
use myxo::mesh::Mesh;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{Frame, SurfacePoint, WalkEnd, WalkQuery, WalkStatus};

use super::table::{Row, Table};
use crate::cli::files::Sink;
use crate::cli::options::DeviceOptions;
use crate::cli::{Outcome, console, not_built_in};

/// Walk straight on a mesh from given points in given directions
///
/// In:  id,face,b0,b1,b2,dx,dy,dz,length
/// Out: id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status
///
/// Faces and corners are counted as in the file; status is 0 for the whole length, 1 for stopped at an open border, 2
/// for a start that is not on the mesh.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query geodesic --mesh fish.obj --in walks.csv --out ends.csv
  myxo query geodesic --mesh builtin:torus < walks.csv | head"
)]
pub struct Geodesic {
    /// A model (.obj, .glb, .gltf), or builtin:NAME
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// The walks; - for the standard input
    #[arg(long = "in", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Where their ends go; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    #[command(flatten)]
    device: DeviceOptions,
}

/// Answers each query in order, stopping at open borders, with as many crossings as it takes.
pub type Engine<'a> = &'a dyn Fn(&Surface, &[WalkQuery]) -> Result<Vec<WalkEnd>>;

const COLUMNS: &[&str] = &["id", "face", "b0", "b1", "b2", "dx", "dy", "dz", "length"];
const HEADER: &str = "id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status";

/// Rows that cannot be answered are told of one by one up to this many.
const MESSAGES: usize = 5;

impl Geodesic {
    /// Reads, walks, writes.
    pub fn run(&self) -> Result<Outcome> {
        let _ = &self.device;
        self.run_with(&|_, _| Err(not_built_in("the simulation")))
    }

    fn run_with(&self, engine: Engine<'_>) -> Result<Outcome> {
        let sink = Sink::create(&self.out)?;
        let mesh = match self.mesh.to_str() {
            Some(builtin) if builtin.starts_with("builtin:") => Mesh::builtin(builtin)?,
            _ => Mesh::load_raw(&self.mesh)?,
        };
        let table = Table::read(&self.input, COLUMNS)?;
        let answers = answer(&mesh, &table, engine)?;
        for message in answers.refused.iter().take(MESSAGES) {
            console::message(message);
        }
        if answers.refused.len() > MESSAGES {
            console::message(&format!(
                "and {} more rows with status 2",
                answers.refused.len() - MESSAGES
            ));
        }
        sink.write(&answers.text)?;
        Ok(Outcome::Done)
    }
}

/// The rows of the answer, and what was said about those that could not be answered.
#[derive(Debug)]
struct Answers {
    text: String,
    refused: Vec<String>,
}

/// Answers every row of a table by one call of the engine.
fn answer(mesh: &Mesh, table: &Table, engine: Engine<'_>) -> Result<Answers> {
    let surface = Surface::build(&[(mesh, 1.0)]);
    let mut queries = Vec::new();
    let mut starts = Vec::new();
    for row in table.rows() {
        let start = Start::read(row)?;
        let query = start.query(mesh, &surface);
        queries.extend(query.as_ref().ok());
        starts.push((row, start, query.err()));
    }
    let mut ends = engine(&surface, &queries)?.into_iter();
    let mut answers = Answers {
        text: format!("{HEADER}\n"),
        refused: Vec::new(),
    };
    for (row, start, refusal) in starts {
        match refusal {
            None => {
                let end = ends.next().expect("the engine answers every query");
                write_end(&mut answers.text, row.text(0), mesh, &surface, &end);
            }
            Some(reason) => {
                answers
                    .refused
                    .push(format!("{}: {reason}; the row gets status 2", row.place()));
                start.write_back(&mut answers.text, row.text(0));
            }
        }
    }
    Ok(answers)
}

/// A row as it was read.
#[derive(Clone, Copy, Debug)]
struct Start {
    face: u32,
    weights: DVec3,
    direction: DVec3,
    length: f64,
}

impl Start {
    fn read(row: Row<'_>) -> Result<Self> {
        let vector = |column| {
            Ok::<_, myxo::Error>(DVec3::new(
                row.number(column)?,
                row.number(column + 1)?,
                row.number(column + 2)?,
            ))
        };
        Ok(Self {
            face: row.index(1)?,
            weights: vector(2)?,
            direction: vector(5)?,
            length: row.number(8)?,
        })
    }

    /// The walk that the row asks for, or why there is none.
    fn query(&self, mesh: &Mesh, surface: &Surface) -> Result<WalkQuery, String> {
        let sum = self.weights.element_sum();
        if self.weights.min_element() < -1e-6 || (sum - 1.0).abs() > 1e-6 {
            return Err("b0, b1, b2 are not weights that sum to 1".to_owned());
        }
        if self.length < 0.0 {
            return Err("the length is negative".to_owned());
        }
        let weights = self.weights.max(DVec3::ZERO);
        let weights = weights / weights.element_sum();
        let start = mesh
            .point_from_file(self.face, weights.to_array())
            .ok_or_else(|| format!("the mesh has no face {} to walk on", self.face))?;
        let frame = Frame::of(surface, start.triangle);
        // Scaled first, so that squares of tiny components do not vanish.
        let direction = self.direction / self.direction.abs().max_element();
        let heading =
            DVec2::new(direction.dot(frame.p), direction.dot(frame.h)).normalize_or_zero();
        if heading == DVec2::ZERO {
            return Err("the direction has no part in the plane of its face".to_owned());
        }
        Ok(WalkQuery {
            start,
            heading,
            length: self.length,
        })
    }

    /// The row as it was, for a walk that cannot be.
    fn write_back(&self, text: &mut String, id: &str) {
        let (b, d) = (self.weights, self.direction);
        let _ = writeln!(
            text,
            "{id},{},{},{},{},0,0,0,{},{},{},0,2",
            self.face, b.x, b.y, b.z, d.x, d.y, d.z
        );
    }
}

fn write_end(text: &mut String, id: &str, mesh: &Mesh, surface: &Surface, end: &WalkEnd) {
    let SurfacePoint { triangle, u, v } = end.point;
    let corners = surface.corners[triangle as usize];
    let [a, b, c] = corners.map(|corner| surface.positions[corner as usize].as_dvec3());
    let position = a + u * (b - a) + v * (c - a);
    let frame = Frame::of(surface, triangle);
    let direction = (end.heading.x * frame.p + end.heading.y * frame.h).normalize();
    let status = if end.status == WalkStatus::Border {
        1
    } else {
        0
    };
    let (face, [b0, b1, b2]) = mesh.point_to_file(end.point);
    let _ = write!(text, "{id},{face}");
    for number in [
        b0,
        b1,
        b2,
        position.x,
        position.y,
        position.z,
        direction.x,
        direction.y,
        direction.z,
        end.travelled,
    ] {
        // Shortest text that reads back as the same double.
        let _ = write!(text, ",{number}");
    }
    let _ = writeln!(text, ",{status}");
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::mesh::walk::{BorderRule, walk};

    fn reference(surface: &Surface, queries: &[WalkQuery]) -> Result<Vec<WalkEnd>> {
        let end = |q: &WalkQuery| {
            walk(
                surface,
                q.start,
                q.heading,
                q.length,
                None,
                BorderRule::Stop,
            )
        };
        Ok(queries.iter().map(end).collect())
    }

    fn ask(mesh: &Mesh, rows: &str) -> Answers {
        let text = format!("id,face,b0,b1,b2,dx,dy,dz,length\n{rows}");
        let table = Table::parse("in.csv", text.as_bytes(), COLUMNS).expect("it is right");
        answer(mesh, &table, &reference).expect("it can be answered")
    }

    fn numbers(line: &str) -> Vec<f64> {
        line.split(',')
            .map(|field| field.parse().expect("a number"))
            .collect()
    }

    #[test]
    fn rows_that_cannot_be_walked_come_back_with_status_2() {
        let mesh = Mesh::builtin("cube").expect("it is built in");
        let answers = ask(
            &mesh,
            "a,99,1,0,0,1,0,0,1\nb,0,2,0,0,1,0,0,1\nc,0,1,0,0,0,0,0,1\nd,0,1,0,0,0,0,1,-1\n",
        );
        let lines: Vec<_> = answers.text.lines().skip(1).collect();
        assert_eq!(lines[0], "a,99,1,0,0,0,0,0,1,0,0,0,2");
        assert!(
            lines.len() == 4 && lines.iter().all(|line| line.ends_with(",2")),
            "{lines:#?}"
        );
        assert_eq!(answers.refused.len(), 4);
        assert_eq!(
            answers.refused[0],
            "in.csv: line 2: the mesh has no face 99 to walk on; the row gets status 2"
        );
        assert!(!answers.text.contains("NaN"), "{}", answers.text);
    }

    fn from_obj(text: &str) -> Mesh {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("mesh.obj");
        std::fs::write(&path, text).expect("it can be written");
        Mesh::load_raw(&path).expect("it is right")
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    /// The worked example of the format, and the same with one face wound the other way.
    #[test]
    fn the_worked_example_comes_out_as_written() {
        let rows = "a,0,0.25,0.5,0.25,0,1,0,0.45\nb,0,0.25,0.5,0.25,0,1,0,0.6\nc,0,0.25,0.5,0.25,0,1,0,2\n";
        let alike = from_obj(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
        let opposed = from_obj(&format!("{SQUARE}f 1 2 3\nf 1 4 3\n"));
        assert!(opposed.is_flipped(1) && !alike.is_flipped(0) && !alike.is_flipped(1));
        let expected = [
            [
                0.0, 0.25, 0.05, 0.7, 0.75, 0.7, 0.0, 0.0, 1.0, 0.0, 0.45, 0.0,
            ],
            [
                1.0, 0.15, 0.75, 0.1, 0.75, 0.85, 0.0, 0.0, 1.0, 0.0, 0.6, 0.0,
            ],
            [
                1.0, 0.0, 0.75, 0.25, 0.75, 1.0, 0.0, 0.0, 1.0, 0.0, 0.75, 1.0,
            ],
        ];
        for (mesh, swapped) in [(&alike, false), (&opposed, true)] {
            let answers = ask(mesh, rows);
            let lines: Vec<_> = answers.text.lines().collect();
            assert_eq!(lines.len(), 4);
            assert_eq!(lines[0], HEADER);
            for ((line, id), mut expected) in lines[1..].iter().zip(["a", "b", "c"]).zip(expected) {
                if swapped && expected[0] == 1.0 {
                    expected.swap(2, 3);
                }
                let (found_id, found) = line.split_once(',').expect("there are columns");
                assert_eq!(found_id, id);
                for (found, expected) in numbers(found).iter().zip(expected) {
                    assert!(
                        (found - expected).abs() < 1e-6,
                        "{line}, and {expected} is expected"
                    );
                }
            }
        }
    }

    /// A start's weights, direction and length reach the engine in double precision, and its answer the text.
    #[test]
    fn no_digit_is_lost_on_the_way() {
        let mesh = from_obj(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
        let text = "id,face,b0,b1,b2,dx,dy,dz,length\nx,0,0.2499999999999999,0.5,0.2500000000000001,0,3e-200,0,0.12345678901234566\n";
        let table = Table::parse("in.csv", text.as_bytes(), COLUMNS).expect("it is right");
        let echo = |_: &Surface, queries: &[WalkQuery]| {
            let [query] = queries else {
                panic!("one query is asked")
            };
            assert_eq!((query.start.u, query.start.v), (0.5, 0.2500000000000001));
            assert_eq!(query.heading, DVec2::Y);
            Ok(vec![WalkEnd {
                point: query.start,
                heading: query.heading,
                travelled: query.length,
                status: WalkStatus::Done,
            }])
        };
        let answers = answer(&mesh, &table, &echo).expect("it can be answered");
        let line = answers.text.lines().nth(1).expect("one row");
        assert!(line.starts_with("x,0,0.2499999999999999,0.5,0.2500000000000001,0.7500000000000001,0.2500000000000001,0,0,1,0,"), "{line}");
        assert!(line.ends_with(",0.12345678901234566,0"), "{line}");
    }

    #[test]
    fn weights_off_by_rounding_are_taken() {
        let mesh = Mesh::builtin("cube").expect("it is built in");
        let answers = ask(&mesh, "a,0,0.5000000001,-1e-9,0.5,1,1,1,0\n");
        assert!(answers.refused.is_empty(), "{:?}", answers.refused);
        let weights = &numbers(
            answers
                .text
                .lines()
                .nth(1)
                .expect("one row")
                .trim_start_matches("a,"),
        )[1..4];
        assert!(
            weights.iter().all(|&w| w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-12,
            "{weights:?}"
        );
    }
}
