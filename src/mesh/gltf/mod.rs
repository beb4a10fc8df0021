//! glTF and GLB files: their triangles, and the transforms of the scene.
//!
//! Models are untrusted, so of the `gltf` crate only types and constants are used: its own import panics on damaged files and reads any
//! path that a model names. Only the parts of a file that the shape needs are read ([`json`]). Every index is looked up with a check, every
//! size is computed with checked arithmetic in [`accessor`], and only files beside the model are opened in [`resource`]. There the work is
//! counted, too: a small file can name the same data any number of times.
//!
//! The shape is the one that Khronos' viewer shows with its animations at rest: morph targets with their default
//! weights, skins in the pose of the file's nodes, and instances at their places.

mod accessor;
mod animation;
mod glb;
mod json;
mod reader;
mod resource;
mod scene;
mod skin;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::MeshReport;
use super::error::MeshProblem;
use super::load::Extent;
use super::soup::Soup;
pub use animation::RigidTrack;
pub(crate) use glb::is_glb;
use json::Part;
use reader::Reader;
use resource::Buffers;

/// Extensions, or beginnings of their names, that do not change where triangles are at rest.
///
/// `CESIUM_RTC` only moves the model as a whole, to a place so far away that float32 loses digits there. Without it the model stays at its
/// own origin, where precision is better.
const HARMLESS: &[&str] = &[
    "ADOBE_materials_",
    "CESIUM_RTC",
    "CESIUM_primitive_outline",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_texture_",
    "KHR_animation_pointer",
    "KHR_audio",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_lights_",
    "KHR_materials_",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_technique_webgl",
    "KHR_techniques_webgl",
    "KHR_texture_",
    "KHR_xmp",
    "MSFT_lod",
    "MSFT_texture_",
    "NV_materials_",
];

/// Extensions that change where triangles are, and that are read.
const APPLIED: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
];

/// Reads a `.glb`, or a `.gltf` whose buffers are data URIs or files in the given folder. More triangles than `most` are an
/// error; they are counted and not kept, because a small file can show the same ones any number of times.
pub(crate) fn read(
    bytes: &[u8],
    folder: &Path,
    extent: Extent,
    most: u64,
) -> Result<Soup, MeshProblem> {
    let (json, blob) = glb::split(bytes)?;
    let json = json::parse(json)?;
    check_version(&Part::root(&json))?;
    let mut reader = Reader::new(Buffers::new(&json, blob, folder), most);
    match extent {
        Extent::Scene => reader.add_scene()?,
        Extent::FirstPrimitive => reader.add_first_primitive()?,
    }
    reader.finish()
}

/// Reads the first animation of a file that moves a node, as [`read`] reads its triangles.
pub(crate) fn read_track(bytes: &[u8], folder: &Path) -> Result<RigidTrack, MeshProblem> {
    let (json, blob) = glb::split(bytes)?;
    let json = json::parse(json)?;
    check_version(&Part::root(&json))?;
    animation::track(&mut Buffers::new(&json, blob, folder))
}

fn damaged(problem: String) -> MeshProblem {
    MeshProblem::Damaged(problem)
}

/// The beginning of untrusted text, for a message.
fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

fn check_version(root: &Part<'_>) -> Result<(), MeshProblem> {
    if let Some(version) = root.at(&["asset", "version"]) {
        let text = match version.as_text() {
            Ok(text) => text.to_owned(),
            Err(_) => version.as_number()?.to_string(),
        };
        if text != "2" && !text.starts_with("2.") {
            return Err(MeshProblem::Unsupported(format!(
                "this is glTF {}, and only glTF 2 can be read: export the model again",
                shortened(&text, 20)
            )));
        }
    }
    for name in root.items("extensionsRequired")? {
        let name = name.as_text()?;
        if is_harmless(name) || APPLIED.contains(&name) {
            continue;
        }
        let hint = if is_compression(name) {
            "export the model without compression"
        } else {
            "export the model without it"
        };
        return Err(MeshProblem::Unsupported(format!(
            "the model requires the extension {}, which is not supported: {hint}",
            shortened(name, 60)
        )));
    }
    Ok(())
}

fn is_harmless(extension: &str) -> bool {
    HARMLESS
        .iter()
        .any(|harmless| extension.starts_with(harmless))
}

/// Does an extension only compress data that is also there uncompressed, if the file does not require the extension?
fn is_compression(extension: &str) -> bool {
    extension.contains("draco") || extension.contains("meshopt")
}

/// Notes the extensions of a node, mesh or primitive that may change its shape or place, and are not read.
fn note_unapplied(part: &Part<'_>, seen: &mut MeshReport) {
    let Some(extensions) = part.get("extensions") else {
        return;
    };
    for name in extensions.keys() {
        if !is_harmless(name) && !is_compression(name) && !APPLIED.contains(&name) {
            seen.unapplied_extensions.insert(shortened(name, 60));
        }
    }
}
