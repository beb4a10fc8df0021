//! OBJ files: text with vertices (`v`), texture coordinates (`vt`) and faces (`f`).
//!
//! `tobj` reads the numbers. It is given only the lines that make a surface, because it takes a polyline of three
//! vertices for a triangle, stops at a comment behind a face, and reads neither CR alone as a line end nor UTF-16. Its errors name neither
//! the line nor the face, so after an error the lines are read again, for the message.

use glam::{DVec2, DVec3, Vec2};

use super::error::MeshProblem;
use super::soup::Soup;
use super::text;

/// Reads everything in the file as one surface. Triangles are numbered face by face, n - 2 for a face of n corners, as returned by
/// [`triangulate`](super::polygon::triangulate).
pub(crate) fn read(bytes: &[u8]) -> Result<Soup, MeshProblem> {
    let lines = SurfaceLines::collect(&text::decode(bytes));
    // Faces that tobj skips or on which it overflows.
    if lines.has_odd_faces
        && let Some(problem) = lines.find_problem()
    {
        return Err(problem);
    }
    let options = tobj::LoadOptions {
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    // Materials are never read: the surface does not need them, and their paths are untrusted.
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::MaterialParseError);
    let (models, _) = tobj::load_obj_buf(&mut lines.text.as_bytes(), &options, no_materials)
        .map_err(|error| lines.explain(&error.to_string()))?;
    // Without object and group lines there is one model.
    let mesh = models
        .into_iter()
        .next()
        .map(|model| model.mesh)
        .filter(|mesh| !mesh.indices.is_empty())
        .ok_or_else(|| lines.no_triangles())?;
    let positions: Vec<DVec3> = chunks(&mesh.positions).map(DVec3::from_array).collect();
    // Beyond float32 a number counts as infinite.
    if !positions.iter().all(|p| p.as_vec3().is_finite()) {
        return Err(lines.explain("a vertex is not finite"));
    }
    let may_have_uvs = lines.every_corner_has_uv && !lines.has_bad_texcoords;
    let uvs = may_have_uvs.then(|| uvs_of(&mesh)).flatten();

    // tobj leaves out vertices that no face names.
    let unused = lines.vertices.len() - positions.len();
    let mut soup = Soup {
        uvs: uvs.is_some().then(Vec::new),
        positions,
        ..Soup::default()
    };
    soup.seen.file_vertices = unused;
    soup.seen.unreferenced_vertices = unused;
    soup.seen.unreferenced_non_finite = lines.non_finite_vertices().count();
    soup.seen.incomplete_uvs =
        uvs.is_none() && (lines.some_corner_has_uv || lines.has_bad_texcoords);
    soup.seen.lines = lines.line_count;
    soup.seen.points = lines.point_count;
    soup.seen.free_form_lines = lines.free_form_count;

    // Without sizes all faces are triangles.
    let sizes = match mesh.face_arities.is_empty() {
        true => vec![3; mesh.indices.len() / 3],
        false => mesh.face_arities,
    };
    let mut first = 0;
    for size in sizes {
        let face = first..first + size as usize;
        soup.add_polygon(
            &mesh.indices[face.clone()],
            uvs.as_ref().map(|uvs| &uvs[face.clone()]),
        );
        first = face.end;
    }
    Ok(soup)
}

fn chunks<T: Copy, const N: usize>(flat: &[T]) -> impl Iterator<Item = [T; N]> {
    flat.as_chunks().0.iter().copied()
}

/// Texture coordinates by corner, if they are all there and finite.
fn uvs_of(mesh: &tobj::Mesh) -> Option<Vec<Vec2>> {
    let coordinates: Vec<Vec2> = chunks(&mesh.texcoords)
        .map(|uv| DVec2::from_array(uv).as_vec2())
        .collect();
    let complete = mesh.texcoord_indices.len() == mesh.indices.len();
    let finite = coordinates.iter().all(|coordinate| coordinate.is_finite());
    let uv_of = |&corner: &u32| coordinates[corner as usize];
    (complete && finite).then(|| mesh.texcoord_indices.iter().map(uv_of).collect())
}

/// The lines that make a surface, one `v`, `vt` or `f` to a line and nothing else on it.
#[derive(Default)]
struct SurfaceLines {
    text: String,
    /// Number in the file of each `v` line, and so on.
    vertices: Vec<usize>,
    texcoords: Vec<usize>,
    faces: Vec<usize>,
    line_count: usize,
    point_count: usize,
    free_form_count: usize,
    /// A face without corners, or one that counts back beyond the first texture coordinate.
    has_odd_faces: bool,
    /// A texture coordinate without a number; zeros stand for it in the text.
    has_bad_texcoords: bool,
    some_corner_has_uv: bool,
    every_corner_has_uv: bool,
}

