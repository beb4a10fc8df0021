//! Built-in meshes: `cube`, `torus`, `icosphere`, `plane` and `capsule`, each with parameters that have defaults.
//!
//! A name is written as in a web address: `torus`, `torus?major=64&minor=32`. All are centred at the origin, with +Y up.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::soup::Soup;
use super::{Mesh, MeshError};

/// The name of every built-in mesh, with its parameters and their defaults.
pub const BUILTINS: &[(&str, &str)] = &[
    (
        "cube",
        "12 triangles, edges of 2; `divisions=1` splits each edge",
    ),
    (
        "torus",
        "radius 1 about the Y axis, `tube=0.4` its tube's radius; `major=144` and `minor=96` segments",
    ),
    (
        "icosphere",
        "radius 1; `subdivisions=5`, each of which quarters the 20 triangles",
    ),
    (
        "plane",
        "2 by 2 in XZ, facing +Y, with an open border; `columns=64` and `rows=64` of quads",
    ),
    (
        "capsule",
        "radius 0.5 about the Y axis, `length=1` between its half spheres' centres; `segments=96` around, `rings=24` a half sphere",
    ),
];

impl Mesh {
    /// A built-in mesh by name, with or without `builtin:` before it and parameters behind it
    /// (`"torus?major=64&minor=32"`). [`BUILTINS`] lists them.
    ///
    /// # Errors
    /// When there is no such mesh or parameter, or a value is out of its range; the message names the right ones.
    pub fn builtin(name: &str) -> Result<Mesh, MeshError> {
        let whole = name.strip_prefix("builtin:").unwrap_or(name);
        let (name, query) = whole.split_once('?').unwrap_or((whole, ""));
        let mut parameters = Parameters::parse(name, query)?;
        let mesh = match name {
            "cube" => {
                let divisions = parameters.count("divisions", 1, 1, 1024)?;
                cube(divisions)
            }
            "torus" => {
                let major = parameters.count("major", 144, 3, 8192)?;
                let minor = parameters.count("minor", 96, 3, 8192)?;
                let tube = parameters.length("tube", 0.4, 0.001, 0.999)?;
                torus(major, minor, tube)
            }
            "icosphere" => {
                let subdivisions = parameters.count("subdivisions", 5, 0, 10)?;
                icosphere(subdivisions)
            }
            "plane" => {
                let columns = parameters.count("columns", 64, 1, 4096)?;
                let rows = parameters.count("rows", 64, 1, 4096)?;
                plane(columns, rows)
            }
            "capsule" => {
                let segments = parameters.count("segments", 96, 3, 4096)?;
                let rings = parameters.count("rings", 24, 1, 2048)?;
                let length = parameters.length("length", 1.0, 0.001, 1000.0)?;
                capsule(segments, rings, length)
            }
            _ => {
                let names = BUILTINS.iter().map(|(name, _)| *name);
                return Err(MeshError::UnknownBuiltin {
                    name: name.to_owned(),
                    nearest: nearest(name, names.clone()),
                    known: names.collect::<Vec<_>>().join(", "),
                });
            }
        };
        parameters.finish()?;
        Ok(mesh)
    }
}

/// A cube with edges of 2 about the origin; each face is a grid of `divisions` squared quads of two triangles.
#[must_use]
pub fn cube(divisions: u32) -> Mesh {
    assert!(divisions > 0, "a cube's edges need a division at least");
    let n = divisions;
    let side = n + 1;
    let mut grid = vec![u32::MAX; (side * side * side) as usize];
    let mut builder = Builder::default();
    let coordinate = |i: u32| f64::from(2 * i) / f64::from(n) - 1.0;
    let mut vertex = |builder: &mut Builder, at: [u32; 3]| {
        let place = &mut grid[((at[2] * side + at[1]) * side + at[0]) as usize];
        if *place == u32::MAX {
            *place = builder.vertex(DVec3::from_array(at.map(coordinate)));
        }
        *place
    };
    for axis in 0..3 {
        for end in [0, n] {
            // On the far side (u, v, axis) is right-handed; on the near side u and v trade places.
            let (u, v) = if end == n {
                ((axis + 1) % 3, (axis + 2) % 3)
            } else {
                ((axis + 2) % 3, (axis + 1) % 3)
            };
            for j in 0..n {
                for i in 0..n {
                    let mut corner = |di: u32, dj: u32| {
                        let mut at = [0; 3];
                        at[axis] = end;
                        at[u] = i + di;
                        at[v] = j + dj;
                        vertex(&mut builder, at)
                    };
                    let quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    builder.quad(quad);
                }
            }
        }
    }
    builder.finish("cube")
}

