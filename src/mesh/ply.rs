//! PLY files, binary and text: a header that describes elements (vertices, faces) and their properties, then the values.
//!
//! Counts in the file are not trusted: nothing is allocated for them, and every iteration over them reads a value, so that a count that is
//! too large ends at the end of the file.

mod values;

use std::collections::HashSet;

use glam::{DVec3, Vec2};

use super::error::MeshProblem;
use super::origin::{bounds, steps_across};
use super::soup::{MOST_TRIANGLES, Soup};
use super::text::{self, bad_line, beginning};
use crate::plain_text::counted;
use values::Values;

/// Does a file begin like a PLY file?
pub(crate) fn is_ply(bytes: &[u8]) -> bool {
    // Four characters of UTF-16 and a byte order mark.
    let beginning = text::decode(&bytes[..bytes.len().min(10)]);
    beginning.starts_with("ply\n") || beginning.starts_with("ply\r")
}

/// Reads the vertices with the faces and triangle strips between them; everything else is skipped.
pub(crate) fn read(bytes: &[u8]) -> Result<Soup, MeshProblem> {
    let is_utf16 = text::is_utf16(bytes);
    let decoded;
    let bytes = if is_utf16 {
        decoded = text::decode(bytes);
        decoded.as_bytes()
    } else {
        text::without_mark(bytes)
    };
    let header = Header::read(bytes)?;
    if is_utf16 && header.encoding != Encoding::Text {
        return Err(MeshProblem::Damaged(
            "the PLY header is UTF-16 text and announces binary values".to_owned(),
        ));
    }
    let mut values = Values::new(&header, bytes);
    let soup = header.read_values(&mut values);
    // If the values fit and end with the file, there is no second attempt.
    if soup.is_ok() && values.is_at_end() {
        return soup;
    }
    match Values::of_rows(&header, bytes) {
        Some(mut rows) => header.read_values(&mut rows).or(soup),
        None => soup,
    }
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// The highest value of an unsigned type.
    fn highest(self) -> Option<f64> {
        match self {
            Self::U8 => Some(u8::MAX.into()),
            Self::U16 => Some(u16::MAX.into()),
            Self::U32 => Some(u32::MAX.into()),
            Self::U64 => Some(u64::MAX as f64),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

#[derive(Debug, PartialEq)]
struct Property {
    name: String,
    /// The type of the length, if this is a list.
    length: Option<Kind>,
    kind: Kind,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// The place of a property, by the first of several names that it may have.
    fn find(&self, names: &[&str], is_list: bool) -> Option<usize> {
        names.iter().find_map(|name| {
            self.properties
                .iter()
                .position(|property| property.name == *name && property.length.is_some() == is_list)
        })
    }

    /// Bytes of one in a binary file, if all are of one size.
    fn size(&self) -> Option<usize> {
        let sizes = self.properties.iter().map(|property| {
            let is_list = property.length.is_some();
            (!is_list).then(|| property.kind.size())
        });
        sizes.sum()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// Words that begin lines of a header, other than remarks.
const KEYWORDS: &[&str] = &["format", "element", "property", "end_header"];

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Lines and bytes that it takes.
    lines: usize,
    bytes: usize,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, MeshProblem> {
        if !(bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")) {
            let found = beginning(&String::from_utf8_lossy(&bytes[..bytes.len().min(20)]));
            return Err(MeshProblem::Damaged(format!(
                "this is no PLY file: its first line should be `ply`, and it begins with `{found}`"
            )));
        }
        // CR alone, or LF with or without a CR before it. Binary values may begin with either.
        let line_end = match bytes[3] == b'\r' && bytes.get(4) != Some(&b'\n') {
            true => b'\r',
            false => b'\n',
        };
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut names = HashSet::new();
        let mut at = 0;
        let mut number = 0;
        loop {
            number += 1;
            let rest = &bytes[at..];
            let Some(length) = rest.iter().position(|&byte| byte == line_end) else {
                return Err(MeshProblem::Damaged(format!(
                    "the PLY header ends in line {number} without `end_header`"
                )));
            };
            at += length + 1;
            let line = String::from_utf8_lossy(&rest[..length]);
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let bad = |why: &str| bad_line(number, why, line.trim());
            match words[..] {
                [] | ["ply" | "comment" | "obj_info", ..] => {}
                // Blender 2.47 left out the word `comment`.
                [word, ..] if elements.is_empty() && !KEYWORDS.contains(&word) => {}
                ["end_header", ..] => {
                    return Ok(Self {
                        encoding: encoding.ok_or_else(|| bad("there is no `format` line above"))?,
                        elements,
                        lines: number,
                        bytes: at,
                    });
                }
                ["format", name, ..] => {
                    encoding = Some(match name {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return Err(bad("the format is ascii or binary_..._endian")),
                    });
                }
                ["element", name, count] => {
                    if !names.insert(name.to_owned()) {
                        return Err(bad("this element is there already"));
                    }
                    elements.push(Element {
                        name: name.to_owned(),
                        count: count
                            .parse()
                            .map_err(|_| bad("an element needs a name and a count"))?,
                        properties: Vec::new(),
                    });
                }
                ["property", ref of @ ..] => {
                    let property = property(of)
                        .ok_or_else(|| bad("a property needs types (char to double) and a name"))?;
                    let element = elements
                        .last_mut()
                        .ok_or_else(|| bad("there is no `element` line above"))?;
                    element.properties.push(property);
                }
                _ => return Err(bad("it is not a line of a PLY header")),
            }
        }
    }

    fn read_values(&self, values: &mut Values<'_>) -> Result<Soup, MeshProblem> {
        let mut model = Model {
            vertex_count: self.count("vertex"),
            face_count: self.count("face"),
            ..Model::default()
        };
        for element in &self.elements {
            match element.name.as_str() {
                "vertex" => model.read_vertices(element, values)?,
                "face" => model.read_faces(element, values)?,
                "tristrips" => model.read_strips(element, values)?,
                name => {
                    values.skip_all(element)?;
                    // Without properties no values stand behind the count.
                    if name == "edge" && !element.properties.is_empty() {
                        model.edges = usize::try_from(element.count).unwrap_or(usize::MAX);
                    }
                }
            }
        }
        let mut soup = model.into_soup()?;
        soup.seen.longer_rows = values.longer_rows;
        Ok(soup)
    }

    /// How many elements of a name it counts.
    fn count(&self, name: &str) -> u64 {
        let element = self.elements.iter().find(|element| element.name == name);
        element.map_or(0, |element| element.count)
    }
}

/// The text after the word `property`.
fn property(words: &[&str]) -> Option<Property> {
    let (length, kind, name) = match *words {
        ["list", length, kind, name] => (Some(Kind::named(length)?), kind, name),
        [kind, name] => (None, kind, name),
        _ => return None,
    };
    Some(Property {
        name: name.to_owned(),
        length,
        kind: Kind::named(kind)?,
    })
}

/// Names of the list of vertices in a face.
const CORNERS: &[&str] = &["vertex_indices", "vertex_index"];

/// The values so far. Faces may come before their vertices, so the counts are those of the header.
#[derive(Default)]
struct Model {
    vertex_count: u64,
    face_count: u64,
    positions: Vec<DVec3>,
    vertex_uvs: Option<Vec<Vec2>>,
    /// The corners of all faces, and how many each has.
    corners: Vec<u32>,
    sizes: Vec<u32>,
    /// Texture coordinates of all corners, while every face has them.
    corner_uvs: Option<Vec<Vec2>>,
    /// Triangles of strips.
    strips: Vec<[u32; 3]>,
    edges: usize,
    incomplete_uvs: bool,
    stored_steps: Option<usize>,
}

impl Model {
    fn read_vertices(
        &mut self,
        element: &Element,
        values: &mut Values<'_>,
    ) -> Result<(), MeshProblem> {
        let mut places = [0; 3];
        for (place, name) in places.iter_mut().zip(["x", "y", "z"]) {
            *place = element.find(&[name], false).ok_or_else(|| {
                MeshProblem::Damaged(format!("the vertices of the PLY file have no `{name}`"))
            })?;
        }
        let [x, y, z] = places;
        let pairs = [
            ["s", "t"],
            ["u", "v"],
            ["texture_u", "texture_v"],
            ["texture_s", "texture_t"],
        ];
        let uv_places = pairs.iter().find_map(|[u, v]| {
            let u = element.find(&[u], false)?;
            Some((u, element.find(&[v], false)?))
        });
        let mut uvs = uv_places.map(|_| Vec::new());
        let mut numbers = Vec::new();
        for index in 0..element.count {
            values.read(element, index, &mut numbers, &mut [])?;
            let position = DVec3::new(numbers[x], numbers[y], numbers[z]);
            self.positions.push(position);
            if let (Some(uvs), Some((u, v))) = (&mut uvs, uv_places) {
                uvs.push(Vec2::new(numbers[u] as f32, numbers[v] as f32));
            }
        }
        self.vertex_uvs = uvs;
        if element.properties[x].kind == Kind::F32 && values.encoding != Encoding::Text {
            let (low, high) = bounds(&self.positions);
            self.stored_steps = steps_across(low, high);
        }
        Ok(())
    }

    fn read_faces(
        &mut self,
        element: &Element,
        values: &mut Values<'_>,
    ) -> Result<(), MeshProblem> {
        let Some(corners_at) = element.find(CORNERS, true) else {
            return match element.count {
                0 => Ok(()),
                _ => Err(no_list(element)),
            };
        };
        let uvs_at = element.find(&["texcoord"], true);
        let mut corner_uvs = uvs_at.map(|_| Vec::new());
        let (mut numbers, mut corners, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..element.count {
            let lists = &mut [(Some(corners_at), &mut corners), (uvs_at, &mut uvs)];
            values.read(element, index, &mut numbers, lists)?;
            for &corner in &corners {
                self.corners.push(vertex(corner, index, self.vertex_count)?);
            }
            self.sizes.push(corners.len() as u32);
            if uvs_at.is_some() && uvs.len() != 2 * corners.len() {
                self.incomplete_uvs = true;
                corner_uvs = None;
            }
            if let Some(all) = &mut corner_uvs {
                let uv = |&[u, v]: &[f64; 2]| Vec2::new(u as f32, v as f32);
                all.extend(uvs.as_chunks().0.iter().map(uv));
            }
        }
        self.corner_uvs = corner_uvs;
        Ok(())
    }

    fn read_strips(
        &mut self,
        element: &Element,
        values: &mut Values<'_>,
    ) -> Result<(), MeshProblem> {
        let Some(list_at) = element.find(CORNERS, true) else {
            return match element.count {
                0 => Ok(()),
                _ => Err(no_list(element)),
            };
        };
        // A strip ends at -1, which unsigned types write as their highest value if it is no vertex.
        let highest = element.properties[list_at].kind.highest();
        let highest = highest.filter(|&highest| highest >= self.vertex_count as f64);
        let is_end = |&index: &f64| index == -1.0 || Some(index) == highest;
        let (mut numbers, mut list, mut strip) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..element.count {
            let lists = &mut [(Some(list_at), &mut list)];
            values.read(element, index, &mut numbers, lists)?;
            for indices in list.split(is_end) {
                strip.clear();
                for (k, &index) in indices.iter().enumerate() {
                    let face = self.strips.len() + k.saturating_sub(2);
                    let face = self.face_count.saturating_add(face as u64);
                    strip.push(vertex(index, face, self.vertex_count)?);
                }
                add_strip(&mut self.strips, &strip, MOST_TRIANGLES)?;
            }
        }
        Ok(())
    }

    fn into_soup(self) -> Result<Soup, MeshProblem> {
        let vertex_uvs = self.vertex_uvs.as_ref();
        // A face's own coordinates take precedence, because they have seams. Strips have none.
        let corner_uvs = self.corner_uvs.as_ref().filter(|_| self.strips.is_empty());
        let is_finite = |uvs: &Vec<Vec2>| uvs.iter().all(|uv| uv.is_finite());
        let has_uvs = corner_uvs.or(vertex_uvs).is_some_and(is_finite);
        let mut soup = Soup {
            uvs: has_uvs.then(Vec::new),
            positions: self.positions,
            ..Soup::default()
        };
        soup.seen.lines = self.edges;
        soup.seen.stored_steps = self.stored_steps;
        soup.seen.incomplete_uvs =
            !has_uvs && (self.incomplete_uvs || vertex_uvs.is_some() || self.corner_uvs.is_some());

        let mut first = 0;
        let strips = self.strips.iter().map(|strip| &strip[..]);
        let faces = self.sizes.iter().map(|&size| {
            let face = first..first + size as usize;
            first = face.end;
            &self.corners[face]
        });
        let mut corner = 0;
        let mut uvs = Vec::new();
        for (face, vertices) in faces.chain(strips).enumerate() {
            uvs.clear();
            for (k, &vertex) in vertices.iter().enumerate() {
                check_finite(&soup.positions, face, vertex)?;
                if has_uvs {
                    uvs.extend(match (corner_uvs, vertex_uvs) {
                        (Some(all), _) => all.get(corner + k),
                        (_, all) => all.and_then(|all| all.get(vertex as usize)),
                    });
                }
            }
            corner += vertices.len();
            match vertices.len() {
                0 | 1 => soup.seen.points += 1,
                2 => soup.seen.lines = soup.seen.lines.saturating_add(1),
                _ => soup.add_polygon(vertices, has_uvs.then_some(&uvs[..])),
            }
        }
        if soup.triangles.is_empty() {
            return Err(no_triangles(&soup));
        }
        Ok(soup)
    }
}

/// Adds the triangles of a strip, every second one wound the other way round.
pub(super) fn add_strip(
    triangles: &mut Vec<[u32; 3]>,
    strip: &[u32],
    most: usize,
) -> Result<(), MeshProblem> {
    let count = triangles.len() + strip.len().saturating_sub(2);
    if count > most {
        return Err(MeshProblem::TooMany {
            what: "or more triangles in strips",
            count: count as u64,
            most: most as u64,
        });
    }
    triangles.extend(strip.windows(3).enumerate().map(|(k, corners)| {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        if k % 2 == 0 { [a, b, c] } else { [b, a, c] }
    }));
    Ok(())
}

/// The vertex that a face names, if there are so many.
fn vertex(index: f64, face: u64, count: u64) -> Result<u32, MeshProblem> {
    if index.is_nan() || index.fract() != 0.0 {
        return Err(MeshProblem::Damaged(format!(
            "face {face} names vertex {index}, which is no whole number"
        )));
    }
    if !(0.0..count as f64).contains(&index) {
        return Err(MeshProblem::IndexOutOfRange {
            face,
            line: None,
            what: "vertex",
            index: index as i64,
            first: 0,
            count,
        });
    }
    // A count beyond u32 is false, which reading the vertices finds.
    Ok(index as u32)
}

fn check_finite(positions: &[DVec3], face: usize, vertex: u32) -> Result<(), MeshProblem> {
    let position = positions[vertex as usize].as_vec3();
    if position.is_finite() {
        return Ok(());
    }
    Err(MeshProblem::NonFiniteVertex {
        vertex: vertex.into(),
        line: None,
        position: position.to_array(),
        face: face as u64,
    })
}

fn no_list(element: &Element) -> MeshProblem {
    MeshProblem::Damaged(format!(
        "the elements `{}` of the PLY file have no list `vertex_indices`",
        beginning(&element.name)
    ))
}

fn no_triangles(soup: &Soup) -> MeshProblem {
    let mut found = match soup.positions.len() {
        0 => "the file holds neither vertices nor faces".to_owned(),
        count => format!(
            "the file is a cloud of {}",
            counted(count, "point", "points")
        ),
    };
    if soup.seen.lines > 0 {
        found += ", with ";
        found += &counted(soup.seen.lines, "line", "lines");
    }
    MeshProblem::NoTriangles { found }
}
