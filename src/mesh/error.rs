//! Errors in models, with messages from which the model's author can fix it.

use crate::plain_text::Shown as _;
use std::path::PathBuf;

/// Why there is no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file could not be read.
    #[error("cannot read {path}: {source}", path = path.shown())]
    Read {
        /// The model, or the file that it names.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file was read, and is not a mesh to walk on.
    #[error("{place}: {problem}")]
    Bad {
        /// The file, or the name of the built-in mesh.
        place: String,
        /// The problem.
        problem: MeshProblem,
    },
    /// No built-in mesh has this name.
    #[error(
        "there is no built-in mesh `{name}`{}: the names are {known}",
        suggestion(nearest)
    )]
    UnknownBuiltin {
        /// The requested name.
        name: String,
        /// The most similar name, if one is similar.
        nearest: Option<String>,
        /// All names.
        known: String,
    },
    /// A built-in mesh has no such parameter, or not with this value.
    #[error("builtin:{name}: {problem}")]
    Parameter {
        /// The built-in mesh.
        name: String,
        /// The problem, and the allowed values.
        problem: String,
    },
}

/// A problem of a model. Vertices and triangles are numbered from 0, lines of text from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshProblem {
    /// The file's format is not supported.
    #[error(
        "this is no OBJ, STL, PLY, glTF or GLB file: {found}. Export the model as one of these"
    )]
    UnknownKind {
        /// The ending of its name.
        found: String,
    },
    /// A path that is not a file of a sensible size.
    #[error("{0}")]
    NotAFile(String),
    /// A triangle in memory names a vertex that is not there.
    #[error("a triangle has the vertex {vertex}, and there are {count}, counted from 0")]
    MissingVertex {
        /// The vertex.
        vertex: u32,
        /// The number of vertices.
        count: usize,
    },
    /// A pair of edges that cannot be glued.
    #[error("glued pair {pair}: {problem}")]
    Glue {
        /// Its place in the list, counted from 0.
        pair: usize,
        /// The problem.
        problem: String,
    },
    /// A model's animation that an object cannot follow.
    #[error("{0}")]
    Animation(String),
    /// There are no triangles.
    #[error("there are no triangles: {found}. Export the model with its faces")]
    NoTriangles {
        /// The file's content instead.
        found: String,
    },
    /// No triangle has an area.
    #[error("of {count} triangles none has an area: the model is broken or scaled to nothing")]
    AllDegenerate {
        /// How many there were.
        count: usize,
    },
    /// A vertex that a triangle uses is NaN or infinite.
    #[error(
        "vertex {vertex}{} is not finite: {position:?}, used by face {face}. Repair the model or export it again",
        at_line(line)
    )]
    NonFiniteVertex {
        /// Its number in the file.
        vertex: u64,
        /// Its line, in a text file.
        line: Option<usize>,
        /// Its coordinates in float32.
        position: [f32; 3],
        /// The first face that uses it.
        face: u64,
    },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face}{} names {what} {index}, and the file has {}. The file is damaged: export the model again",
        at_line(line),
        range(*first, *count)
    )]
    IndexOutOfRange {
        /// Number of the face (of the triangle, in glTF).
        face: u64,
        /// Its line, in a text file.
        line: Option<usize>,
        /// `vertex` or `texture coordinate`.
        what: &'static str,
        /// As the file writes it: from 1 in OBJ, negative ones counting back; from 0 in PLY and glTF.
        index: i64,
        /// The lowest index that would be right, as the file would write it.
        first: u64,
        /// How many there are.
        count: u64,
    },
    /// More than half-edge numbers can count.
    #[error(
        "{count} {what}, and {most} are the most that can be numbered: split or simplify the model"
    )]
    TooMany {
        /// The name of the counted elements, such as `triangles`.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// How many there may be.
        most: u64,
    },
    /// More triangles than the scene's atlas has room for.
    #[error(
        "{count} triangles, and the atlas has room for {most} more: raise atlas.size, or simplify the model"
    )]
    NoRoom {
        /// How many there are.
        count: u64,
        /// How many there may be.
        most: u64,
    },
    /// Coordinates that float32 arithmetic cannot multiply.
    #[error(
        "coordinates reach {farthest:e}, and 1e12 is the most: move the model nearer to the origin, or scale it down"
    )]
    TooFar {
        /// The largest coordinate, without its sign.
        farthest: f64,
    },
    /// A model so small that float32 arithmetic loses it.
    #[error("the model is {extent:e} across, and float32 walks need 1e-12 at least: scale it up")]
    TooSmall {
        /// The largest side of its bounding box.
        extent: f64,
    },
    /// A line of text that cannot be read.
    #[error("line {line} cannot be read, {why}: `{text}`")]
    BadLine {
        /// Number of the line.
        line: usize,
        /// The problem.
        why: String,
        /// Its beginning.
        text: String,
    },
    /// An invalid binary or JSON structure.
    #[error("{0}. The file is damaged or cut off: export or download it again")]
    Damaged(String),
    /// Something that glTF allows and that is not supported.
    #[error("{0}")]
    Unsupported(String),
    /// A file that the model refers to, and that is not read.
    #[error("the model refers to `{uri}`, {why}")]
    Reference {
        /// As the model writes it, or its beginning.
        uri: String,
        /// Why it is not read, and what to do.
        why: String,
    },
    /// The reader itself failed.
    #[error(
        "this file made the reader fail ({0}). Please report it, with the file; exporting the model again may help"
    )]
    Panicked(String),
}

fn at_line(line: &Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(" (line {line})"))
}

fn range(first: u64, count: u64) -> String {
    match count {
        0 => "none".to_owned(),
        count => format!("{first} to {}", first + count - 1),
    }
}

fn suggestion(nearest: &Option<String>) -> String {
    match nearest {
        Some(name) => format!(", did you mean `{name}`?"),
        None => String::new(),
    }
}