impl SurfaceLines {
    fn collect(file: &str) -> Self {
        let mut lines = Self {
            text: String::with_capacity(file.len()),
            every_corner_has_uv: true,
            ..Self::default()
        };
        // A line that continues, and the number of its first part.
        let mut continued = String::new();
        let mut first = None;
        for (index, line) in text::lines(file).enumerate() {
            let number = *first.get_or_insert(index + 1);
            let line = line.split('#').next().unwrap_or_default();
            let line = line.trim_matches(|c: char| c.is_whitespace() || c == '\0');
            if let Some(beginning) = line.strip_suffix('\\') {
                continued += beginning;
                continued.push(' ');
                continue;
            }
            if continued.is_empty() {
                lines.add(number, line);
            } else {
                continued += line;
                lines.add(number, &continued);
                continued.clear();
            }
            first = None;
        }
        if let Some(number) = first {
            lines.add(number, &continued);
        }
        lines
    }

    fn add(&mut self, number: usize, line: &str) {
        let Some((keyword, rest)) = line.split_once(|c: char| c.is_ascii_whitespace()) else {
            // A keyword alone is an error that `explain` words, if it is one that matters.
            if matches!(line, "v" | "vt" | "f") {
                self.add(number, &format!("{line} "));
            }
            return;
        };
        match keyword {
            // Weights and colours behind the coordinates are left out.
            "v" => {
                self.vertices.push(number);
                self.push("v", rest.split_ascii_whitespace().take(3));
            }
            "vt" => {
                self.texcoords.push(number);
                let mut words = rest.split_ascii_whitespace();
                let mut pair = [
                    words.next().unwrap_or_default(),
                    words.next().unwrap_or("0"),
                ];
                if pair.iter().any(|word| word.parse::<f64>().is_err()) {
                    self.has_bad_texcoords = true;
                    pair = ["0"; 2];
                }
                self.push("vt", pair.into_iter());
            }
            "f" => {
                self.faces.push(number);
                for corner in rest.split_ascii_whitespace() {
                    // An index 0 means that there is none; tobj would repeat the one before.
                    let uv = corner.split('/').nth(1).and_then(|uv| uv.parse().ok());
                    let has_uv = uv.is_some_and(|index: i64| index != 0);
                    let back = |index: i64| index.checked_add_unsigned(self.texcoords.len() as u64);
                    self.has_odd_faces |= uv.and_then(back).is_some_and(|from_zero| from_zero < 0);
                    self.some_corner_has_uv |= has_uv;
                    self.every_corner_has_uv &= has_uv;
                }
                self.push("f", rest.split_ascii_whitespace());
                match rest.split_ascii_whitespace().count() {
                    0 => self.has_odd_faces = true,
                    1 => self.point_count += 1,
                    2 => self.line_count += 1,
                    _ => {}
                }
            }
            "l" => self.line_count += 1,
            "p" => self.point_count += 1,
            "curv" | "curv2" | "surf" | "vp" | "cstype" => self.free_form_count += 1,
            _ => {}
        }
    }

