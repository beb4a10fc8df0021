//! Walks from the rows of a table, and the rows of their answers: code that the questions about walks share.

use std::fmt::Write as _;

use glam::{DAffine3, DVec2, DVec3};
use myxo::Result;
use myxo::mesh::Mesh;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{Frame, SurfacePoint, WalkEnd, WalkQuery, WalkStatus};
use myxo::plain_text::in_csv;

use super::table::{Row, Table};
use crate::console;

/// The columns of the input.
pub const COLUMNS: &[&str] = &["id", "face", "b0", "b1", "b2", "dx", "dy", "dz", "length"];

/// Weights whose sum is off from 1 by less than this count as rounded and are normalised; others are refused.
const WEIGHTS_MAY_BE_OFF: f64 = 1e-5;

/// The longest walk, in diagonals of the mesh: it takes minutes, and float32 is no longer exact long before that.
const LONGEST: f64 = 1e6;

/// Messages about single rows that cannot be answered, at most.
const MESSAGES: usize = 5;

/// A row as it was read.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// As given, whether there is such a face or not.
    face: i64,
    weights: DVec3,
    direction: DVec3,
    length: f64,
}

impl Start {
    /// Reads a row of [`COLUMNS`].
    fn read(row: Row<'_>) -> Result<Self> {
        let vector = |column| {
            Ok::<_, myxo::Error>(DVec3::new(
                row.number(column)?,
                row.number(column + 1)?,
                row.number(column + 2)?,
            ))
        };
        Ok(Self {
            face: row.integer(1)?,
            weights: vector(2)?,
            direction: vector(5)?,
            length: row.number(8)?,
        })
    }

    /// The walk of the row, if it is not longer than `longest`, or why there is none.
    fn query(&self, mesh: &Mesh, surface: &Surface, longest: f64) -> Result<WalkQuery, String> {
        let sum = self.weights.element_sum();
        if self.weights.min_element() < -WEIGHTS_MAY_BE_OFF
            || (sum - 1.0).abs() > WEIGHTS_MAY_BE_OFF
        {
            return Err("b0, b1, b2 are not weights that sum to 1".to_owned());
        }
        if self.length < 0.0 {
            return Err("the length is negative".to_owned());
        }
        if self.length > longest {
            return Err(format!(
                "the length is over {LONGEST:e} times the mesh's diagonal: walk {longest:e} at most"
            ));
        }
        let weights = self.weights.max(DVec3::ZERO);
        let weights = weights / weights.element_sum();
        let start = u32::try_from(self.face)
            .ok()
            .and_then(|face| mesh.point_from_file(face, weights.to_array()))
            .ok_or_else(|| format!("the mesh has no face {} to walk on", self.face))?;
        let frame = Frame::of(surface, start.triangle);
        // Scaled first, so that squares of tiny components do not underflow.
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
}

/// The rows of the answer, and messages about those that could not be answered.
#[derive(Debug)]
pub struct Answers {
    /// The table.
    pub text: String,
    /// A line for each refusal.
    pub refused: Vec<String>,
}

impl Answers {
    /// Prints messages about rows that could not be answered, and returns the table.
    pub fn into_table(self) -> String {
        for message in self.refused.iter().take(MESSAGES) {
            console::message(message);
        }
        if self.refused.len() > MESSAGES {
            console::message(&format!(
                "and {} more rows with status 2",
                self.refused.len() - MESSAGES
            ));
        }
        self.text
    }
}

/// A mesh that walks lie on, and its pose.
#[derive(Debug)]
pub struct Ground<'a> {
    /// As in its file.
    pub mesh: &'a Mesh,
    /// Its first triangle in the surface.
    pub first_triangle: u32,
    /// World from the surface's coordinates.
    pub world_from_surface: DAffine3,
}

/// The meshes that the walks of a table are on.
#[derive(Debug)]
pub struct Question<'a> {
    /// The first line of the answer.
    pub header: &'a str,
    /// All meshes.
    pub surface: &'a Surface,
    /// One mesh or two; walks begin on the first. With two, a column of the answer says on which one a walk ends.
    pub grounds: &'a [Ground<'a>],
}

