//! A zip archive of NumPy arrays: the whole state, in world coordinates where possible.
//!
//! `docs/npz.md` is this table with explanations; N particles, S texels per side, O objects, F foods, V vertices,
//! T triangles.
//!
//! | array | type | shape | unit |
//! | --- | --- | --- | --- |
//! | `layout_version` | `i8` | | 1 |
//! | `step`, `seed` | `i8` | | |
//! | `time` | `f8` | | seconds of the objects' motion |
//! | `scene_radius` | `f8` | | world units |
//! | `scene_name`, `scene_toml` | `U` | | |
//! | `version`, `commit`, `device`, `driver`, `state_hash` | `U` | | as reports have them |
//! | `particle_id` | `i4` | N | only if the number of particles changes |
//! | `particle_position` | `f4`, `f8` far from the origin | N, 3 | world units |
//! | `particle_heading` | `f4` | N, 3 | unit vectors, world |
//! | `particle_object` | `i4` | N | object |
//! | `particle_triangle` | `i4` | N | triangle |
//! | `particle_uv` | `f4` | N, 2 | weights of corners 1 and 2 |
//! | `particle_texel` | `f4` | N, 2 | texels: column, row |
//! | `particle_pending` | `f4` | N | world units |
//! | `trail` | `f4` | S, S | |
//! | `deposit` | `u4` | S, S | particles in the last step |
//! | `density` | `f4` | S, S | |
//! | `texel_area` | `f4` | S, S | world units squared |
//! | `texel_triangle`, `texel_object`, `texel_chart` | `i4` | S, S | -1: none |
//! | `texel_position` | `f4` | S, S, 3 | world units; NaN: none |
//! | `distance` | `f4` | S, S | world units; NaN: none |
//! | `nearest_triangle` | `i4` | S, S | -1: none within reach |
//! | `area_bias` | `f4` | S, S | trail |
//! | `area_no_go` | `?` | S, S | |
//! | `scent` | `f4` | S, S | |
//! | `particle_fed` | `i4` | N | steps |
//! | `food_object`, `food_triangle` | `i4` | F | object, triangle |
//! | `food_uv` | `f4` | F, 2 | weights of corners 1 and 2 |
//! | `food_position` | `f4` | F, 3 | world units |
//! | `food_radius`, `food_size` | `f4` | F | world units |
//! | `food_strength` | `f4` | F | |
//! | `food_amount`, `food_remaining` | `i8` | F | meals; -1: no end |
//! | `object_name` | `U` | O | |
//! | `world_from_object` | `f8` | O, 4, 4 | |
//! | `vertex_position` | `f4` | V, 3 | object space, scaled |
//! | `vertex_object` | `i4` | V | object |
//! | `triangle_vertices` | `i4` | T, 3 | vertices |
//! | `triangle_object`, `triangle_chart` | `i4` | T | |
//! | `triangle_texels` | `f4` | T, 3, 2 | texels: column, row |

use std::io::{self, Seek, Write};

use bytemuck::Pod;
use glam::{Affine3A, DMat4, Vec3};
use rayon::prelude::*;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::{Export, corners};
use crate::mesh::surface::NONE;
use crate::mesh::walk::{Frame, SurfacePoint};
use crate::scene::motion::double;
use crate::sim::food::scent_of;
use crate::sim::paint::NO_GO_BELOW;
use crate::sim::types::{Motion, Particle};

/// Increased by one when the meaning of an array changes.
const LAYOUT_VERSION: i64 = 1;

/// Writes everything.
///
/// # Errors
/// When the disk is full.
pub(super) fn write(export: &Export<'_>, out: &mut (impl Write + Seek)) -> io::Result<()> {
    let out = UntilFailed {
        out,
        has_failed: false,
        at: 0,
    };
    let mut archive = Archive(ZipWriter::new(out));
    archive.scalar("layout_version", LAYOUT_VERSION)?;
    archive.scalar("step", export.snapshot.step as i64)?;
    archive.scalar("seed", export.scene.settings.seed as i64)?;
    archive.scalar("time", export.time)?;
    archive.scalar("scene_radius", f64::from(export.scene.radius))?;
    archive.texts("scene_name", &[], &[export.scene.name.as_str()])?;
    archive.texts("scene_toml", &[], &[export.scene_file().as_str()])?;
    let commit = crate::commit().unwrap_or_default();
    let state_hash = format!("{:016x}", export.snapshot.hash());
    for (name, text) in [
        ("version", env!("CARGO_PKG_VERSION")),
        ("commit", &commit),
        ("device", &export.device),
        ("driver", &export.driver),
        ("state_hash", &state_hash),
    ] {
        archive.texts(name, &[], &[text])?;
    }
    write_particles(export, &mut archive)?;
    write_texels(export, &mut archive)?;
    write_foods(export, &mut archive)?;
    write_objects(export, &mut archive)?;
    archive.0.finish()?;
    Ok(())
}