    fn push<'a>(&mut self, keyword: &str, words: impl Iterator<Item = &'a str>) {
        self.text += keyword;
        for word in words {
            self.text.push(' ');
            self.text += word;
        }
        self.text.push('\n');
    }

    /// The text after a keyword, line by line, with the line's number in the file.
    fn of<'a>(
        &'a self,
        keyword: &'a str,
        numbers: &'a [usize],
    ) -> impl Iterator<Item = (usize, &'a str)> {
        let rest = move |line: &'a str| {
            let (first, rest) = line.split_once(' ').unwrap_or((line, ""));
            (first == keyword).then_some(rest)
        };
        numbers
            .iter()
            .copied()
            .zip(self.text.lines().filter_map(rest))
    }

    /// Vertices (number and coordinates) that are not finite.
    fn non_finite_vertices(&self) -> impl Iterator<Item = (usize, [f32; 3])> {
        let vertices = self.of("v", &self.vertices).enumerate();
        vertices.filter_map(|(vertex, (_, rest))| {
            // Such numbers have letters (`nan`, `inf`, an exponent) or more digits than the largest float32.
            if rest.len() < 39 && !rest.bytes().any(|byte| byte.is_ascii_alphabetic()) {
                return None;
            }
            let position = coordinates(rest)?.map(|value| value as f32);
            (!position.iter().all(|c| c.is_finite())).then_some((vertex, position))
        })
    }

    fn no_triangles(&self) -> MeshProblem {
        let mut parts = Vec::new();
        for (count, one, many) in [
            (self.vertices.len(), "vertex", "vertices"),
            (self.line_count, "line", "lines"),
            (self.point_count, "point", "points"),
            (
                self.free_form_count,
                "line of curves or free-form surfaces",
                "lines of curves or free-form surfaces",
            ),
        ] {
            if count > 0 {
                parts.push(format!("{count} {}", if count == 1 { one } else { many }));
            }
        }
        MeshProblem::NoTriangles {
            found: match parts.is_empty() {
                true => "the file holds neither vertices nor faces".to_owned(),
                false => format!("the file holds only {}", parts.join(", ")),
            },
        }
    }

    /// Finds the problem of a file that `tobj` refused, or that has a vertex that is not finite.
    fn explain(&self, otherwise: &str) -> MeshProblem {
        self.find_problem()
            .unwrap_or_else(|| MeshProblem::Damaged(otherwise.to_owned()))
    }

    fn find_problem(&self) -> Option<MeshProblem> {
        for (line, rest) in self.of("v", &self.vertices) {
            if coordinates(rest).is_none() {
                let why = "a vertex needs three numbers";
                return Some(text::bad_number(line, why, &format!("v {rest}")));
            }
        }
        let non_finite: std::collections::HashMap<_, _> = self.non_finite_vertices().collect();
        // Negative indices count back from the lines above the face.
        for (face, (line, rest)) in self.of("f", &self.faces).enumerate() {
            let above = |numbers: &[usize]| numbers.partition_point(|&number| number < line);
            let mut corners = 0;
            for corner in rest.split_ascii_whitespace() {
                corners += 1;
                let Some(indices) = indices(corner) else {
                    let why = "a face is made of VERTEX/TEXTURE/NORMAL numbers";
                    return Some(bad_face(line, why, rest));
                };
                for (what, index, numbers) in [
                    ("vertex", indices[0], &self.vertices),
                    ("texture coordinate", indices[1], &self.texcoords),
                ] {
                    let Some(index) = index else { continue };
                    let from_zero = match index {
                        0.. => index - 1,
                        _ => above(numbers) as i64 + index,
                    };
                    // Texture coordinates that the file lacks altogether are ignored, and 0 means that there is none.
                    let ignored = what != "vertex" && (numbers.is_empty() || index == 0);
                    if !ignored && !(0..numbers.len() as i64).contains(&from_zero) {
                        return Some(MeshProblem::IndexOutOfRange {
                            face: face as u64,
                            line: Some(line),
                            what,
                            index,
                            first: 1,
                            count: numbers.len() as u64,
                        });
                    }
                    if let Some(&position) = non_finite.get(&(from_zero as usize))
                        && what == "vertex"
                    {
                        return Some(MeshProblem::NonFiniteVertex {
                            vertex: from_zero as u64,
                            line: Some(self.vertices[from_zero as usize]),
                            position,
                            face: face as u64,
                        });
                    }
                }
            }
            if corners == 0 {
                return Some(bad_face(line, "a face needs three corners", rest));
            }
        }
        None
    }
}

fn coordinates(rest: &str) -> Option<[f64; 3]> {
    let mut words = rest.split_ascii_whitespace();
    let mut values = [0.0; 3];
    for value in &mut values {
        *value = words.next()?.parse().ok()?;
    }
    Some(values)
}

/// The numbers of one corner, `VERTEX`, `VERTEX/TEXTURE`, `VERTEX//NORMAL` or `VERTEX/TEXTURE/NORMAL`.
fn indices(corner: &str) -> Option<[Option<i64>; 3]> {
    let mut values = [None; 3];
    let mut fields = corner.split('/');
    for value in &mut values {
        match fields.next() {
            None => break,
            Some("") => {}
            Some(field) => *value = Some(field.parse().ok()?),
        }
    }
    (fields.next().is_none() && values[0].is_some()).then_some(values)
}

fn bad_face(line: usize, why: &str, rest: &str) -> MeshProblem {
    text::bad_line(line, why, &format!("f {rest}"))
}