/// Answers every walk in order, stopping at open borders, with as many edge crossings as needed.
pub type Engine<'a> = &'a dyn Fn(&Surface, &[WalkQuery]) -> Result<Vec<WalkEnd>>;

impl Question<'_> {
    /// Answers every row of a table by one call of an engine.
    pub fn answer(&self, table: &Table, engine: Engine<'_>) -> Result<Answers> {
        let mut queries = Vec::new();
        let mut starts = Vec::new();
        for row in table.rows() {
            let start = Start::read(row)?;
            let query = self.query(&start);
            queries.extend(query.as_ref().ok());
            starts.push((row, start, query.err()));
        }
        let mut ends = engine(self.surface, &queries)?.into_iter();
        let mut answers = Answers {
            text: format!("{}\n", self.header),
            refused: Vec::new(),
        };
        for (row, start, refusal) in starts {
            let end = match refusal {
                Some(reason) => Err(reason),
                None => match ends.next().expect("the engine answers every query") {
                    end if end.status == WalkStatus::OutOfAttempts => {
                        Err("the walk turns round a vertex and does not continue".to_owned())
                    }
                    end => Ok(end),
                },
            };
            let line = match end {
                Ok(end) => self.line(&end),
                Err(reason) => {
                    answers
                        .refused
                        .push(format!("{}: {reason}; the row gets status 2", row.place()));
                    self.line_back(&start)
                }
            };
            let _ = writeln!(answers.text, "{},{line}", in_csv(row.text(0)));
        }
        Ok(answers)
    }

    /// The walk of a row, or why there is none.
    fn query(&self, start: &Start) -> Result<WalkQuery, String> {
        let ground = &self.grounds[0];
        let diagonals = self.grounds.iter().map(|ground| {
            let (low, high) = ground.mesh.bounds();
            low.as_dvec3().distance(high.as_dvec3())
        });
        let longest = LONGEST * diagonals.sum::<f64>();
        let direction = ground.world_from_surface.matrix3.inverse() * start.direction;
        let start = Start {
            direction,
            ..*start
        };
        start.query(ground.mesh, self.surface, longest)
    }

    /// `1,` for the second of two meshes.
    fn which(&self, index: usize) -> String {
        if self.grounds.len() > 1 {
            format!("{index},")
        } else {
            String::new()
        }
    }

    /// The answer, without the id.
    fn line(&self, end: &WalkEnd) -> String {
        let SurfacePoint { triangle, u, v } = end.point;
        let index = self
            .grounds
            .partition_point(|ground| ground.first_triangle <= triangle)
            - 1;
        let ground = &self.grounds[index];
        let corners = self.surface.corners[triangle as usize];
        let [a, b, c] = corners.map(|corner| self.surface.positions[corner as usize].as_dvec3());
        let position = a + u * (b - a) + v * (c - a);
        let position = ground.world_from_surface.transform_point3(position);
        let frame = Frame::of(self.surface, triangle);
        let direction = end.heading.x * frame.p + end.heading.y * frame.h;
        let direction = (ground.world_from_surface.matrix3 * direction).normalize();
        let (face, [b0, b1, b2]) = ground.mesh.point_to_file(SurfacePoint {
            triangle: triangle - ground.first_triangle,
            ..end.point
        });
        let mut line = format!("{}{face}", self.which(index));
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
            // The shortest text that reads back as the same double.
            let _ = write!(line, ",{number}");
        }
        let status = u32::from(end.status == WalkStatus::Border);
        let _ = write!(line, ",{status}");
        line
    }

    /// The input row, for a walk that is not possible.
    fn line_back(&self, start: &Start) -> String {
        let (b, d) = (start.weights, start.direction);
        format!(
            "{}{},{},{},{},0,0,0,{},{},{},0,2",
            self.which(0),
            start.face,
            b.x,
            b.y,
            b.z,
            d.x,
            d.y,
            d.z
        )
    }
}
