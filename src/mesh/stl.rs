//! STL files, binary and text: triangles with three vertices of their own.

use glam::{DVec3, Vec3};

use super::error::MeshProblem;
use super::origin::{bounds, steps_across};
use super::soup::Soup;
use super::text::{self, bad_line, bad_number};

/// Letters without a meaning, and the number of triangles after them.
const HEADER: usize = 84;
/// Bytes of a triangle: its normal, three vertices, and two bytes of attributes.
const TRIANGLE: usize = 50;

/// Reads all solids in the file as one surface. Normals are left out: vertices give them.
pub(crate) fn read(bytes: &[u8]) -> Result<Soup, MeshProblem> {
    // Some programs begin binary files with `solid`, so the size comes first.
    if binary_size(bytes) != Some(bytes.len() as u64) && is_text(bytes) {
        read_text(&text::decode(bytes))
    } else {
        read_binary(bytes)
    }
}

/// How many triangles the header of a binary file counts.
fn binary_count(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

fn binary_size(bytes: &[u8]) -> Option<u64> {
    Some(HEADER as u64 + TRIANGLE as u64 * u64::from(binary_count(bytes)?))
}

/// How many triangles a file has that is a binary one beyond doubt, because it is as long as its header says.
pub(crate) fn declared_triangles(bytes: &[u8]) -> Option<u64> {
    (binary_size(bytes) == Some(bytes.len() as u64))
        .then(|| binary_count(bytes).unwrap_or(0).into())
}

/// Whether a file that is not as long as its binary header says is text: it begins with `solid`, soon there is a facet
/// or the end, and it has no NUL bytes where a binary file has its header and its count.
fn is_text(bytes: &[u8]) -> bool {
    if bytes.iter().take(HEADER).any(|&byte| byte == 0) && !text::is_utf16(bytes) {
        return false;
    }
    let beginning = text::decode(&bytes[..bytes.len().min(10_000)]).to_ascii_lowercase();
    beginning.trim_start().starts_with("solid")
        && (beginning.contains("facet") || beginning.contains("endsolid"))
}

fn read_binary(bytes: &[u8]) -> Result<Soup, MeshProblem> {
    let (Some(count), Some(size)) = (binary_count(bytes), binary_size(bytes)) else {
        return Err(MeshProblem::Damaged(format!(
            "this is no STL file: it has {} bytes, no `solid` with facets at its beginning, and no room for the binary \
             header of {HEADER}",
            bytes.len()
        )));
    };
    let rest = &bytes[HEADER..];
    if size > bytes.len() as u64 {
        return Err(MeshProblem::Damaged(format!(
            "the STL header counts {count} triangles, which is {size} bytes, and the file has {} bytes, room for {}",
            bytes.len(),
            rest.len() / TRIANGLE
        )));
    }
    // Programs that write while they compute may leave the count at 0.
    let count = match count {
        0 if rest.len().is_multiple_of(TRIANGLE) => rest.len() / TRIANGLE,
        count => count as usize,
    };
    let mut soup = Soup::default();
    soup.seen.trailing_bytes = rest.len() - count * TRIANGLE;
    let records = rest.as_chunks::<TRIANGLE>().0.iter().take(count);
    for (facet, record) in records.enumerate() {
        // After the normal, and before the attributes.
        let floats = record[12..48].as_chunks::<4>().0;
        for corner in floats.as_chunks::<3>().0 {
            let position = Vec3::from_array(corner.map(f32::from_le_bytes));
            add_vertex(&mut soup, position.as_dvec3(), facet, None)?;
        }
        add_triangle(&mut soup);
    }
    let (low, high) = bounds(&soup.positions);
    soup.seen.stored_steps = steps_across(low, high);
    if soup.triangles.is_empty() {
        return Err(no_facets());
    }
    Ok(soup)
}

/// Only vertices and the ends of their loops count; other words are names, normals, colours or decoration.
fn read_text(file: &str) -> Result<Soup, MeshProblem> {
    let mut soup = Soup::default();
    // The facet's vertices so far; a few programs write polygons.
    let mut corners: Vec<u32> = Vec::new();
    let mut facet = 0;
    let mut in_solid = false;
    let mut in_facet = false;
    for (index, line) in text::lines(file).enumerate() {
        let number = index + 1;
        let mut words = line.split_ascii_whitespace();
        while let Some(word) = words.next() {
            match word.to_ascii_lowercase().as_str() {
                // What stands behind is a name.
                "solid" => {
                    in_solid = true;
                    break;
                }
                "endsolid" => {
                    in_solid = false;
                    break;
                }
                "vertex" => {
                    let mut coordinate = || words.next()?.parse().ok();
                    let position = (|| Some([coordinate()?, coordinate()?, coordinate()?]))();
                    let position = position
                        .ok_or_else(|| bad_number(number, "a vertex needs three numbers", line))?;
                    let position = DVec3::from_array(position);
                    corners.push(soup.positions.len() as u32);
                    add_vertex(&mut soup, position, facet, Some(number))?;
                }
                "endloop" | "endfacet" if corners.len() >= 3 => {
                    soup.add_polygon(&corners, None);
                    corners.clear();
                    facet += 1;
                    in_facet = word.eq_ignore_ascii_case("endloop");
                }
                "endloop" => {
                    return Err(bad_line(number, "a facet needs three vertices", line));
                }
                "facet" | "outer" if !corners.is_empty() => {
                    return Err(bad_line(number, "the facet before has no `endloop`", line));
                }
                "facet" => in_facet = true,
                "endfacet" => in_facet = false,
                _ => {}
            }
        }
    }
    if !corners.is_empty() || (in_solid && in_facet) {
        return Err(MeshProblem::Damaged(format!(
            "the STL text ends within a facet, after {facet} whole ones"
        )));
    }
    soup.seen.without_endsolid = in_solid;
    if soup.triangles.is_empty() {
        return Err(no_facets());
    }
    Ok(soup)
}

fn add_vertex(
    soup: &mut Soup,
    position: DVec3,
    facet: usize,
    line: Option<usize>,
) -> Result<(), MeshProblem> {
    let single = position.as_vec3();
    if !single.is_finite() {
        return Err(MeshProblem::NonFiniteVertex {
            vertex: soup.positions.len() as u64,
            line,
            position: single.to_array(),
            face: facet as u64,
        });
    }
    soup.positions.push(position);
    Ok(())
}

/// Adds a triangle of the last three vertices.
fn add_triangle(soup: &mut Soup) {
    let end = soup.positions.len() as u32;
    soup.triangles.push([end - 3, end - 2, end - 1]);
}

fn no_facets() -> MeshProblem {
    MeshProblem::NoTriangles {
        found: "the STL file holds no facets".to_owned(),
    }
}
