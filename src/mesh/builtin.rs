//! Built-in meshes by name: `cube`, `torus`, `icosphere`, `plane` and `capsule`, each with parameters that have defaults,
//! and the embedded models.
//!
//! A name is written as in a web address: `torus`, `torus?major=64&minor=32`.

use super::gear::{Gear, gear};
use super::primitive::{capsule, cube, icosphere, periodic_plane, plane, torus};
use super::soup::MOST_TRIANGLES;
use super::{Mesh, MeshError, embedded};

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
        "2 by 2 in XZ, facing +Y, with an open border; `columns=64` and `rows=64` of quads; `periodic=true` glues opposite sides",
    ),
    (
        "capsule",
        "radius 0.5 about the Y axis, `length=1` between its half spheres' centres; `segments=96` around, `rings=24` a half sphere",
    ),
    (
        "gear",
        "a toothed wheel about the Y axis, `teeth=24`, `radius=1` of its pitch circle, `thickness=0.3`, `bore=0.3` its hole's radius, `play=0.02` between teeth as a share of the pitch; wheels with the same radius / teeth mesh",
    ),
    (
        "ring_gear",
        "a ring with teeth inside, `teeth=60`, `radius=2.5`, `thickness=0.3`, `bore=0.3` from the teeth to its rim, `play=0.02`",
    ),
    ("suzanne", "Blender's monkey; 3 parts with open borders"),
    ("trefoil", "a beaded trefoil knot; closed"),
    ("gyroid", "a ball cut from a gyroid; closed, 26 handles"),
];

impl Mesh {
    /// A built-in mesh by name, with or without `builtin:` before it and parameters behind it
    /// (`"torus?major=64&minor=32"`). [`BUILTINS`] lists them.
    ///
    /// # Errors
    /// When there is no such mesh or parameter, or a value is out of its range; the message names the right ones.
    pub fn builtin(name: &str) -> Result<Mesh, MeshError> {
        Self::builtin_within(name, MOST_TRIANGLES as u64)
    }

    pub(super) fn builtin_within(name: &str, most: u64) -> Result<Mesh, MeshError> {
        let whole = name.strip_prefix("builtin:").unwrap_or(name);
        let (name, query) = whole.split_once('?').unwrap_or((whole, ""));
        let mut parameters = Parameters::parse(name, query, most)?;
        let mesh = match name {
            "cube" => {
                let divisions = parameters.number("divisions", 1, 1, 1024)?;
                parameters.limit(12 * u64::from(divisions).pow(2))?;
                cube(divisions)
            }
            "torus" => {
                let major = parameters.number("major", 144, 3, 8192)?;
                let minor = parameters.number("minor", 96, 3, 8192)?;
                let tube = parameters.number("tube", 0.4, 0.001, 0.999)?;
                parameters.limit(2 * u64::from(major) * u64::from(minor))?;
                torus(major, minor, tube)
            }
            "icosphere" => {
                let subdivisions = parameters.number("subdivisions", 5, 0, 10)?;
                parameters.limit(20 * 4_u64.pow(subdivisions))?;
                icosphere(subdivisions)
            }
            "plane" => {
                let columns = parameters.number("columns", 64, 1, 4096)?;
                let rows = parameters.number("rows", 64, 1, 4096)?;
                parameters.limit(2 * u64::from(columns) * u64::from(rows))?;
                if parameters.flag("periodic")? {
                    periodic_plane(columns, rows)
                } else {
                    plane(columns, rows)
                }
            }
            "capsule" => {
                let segments = parameters.number("segments", 96, 3, 4096)?;
                let rings = parameters.number("rings", 24, 1, 2048)?;
                let length = parameters.number("length", 1.0, 0.001, 1000.0)?;
                parameters.limit(4 * u64::from(segments) * u64::from(rings))?;
                capsule(segments, rings, length)
            }
            "gear" | "ring_gear" => {
                let is_ring = name == "ring_gear";
                let [teeth, radius] = if is_ring { [60.0, 2.5] } else { [24.0, 1.0] };
                let wheel = Gear {
                    teeth: parameters.number("teeth", teeth as u32, 9, 1024)?,
                    radius: parameters.number("radius", radius, 0.001, 1000.0)?,
                    thickness: parameters.number("thickness", 0.3, 0.001, 1000.0)?,
                    bore: parameters.number("bore", 0.3, 0.001, 1000.0)?,
                    play: parameters.number("play", 0.02, 0.0, 0.2)?,
                    is_ring,
                };
                wheel.check().map_err(|problem| MeshError::Parameter {
                    name: name.to_owned(),
                    problem,
                })?;
                gear(&wheel)
            }
            _ if let Some(model) = embedded::model(name, most) => model?,
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
        // Wheels have at most some millions of triangles, which are counted only here.
        parameters.limit(mesh.corners.len() as u64)?;
        Ok(mesh)
    }
}

/// The parameters after a built-in's name; each is removed when read, and the rest is an error.
struct Parameters<'a> {
    mesh: &'a str,
    given: Vec<(&'a str, &'a str)>,
    known: Vec<&'static str>,
    /// The most triangles.
    most: u64,
}