/// A torus about the Y axis: radius 1 to the middle of the tube, `tube` the tube's own radius,
/// `major` segments around the axis and `minor` around the tube; `2 * major * minor` triangles.
#[must_use]
pub fn torus(major: u32, minor: u32, tube: f64) -> Mesh {
    assert!(
        major >= 3 && minor >= 3,
        "a torus needs three segments each way"
    );
    let mut builder = Builder::default();
    for i in 0..major {
        let (sin_major, cos_major) = turn(i, major).sin_cos();
        for j in 0..minor {
            let (sin_minor, cos_minor) = turn(j, minor).sin_cos();
            let out = 1.0 + tube * cos_minor;
            builder.vertex(DVec3::new(
                out * cos_major,
                tube * sin_minor,
                out * sin_major,
            ));
        }
    }
    let at = |i: u32, j: u32| (i % major) * minor + j % minor;
    for i in 0..major {
        for j in 0..minor {
            builder.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    builder.finish("torus")
}

/// A sphere of radius 1: an icosahedron whose triangles are quartered `subdivisions` times; `20 * 4^subdivisions`.
#[must_use]
pub fn icosphere(subdivisions: u32) -> Mesh {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for (one, other) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        points.push(DVec3::new(one, other, 0.0).normalize());
        points.push(DVec3::new(0.0, one, other).normalize());
        points.push(DVec3::new(other, 0.0, one).normalize());
    }
    let mut corners = hull_of_icosahedron(&points);
    for _ in 0..subdivisions {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let point = (points[a as usize] + points[b as usize]).normalize();
                points.push(point);
                points.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(4 * corners.len());
        for &[a, b, c] in &corners {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        corners = finer;
    }
    let builder = Builder {
        positions: points.iter().map(|point| point.as_vec3()).collect(),
        corners,
    };
    builder.finish("icosphere")
}

/// The 20 triples of points that are one edge apart, wound outwards.
fn hull_of_icosahedron(points: &[DVec3]) -> Vec<[u32; 3]> {
    let near = |a: usize, b: usize| points[a].dot(points[b]) > 0.4;
    let mut corners = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = points[a].dot(points[b].cross(points[c])) > 0.0;
                    let [b, c] = if outward { [b, c] } else { [c, b] };
                    corners.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    corners
}

/// A square of 2 by 2 in the XZ plane that faces +Y, of `columns` (along X) by `rows` (along Z) quads.
#[must_use]
pub fn plane(columns: u32, rows: u32) -> Mesh {
    assert!(
        columns > 0 && rows > 0,
        "a plane needs a quad at least each way"
    );
    let mut builder = Builder::default();
    let coordinate = |i: u32, n: u32| f64::from(2 * i) / f64::from(n) - 1.0;
    for j in 0..=rows {
        for i in 0..=columns {
            builder.vertex(DVec3::new(coordinate(i, columns), 0.0, coordinate(j, rows)));
        }
    }
    let at = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            builder.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    builder.finish("plane")
}

/// A capsule of radius 0.5 about the Y axis, `length` between the centres of its half spheres;
/// `segments` around, `rings` in each half sphere, and as many along the side as make its quads nearly square.
#[must_use]
pub fn capsule(segments: u32, rings: u32, length: f64) -> Mesh {
    assert!(
        segments >= 3 && rings >= 1,
        "a capsule needs three segments and a ring"
    );
    let radius = 0.5;
    let side_rings = (length / (TAU * radius / f64::from(segments)))
        .round()
        .clamp(1.0, 4096.0) as u32;
    // Heights and radii of the circles, bottom to top, without the poles.
    let mut circles = Vec::new();
    for i in 1..=rings {
        let (sin, cos) = (0.5 * PI * f64::from(i) / f64::from(rings)).sin_cos();
        circles.push((-0.5 * length - radius * cos, radius * sin));
    }
    for i in 1..side_rings {
        circles.push((
            length * (f64::from(i) / f64::from(side_rings) - 0.5),
            radius,
        ));
    }
    for i in 0..rings {
        let (sin, cos) = (0.5 * PI * f64::from(i) / f64::from(rings)).sin_cos();
        circles.push((0.5 * length + radius * sin, radius * cos));
    }
    let mut builder = Builder::default();
    let bottom = builder.vertex(DVec3::new(0.0, -0.5 * length - radius, 0.0));
    for &(height, around) in &circles {
        for i in 0..segments {
            let (sin, cos) = turn(i, segments).sin_cos();
            builder.vertex(DVec3::new(around * cos, height, around * sin));
        }
    }
    let top = builder.vertex(DVec3::new(0.0, 0.5 * length + radius, 0.0));
    let at = |ring: u32, i: u32| 1 + ring * segments + i % segments;
    let last = circles.len() as u32 - 1;
    for i in 0..segments {
        builder.triangle([bottom, at(0, i), at(0, i + 1)]);
    }
    for ring in 0..last {
        for i in 0..segments {
            builder.quad([
                at(ring, i),
                at(ring + 1, i),
                at(ring + 1, i + 1),
                at(ring, i + 1),
            ]);
        }
    }
    for i in 0..segments {
        builder.triangle([top, at(last, i + 1), at(last, i)]);
    }
    builder.finish("capsule")
}

fn turn(i: u32, n: u32) -> f64 {
    TAU * f64::from(i) / f64::from(n)
}

#[derive(Default)]
struct Builder {
    positions: Vec<Vec3>,
    corners: Vec<[u32; 3]>,
}

impl Builder {
    fn vertex(&mut self, position: DVec3) -> u32 {
        self.positions.push(position.as_vec3());
        self.positions.len() as u32 - 1
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        self.corners.push(corners);
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    fn finish(self, name: &str) -> Mesh {
        let soup = Soup {
            positions: self.positions,
            triangles: self.corners,
            ..Soup::default()
        };
        Mesh::from_soup(name, soup).expect("the shape has an inside")
    }
}

/// The parameters behind a built-in's name; each is taken once, and what is left over is an error.
struct Parameters<'a> {
    mesh: &'a str,
    given: Vec<(&'a str, &'a str)>,
    known: Vec<&'static str>,
}

impl<'a> Parameters<'a> {
    fn parse(mesh: &'a str, query: &'a str) -> Result<Self, MeshError> {
        let mut given = Vec::new();
        for part in query.split('&').filter(|part| !part.is_empty()) {
            match part.split_once('=') {
                Some(pair) => given.push(pair),
                None => {
                    return Err(MeshError::Parameter {
                        name: mesh.to_owned(),
                        problem: format!("`{part}` is not of the form NAME=VALUE"),
                    });
                }
            }
        }
        Ok(Self {
            mesh,
            given,
            known: Vec::new(),
        })
    }

    fn take(&mut self, name: &'static str) -> Option<&'a str> {
        self.known.push(name);
        let index = self.given.iter().position(|(key, _)| *key == name)?;
        Some(self.given.remove(index).1)
    }

    fn number<T: std::str::FromStr + PartialOrd + std::fmt::Display>(
        &mut self,
        name: &'static str,
        default: T,
        least: T,
        most: T,
    ) -> Result<T, MeshError> {
        let Some(text) = self.take(name) else {
            return Ok(default);
        };
        match text.parse::<T>() {
            Ok(value) if value >= least && value <= most => Ok(value),
            _ => Err(MeshError::Parameter {
                name: self.mesh.to_owned(),
                problem: format!("`{name}={text}` is not a number from {least} to {most}"),
            }),
        }
    }

    fn count(
        &mut self,
        name: &'static str,
        default: u32,
        least: u32,
        most: u32,
    ) -> Result<u32, MeshError> {
        self.number(name, default, least, most)
    }

    fn length(
        &mut self,
        name: &'static str,
        default: f64,
        least: f64,
        most: f64,
    ) -> Result<f64, MeshError> {
        self.number(name, default, least, most)
    }

    fn finish(self) -> Result<(), MeshError> {
        let Some((key, _)) = self.given.first() else {
            return Ok(());
        };
        let hint = match nearest(key, self.known.iter().copied()) {
            Some(name) => format!(", did you mean `{name}`?"),
            None => String::new(),
        };
        Err(MeshError::Parameter {
            name: self.mesh.to_owned(),
            problem: format!(
                "there is no parameter `{key}`, or it is given twice{hint}: the names are {}",
                self.known.join(", ")
            ),
        })
    }
}

/// The most similar of some names, if one is similar at all.
fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    known
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(similarity, _)| *similarity > 0.7)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface::Surface;

    #[test]
    fn builtins_are_what_their_reports_say() {
        for (name, triangles, vertices, genus, borders) in [
            ("cube", 12, 8, 0, 0),
            ("cube?divisions=5", 300, 152, 0, 0),
            ("torus", 27_648, 13_824, 1, 0),
            ("builtin:torus?major=3&minor=3", 18, 9, 1, 0),
            ("icosphere?subdivisions=0", 20, 12, 0, 0),
            ("icosphere", 20_480, 10_242, 0, 0),
            ("plane?columns=3&rows=2", 12, 12, 0, 10),
            ("capsule?segments=5&rings=3&length=0.5", 60, 32, 0, 0),
        ] {
            let mesh = Mesh::builtin(name).unwrap();
            let report = &mesh.report;
            assert_eq!(report.triangles, triangles, "{name}");
            assert_eq!(report.vertices, vertices, "{name}");
            assert_eq!(report.genus(), genus, "{name}");
            assert_eq!(report.border_edges, borders, "{name}");
            assert_eq!(report.parts, 1, "{name}");
            Surface::build(&[(&mesh, 1.0)]).validate().unwrap();
        }
    }

    #[test]
    fn closed_builtins_face_outwards_and_have_their_volume() {
        for (name, volume) in [
            ("cube", 8.0),
            ("torus", 2.0 * PI * PI * 0.16),
            ("icosphere", 4.0 / 3.0 * PI),
            ("capsule", PI * 0.25 + 4.0 / 3.0 * PI * 0.125),
        ] {
            let mesh = Mesh::builtin(name).unwrap();
            let measured: f64 = mesh
                .corners
                .iter()
                .map(|corners| {
                    let [a, b, c] = corners.map(|v| mesh.positions[v as usize].as_dvec3());
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!(
                (measured / volume - 1.0).abs() < 0.01,
                "{name}: {measured} and not {volume}"
            );
        }
    }

    #[test]
    fn mistakes_are_answered_with_what_is_right() {
        for (name, words) in [
            ("tours", "did you mean `torus`?"),
            ("teapot", "the names are cube, torus"),
            ("torus?mayor=5", "did you mean `major`?"),
            ("torus?major=2", "`major=2` is not a number from 3 to 8192"),
            ("torus?major", "not of the form NAME=VALUE"),
            ("torus?tube=nan", "not a number from 0.001 to 0.999"),
            ("torus?major=5&major=6", "given twice"),
        ] {
            let message = Mesh::builtin(name).unwrap_err().to_string();
            assert!(message.contains(words), "{name}: {message}");
        }
    }
}