/// A writer that ignores everything after the first failure: the archive writes its end in any case, and
/// would print an error.
struct UntilFailed<W> {
    out: W,
    has_failed: bool,
    /// Position of the next byte, if it is known.
    at: u64,
}

impl<W: Write> Write for UntilFailed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.has_failed {
            return Ok(bytes.len());
        }
        let written = self.out.write(bytes);
        self.has_failed = written.as_ref().is_err_and(is_final);
        self.at += *written.as_ref().unwrap_or(&0) as u64;
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.has_failed {
            return Ok(());
        }
        let flushed = self.out.flush();
        self.has_failed = flushed.as_ref().is_err_and(is_final);
        flushed
    }
}

/// Is the file lost? A write that a signal interrupts is repeated by the caller.
fn is_final(error: &io::Error) -> bool {
    error.kind() != io::ErrorKind::Interrupted
}

impl<W: Seek> Seek for UntilFailed<W> {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        if self.has_failed {
            return Ok(self.at);
        }
        // A buffering writer below may flush now, and fail.
        let sought = self.out.seek(to);
        self.has_failed = sought.is_err();
        self.at = *sought.as_ref().unwrap_or(&self.at);
        sought
    }
}

/// Row i is the particle with the id i, whatever its slot; of a population that changes, row i is the living particle that is number i by
/// its id.
fn write_particles<W: Write + Seek>(export: &Export<'_>, to: &mut Archive<W>) -> io::Result<()> {
    let (surface, atlas) = (&export.setup.surface, &export.setup.atlas);
    let state = &*export.snapshot;
    let mut by_id: Vec<(Particle, Motion)> = state
        .particles
        .iter()
        .copied()
        .zip(state.motions.iter().copied())
        .filter(|(_, motion)| !motion.is_dead())
        .collect();
    by_id.par_sort_unstable_by_key(|(particle, _)| particle.id);
    let object_of = |particle: &Particle| surface.triangles[particle.triangle as usize].object;
    let pose_of = |particle: &Particle| &export.world_from_object[object_of(particle) as usize];

    let n = [by_id.len()];
    if !state.population.is_empty() {
        to.array(
            "particle_id",
            &n,
            &of_all(&by_id, |(particle, _)| particle.id as i32),
        )?;
    }
    to.places(
        export,
        "particle_position",
        &[n[0], 3],
        &of_all(&by_id, |(particle, _)| {
            let Particle { triangle, u, v, .. } = *particle;
            place(export, pose_of(particle), triangle, u, v)
        }),
    )?;
    to.array(
        "particle_heading",
        &[n[0], 3],
        &of_all(&by_id, |(particle, motion)| {
            let frame = Frame::of(surface, particle.triangle);
            let heading =
                f64::from(motion.heading_p) * frame.p + f64::from(motion.heading_h) * frame.h;
            pose_of(particle)
                .transform_vector3(heading.as_vec3())
                .to_array()
        }),
    )?;
    to.array(
        "particle_object",
        &n,
        &of_all(&by_id, |(p, _)| object_of(p) as i32),
    )?;
    to.array(
        "particle_triangle",
        &n,
        &of_all(&by_id, |(p, _)| p.triangle as i32),
    )?;
    to.array(
        "particle_uv",
        &[n[0], 2],
        &of_all(&by_id, |(p, _)| [p.u, p.v]),
    )?;
    to.array(
        "particle_texel",
        &[n[0], 2],
        &of_all(&by_id, |(p, _)| {
            atlas.position_of(p.triangle, p.u, p.v).to_array()
        }),
    )?;
    to.array(
        "particle_pending",
        &n,
        &of_all(&by_id, |(_, motion)| motion.pending),
    )
}

