//! What can be wrong with a model, said so that its owner can mend it.

use std::path::PathBuf;

/// Why there is no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file could not be read.
    #[error("cannot read {path}: {source}", path = path.display())]
    Read {
        /// The model, or the file that it names.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file was read, and is not a mesh to walk on.
    #[error("{place}: {problem}")]
    Bad {
        /// The file, or the name of the built-in mesh.
        place: String,
        /// What is wrong with it.
        problem: MeshProblem,
    },
    /// No built-in mesh has this name.
    #[error(
        "there is no built-in mesh `{name}`{}: the names are {known}",
        suggestion(nearest)
    )]
    UnknownBuiltin {
        /// What was asked for.
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
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// What is wrong with a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshProblem {
    /// Nothing to walk on.
    #[error("there are no triangles: {found}. Export the model with its faces")]
    NoTriangles {
        /// What the file holds instead.
        found: String,
    },
    /// Coordinates that float32 arithmetic cannot multiply.
    #[error(
        "the model is {extent:e} across, and lengths between 1e-12 and 1e12 can be walked: scale the model"
    )]
    Extent {
        /// The largest side of the bounding box, or the largest coordinate where that is far out.
        extent: f64,
    },
}

fn suggestion(nearest: &Option<String>) -> String {
    match nearest {
        Some(name) => format!(", did you mean `{name}`?"),
        None => String::new(),
    }
}