impl<'a> Parameters<'a> {
    fn parse(mesh: &'a str, query: &'a str, most: u64) -> Result<Self, MeshError> {
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
            most,
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

    /// A switch, which is off by default.
    fn flag(&mut self, name: &'static str) -> Result<bool, MeshError> {
        match self.take(name) {
            None | Some("false") => Ok(false),
            Some("true") => Ok(true),
            Some(text) => Err(MeshError::Parameter {
                name: self.mesh.to_owned(),
                problem: format!("`{name}={text}` is neither true nor false"),
            }),
        }
    }

    /// Refuses so many triangles before any is made.
    fn limit(&self, triangles: u64) -> Result<(), MeshError> {
        let problem = if triangles > MOST_TRIANGLES as u64 {
            format!(
                "it would have {triangles} triangles, and {MOST_TRIANGLES} are the most that can be numbered: ask for fewer"
            )
        } else if triangles > self.most {
            format!(
                "it would have {triangles} triangles, and the atlas has room for {} more: raise atlas.size, or ask for fewer",
                self.most
            )
        } else {
            return Ok(());
        };
        Err(MeshError::Parameter {
            name: self.mesh.to_owned(),
            problem,
        })
    }

    fn finish(&self) -> Result<(), MeshError> {
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
    use std::f64::consts::PI;

    use super::*;
    use crate::mesh::surface::Surface;

    /// Both sides are in their ranges, and the product is not: without the limit this takes gigabytes, and panics.
    #[test]
    fn too_many_triangles_are_refused_before_they_are_made() {
        let error = Mesh::builtin("torus?major=8192&minor=8192").unwrap_err();
        let text = error.to_string();
        assert!(text.contains("134217728 triangles"), "{text}");
    }

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
            ("plane?columns=3&rows=2&periodic=true", 12, 12, 0, 10),
            ("capsule?segments=5&rings=3&length=0.5", 60, 32, 0, 0),
            ("gear?teeth=12", 9600, 4800, 1, 0),
            ("ring_gear?teeth=30&radius=1.25", 19_800, 9900, 1, 0),
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
    fn extreme_builtins_are_sound() {
        for name in [
            "torus?tube=0.001&minor=4096&major=3",
            "torus?tube=0.999&minor=3&major=4096",
            "capsule?length=1000&segments=3",
            "capsule?length=0.001&rings=1",
            "capsule?segments=4096&rings=1&length=0.001",
            "plane?columns=4096&rows=1",
            "plane?columns=1&rows=4096&periodic=true",
            "plane?columns=1&rows=1&periodic=true",
            "cube?divisions=64",
            "gear?teeth=9&bore=0.05&thickness=10",
            "gear?teeth=200&radius=1&bore=0.95",
            "ring_gear?teeth=12&radius=1&play=0.2&thickness=0.1",
        ] {
            let mesh = Mesh::builtin(name).unwrap();
            assert_eq!(mesh.report.oddities(), Vec::<String>::new(), "{name}");
            let surface = Surface::build(&[(&mesh, 1.0)]);
            assert_eq!(surface.validate(), Ok(()), "{name}");
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
            ("plane?periodic=1", "`periodic=1` is neither true nor false"),
            ("plane?period=true", "did you mean `periodic`?"),
            (
                "gear?bore=0.9",
                "leaves nothing between its hole and its teeth",
            ),
            ("gear?thickness=0.02", "is thinner than"),
        ] {
            let message = Mesh::builtin(name).unwrap_err().to_string();
            assert!(message.contains(words), "{name}: {message}");
        }
    }
}