fn write_texels<W: Write + Seek>(export: &Export<'_>, to: &mut Archive<W>) -> io::Result<()> {
    let (surface, atlas) = (&export.setup.surface, &export.setup.atlas);
    let state = &*export.snapshot;
    let side = atlas.size as usize;
    let shape = [side, side];
    // Rows of buffers are padded; those of arrays are not.
    let texels: Vec<u32> = (0..atlas.size)
        .flat_map(|row| row * atlas.pitch..row * atlas.pitch + atlas.size)
        .collect();
    let owned = |texel: u32| match atlas.owner[texel as usize] {
        NONE => None,
        triangle => Some(triangle),
    };
    to.array(
        "trail",
        &shape,
        &of_all(&texels, |&t| state.trail[t as usize]),
    )?;
    to.array(
        "deposit",
        &shape,
        &of_all(&texels, |&t| state.deposits[t as usize]),
    )?;
    to.array(
        "density",
        &shape,
        &of_all(&texels, |&t| atlas.density[t as usize]),
    )?;
    to.array(
        "texel_area",
        &shape,
        &of_all(&texels, |&t| atlas.area[t as usize]),
    )?;
    let integers = |value: &(dyn Fn(u32) -> u32 + Sync)| {
        of_all(&texels, |&texel| {
            owned(texel).map_or(-1, |triangle| value(triangle) as i32)
        })
    };
    to.array("texel_triangle", &shape, &integers(&|triangle| triangle))?;
    let object_of = |triangle: u32| surface.triangles[triangle as usize].object;
    to.array("texel_object", &shape, &integers(&object_of))?;
    to.array(
        "texel_chart",
        &shape,
        &integers(&|triangle| atlas.chart[triangle as usize]),
    )?;
    to.places(
        export,
        "texel_position",
        &[side, side, 3],
        &of_all(&texels, |&texel| match atlas.surface_point_of(texel) {
            Some((triangle, u, v)) => {
                let pose = &export.world_from_object[object_of(triangle) as usize];
                place(export, pose, triangle, u, v)
            }
            None => Vec3::NAN,
        }),
    )?;
    write_areas(export, &texels, to)?;
    let Some(distances) = &export.distances else {
        return Ok(());
    };
    to.array(
        "distance",
        &shape,
        &of_all(&texels, |&texel| {
            owned(texel).map_or(f32::NAN, |_| distances.signed[texel as usize])
        }),
    )?;
    to.array(
        "nearest_triangle",
        &shape,
        &of_all(&texels, |&texel| {
            let nearest = owned(texel).map(|_| distances.nearest[texel as usize]);
            nearest
                .filter(|&nearest| nearest != NONE)
                .map_or(-1, |nearest| nearest as i32)
        }),
    )
}

/// Painted areas, if there are any. No-go areas are a mask of their own, because the value of `NO_GO` has no meaning as a number.
fn write_areas<W: Write + Seek>(
    export: &Export<'_>,
    texels: &[u32],
    to: &mut Archive<W>,
) -> io::Result<()> {
    let bias = &export.snapshot.bias;
    if bias.is_empty() {
        return Ok(());
    }
    let side = export.setup.atlas.size as usize;
    let is_no_go = |texel: u32| bias[texel as usize] < NO_GO_BELOW;
    let read = of_all(texels, |&texel| {
        if is_no_go(texel) {
            0.0
        } else {
            bias[texel as usize]
        }
    });
    to.array("area_bias", &[side, side], &read)?;
    let no_go = of_all(texels, |&texel| u8::from(is_no_go(texel)));
    to.typed("area_no_go", "|b1", &[side, side], &no_go)
}

