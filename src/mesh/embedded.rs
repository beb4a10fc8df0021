//! Models embedded in the program, so that every built-in scene runs from any folder. `assets/README.md` has their sources and licences.

use std::path::Path;

use super::load::{Extent, from_bytes};
use super::{Mesh, MeshError};

/// The name and the GLB file of each.
const MODELS: &[(&str, &[u8])] = &[
    ("suzanne", include_bytes!("../../assets/suzanne.glb")),
    ("trefoil", include_bytes!("../../assets/beaded_trefoil.glb")),
    ("gyroid", include_bytes!("../../assets/gyroid_ball.glb")),
];

/// The model with this name, if there is one.
pub(super) fn model(name: &str, most: u64) -> Option<Result<Mesh, MeshError>> {
    let (name, bytes) = MODELS.iter().find(|(model, _)| *model == name)?;
    // The path is only used for its ending and for messages; nothing is read from it.
    let path = format!("builtin:{name}.glb");
    Some(from_bytes(
        name,
        Path::new(&path),
        bytes,
        Extent::Scene,
        most,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes in `assets/README.md`.
    #[test]
    fn models_are_what_their_readme_says() {
        let expected = [
            ("suzanne", 14_842, 160, 3),
            ("trefoil", 20_210, 0, 1),
            ("gyroid", 39_546, 0, 1),
        ];
        assert_eq!(MODELS.len(), expected.len());
        for (name, triangles, border_edges, parts) in expected {
            let mesh = Mesh::builtin(name).expect("it is built in");
            let report = &mesh.report;
            assert_eq!(mesh.name, name);
            assert_eq!(
                (report.triangles, report.border_edges, report.parts),
                (triangles, border_edges, parts),
                "{name}: {report}"
            );
        }
    }

    #[test]
    fn models_have_no_parameters() {
        let message = Mesh::builtin("suzanne?divisions=2")
            .expect_err("it has none")
            .to_string();
        assert!(message.contains("divisions"), "{message}");
    }
}