/// Foods and markers, if there are any: their places, their present scent, and which particles are fed.
fn write_foods<W: Write + Seek>(export: &Export<'_>, to: &mut Archive<W>) -> io::Result<()> {
    let atlas = &export.setup.atlas;
    let food_set = &export.setup.food_set;
    if food_set.is_empty() {
        return Ok(());
    }
    let left = &export.snapshot.food.remaining;
    let field = scent_of(food_set, &food_set.meals(Some(left)));
    let side = atlas.size as usize;
    let rows = field.chunks(atlas.pitch as usize).take(side);
    let texels: Vec<f32> = rows.flat_map(|row| &row[..side]).copied().collect();
    to.array("scent", &[side, side], &texels)?;

    let state = &export.snapshot;
    let mut fed: Vec<(u32, i32)> = (state.particles.iter().zip(&state.motions))
        .filter(|(_, motion)| !motion.is_dead())
        .map(|(particle, motion)| (particle.id, motion.fed() as i32))
        .collect();
    fed.par_sort_unstable_by_key(|(id, _)| *id);
    to.array(
        "particle_fed",
        &[fed.len()],
        &of_all(&fed, |(_, steps)| *steps),
    )?;

    let foods = &food_set.places;
    let n = [foods.len()];
    let object = of_all(foods, |food| food.object as i32);
    to.array("food_object", &n, &object)?;
    let triangle = of_all(foods, |food| food.point.triangle as i32);
    to.array("food_triangle", &n, &triangle)?;
    let uv = of_all(foods, |food| [food.point.u as f32, food.point.v as f32]);
    to.array("food_uv", &[n[0], 2], &uv)?;
    let position = of_all(foods, |food| {
        let pose = &export.world_from_object[food.object as usize];
        let SurfacePoint { triangle, u, v } = food.point;
        place(export, pose, triangle, u as f32, v as f32)
    });
    to.places(export, "food_position", &[n[0], 3], &position)?;
    to.array("food_radius", &n, &of_all(foods, |food| food.radius as f32))?;
    to.array("food_size", &n, &of_all(foods, |food| food.size as f32))?;
    to.array("food_strength", &n, &of_all(foods, |food| food.strength))?;
    // Endless food has no number of meals.
    let meals = |amount: u32, meals: u32| if amount == 0 { -1 } else { i64::from(meals) };
    let amount = of_all(foods, |food| meals(food.amount, food.amount));
    to.array("food_amount", &n, &amount)?;
    let both = foods.iter().zip(left);
    let remaining: Vec<i64> = both.map(|(food, &left)| meals(food.amount, left)).collect();
    to.array("food_remaining", &n, &remaining)
}

fn write_objects<W: Write + Seek>(export: &Export<'_>, to: &mut Archive<W>) -> io::Result<()> {
    let (surface, atlas) = (&export.setup.surface, &export.setup.atlas);
    let objects = &export.scene.settings.objects;
    let names: Vec<&str> = objects.iter().map(|object| object.name.as_str()).collect();
    to.texts("object_name", &[names.len()], &names)?;
    let origins = &export.scene.origins;
    let rows = export.world_from_object.iter().zip(origins);
    let rows = rows.map(|(pose, origins)| {
        let pose = DMat4::from(origins.to_world(double(pose)));
        // NumPy's arrays have rows first.
        pose.transpose().to_cols_array()
    });
    let rows: Vec<[f64; 16]> = rows.collect();
    to.array("world_from_object", &[rows.len(), 4, 4], &rows)?;

    let shape = [surface.positions.len(), 3];
    if export.is_far_from_origin() {
        let all = surface.objects.iter().zip(origins);
        let positions = all.flat_map(|(range, origins)| {
            let own = range.vertices.0 as usize..range.vertices.1 as usize;
            let own = surface.positions[own].iter();
            own.map(|position| (position.as_dvec3() + origins.surface).to_array())
        });
        to.array("vertex_position", &shape, &positions.collect::<Vec<_>>())?;
    } else {
        to.array(
            "vertex_position",
            &shape,
            &of_all(&surface.positions, Vec3::to_array),
        )?;
    }
    let vertices = surface
        .objects
        .iter()
        .enumerate()
        .flat_map(|(object, range)| {
            (range.vertices.0..range.vertices.1).map(move |_| object as i32)
        });
    to.array("vertex_object", &shape[..1], &vertices.collect::<Vec<_>>())?;

    let triangles: Vec<u32> = (0..surface.corners.len() as u32).collect();
    let t = triangles.len();
    to.array(
        "triangle_vertices",
        &[t, 3],
        &of_all(&triangles, |&triangle| {
            surface.corners[triangle as usize].map(|vertex| vertex as i32)
        }),
    )?;
    to.array(
        "triangle_object",
        &[t],
        &of_all(&triangles, |&triangle| {
            surface.triangles[triangle as usize].object as i32
        }),
    )?;
    to.array(
        "triangle_chart",
        &[t],
        &of_all(&triangles, |&triangle| {
            atlas.chart[triangle as usize] as i32
        }),
    )?;
    to.array(
        "triangle_texels",
        &[t, 3, 2],
        &of_all(&triangles, |&triangle| {
            let corners = [0, 1, 2].map(|k| corners::atlas_position(atlas, 3 * triangle + k));
            bytemuck::cast::<_, [f32; 6]>(corners)
        }),
    )
}

/// A point of a triangle in the world.
fn place(export: &Export<'_>, pose: &Affine3A, triangle: u32, u: f32, v: f32) -> Vec3 {
    let [a, b, c] = [0, 1, 2].map(|k| corners::position(&export.setup.surface, 3 * triangle + k));
    pose.transform_point3(a + u * (b - a) + v * (c - a))
}

fn of_all<T: Sync, U: Send>(items: &[T], value: impl Fn(&T) -> U + Sync) -> Vec<U> {
    items.par_iter().map(&value).collect()
}

/// Element types of arrays, with their names in headers.
trait Element: Pod {
    const TYPE: &'static str;
}

macro_rules! elements {
    ($($element:ty: $name:literal),*) => {
        $(impl Element for $element {
            const TYPE: &'static str = $name;
        })*
    };
}

// Little-endian, as memory is on every machine with Vulkan that Rust runs on today.
elements!(
    i64: "<i8", f64: "<f8", i32: "<i4", u32: "<u4", f32: "<f4",
    [f32; 2]: "<f4", [f32; 3]: "<f4", [f64; 3]: "<f8", [f32; 6]: "<f4", [i32; 3]: "<i4", [f64; 16]: "<f8"
);

/// The archive. Entries are not compressed: floats hardly shrink, and reading is faster.
struct Archive<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> Archive<W> {
    fn scalar<T: Element>(&mut self, name: &str, value: T) -> io::Result<()> {
        self.array(name, &[], &[value])
    }

    /// Converts places relative to the scene's origin to world coordinates, in double precision if the origin is far away.
    fn places(
        &mut self,
        export: &Export<'_>,
        name: &str,
        shape: &[usize],
        places: &[Vec3],
    ) -> io::Result<()> {
        if export.is_far_from_origin() {
            let places = of_all(places, |&place| export.in_world(place).to_array());
            self.array(name, shape, &places)
        } else {
            self.array(name, shape, &of_all(places, Vec3::to_array))
        }
    }

    fn array<T: Element>(&mut self, name: &str, shape: &[usize], values: &[T]) -> io::Result<()> {
        self.typed(name, T::TYPE, shape, values)
    }

    /// Texts of one length, four bytes a character, as NumPy has them.
    fn texts(&mut self, name: &str, shape: &[usize], texts: &[&str]) -> io::Result<()> {
        let lengths = texts.iter().map(|text| text.chars().count());
        let length = lengths.max().unwrap_or(0).max(1);
        let characters = texts.iter().flat_map(|text| {
            let padding = std::iter::repeat('\0');
            text.chars().chain(padding).take(length)
        });
        let characters: Vec<u32> = characters.map(u32::from).collect();
        self.typed(name, &format!("<U{length}"), shape, &characters)
    }

    fn typed<T: Pod>(
        &mut self,
        name: &str,
        kind: &str,
        shape: &[usize],
        values: &[T],
    ) -> io::Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            // Sizes have 32 bits unless large files are requested first.
            .large_file(bytes.len() as u64 + 1024 > u64::from(u32::MAX));
        self.0.start_file(format!("{name}.npy"), options)?;
        self.0.write_all(&header(kind, shape))?;
        self.0.write_all(bytes)
    }
}

/// The header of an array (NumPy Enhancement Proposal 1, version 1.0).
fn header(kind: &str, shape: &[usize]) -> Vec<u8> {
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sides}), }}");
    const BEFORE: usize = 10;
    // Elements begin at a multiple of 64 bytes, and the text ends with a line feed.
    let length = (BEFORE + text.len() + 1).next_multiple_of(64) - BEFORE;
    text.extend(std::iter::repeat_n(' ', length - 1 - text.len()));
    text.push('\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((length as u16).to_le_bytes());
    header.extend(text.bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every other call is interrupted, the first one too.
    #[derive(Default)]
    struct Disturbed {
        content: Vec<u8>,
        is_interrupted: bool,
    }

    impl Disturbed {
        fn interrupt(&mut self) -> io::Result<()> {
            self.is_interrupted = !self.is_interrupted;
            match self.is_interrupted {
                true => Err(io::ErrorKind::Interrupted.into()),
                false => Ok(()),
            }
        }
    }

    impl Write for Disturbed {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.interrupt()?;
            self.content.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            self.interrupt()
        }
    }

    /// Would catch: a signal after which nothing more is written, and no error says so.
    #[test]
    fn what_is_interrupted_is_written_all_the_same() {
        let mut file = UntilFailed {
            out: Disturbed::default(),
            has_failed: false,
            at: 0,
        };
        file.write_all(b"all ").unwrap();
        let interrupted = file.flush().unwrap_err();
        assert_eq!(interrupted.kind(), io::ErrorKind::Interrupted);
        file.flush().unwrap();
        file.write_all(b"of it").unwrap();
        assert_eq!(
            (file.out.content.as_slice(), file.at),
            (&b"all of it"[..], 9)
        );
    }
}
