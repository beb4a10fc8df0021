//! Binary glTF 2.0: one node per object, at its pose, with the trail on it, and the camera of the scene's pictures.
//!
//! The material is a lit one, because pictures are lit, and without light shapes are hard to see. Its base colour is that of the surface
//! under white light, and the trail glows as much as in pictures. Materials without light (`KHR_materials_unlit`) would look equal from
//! every side and in every viewer, but flat.
//!
//! The trail itself is the vertex attribute `_TRAIL`, for programs with their own colouring. Colours of vertices
//! (`COLOR_0`) multiply a texture, so a file has the one or the other.

use std::io::{self, Cursor, Write};

use glam::{Mat3, Quat, Vec3};
use serde_json::{Value, json};

use super::corners::{self, Shared, Split};
use super::paint::Paint;
use super::{Colors, Export};
use crate::mesh::surface::ObjectRange;
use crate::render::Camera;

const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33_071;

/// Light that the trail sends out itself, as in pictures.
const GLOW: f32 = 0.34;
/// The roughness of a microfacet surface whose highlight is as wide as that of pictures, Blinn and Phong's with exponent 60 (alpha^2 = 2 /
/// (exponent + 2), and alpha is the square of the roughness).
const ROUGHNESS: f32 = 0.42;

/// Writes everything.
///
/// # Errors
/// When the disk is full, or the model is larger than 4 GiB.
pub(super) fn write(export: &Export<'_>, colors: Colors, out: &mut impl Write) -> io::Result<()> {
    let paint = export.paint();
    let mut model = Model::default();
    let normals = corners::normals(&export.setup.surface);
    let objects = &export.setup.surface.objects;
    let meshes: Vec<Value> = objects
        .iter()
        .zip(&export.scene.settings.objects)
        .map(|(range, object)| {
            let primitive = model.primitive(export, range, &normals, &paint, colors);
            json!({ "name": object.name, "primitives": [primitive] })
        })
        .collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("myxo ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "meshes": meshes,
        "materials": [material(colors)],
        "cameras": [camera(&export.view.camera)],
    });
    let mut nodes = nodes(export);
    nodes.push(camera_node(export));
    document["scenes"] = json!([{
        "name": export.scene.name,
        "nodes": (0..nodes.len()).collect::<Vec<_>>(),
        "extras": {
            "step": export.snapshot.step,
            "seed": export.scene.settings.seed,
            "trail_of_brightest_color": paint.brightest,
        },
    }]);
    document["nodes"] = nodes.into();
    if colors == Colors::Texture {
        let (atlas, state) = (&export.setup.atlas, &*export.snapshot);
        let color = paint.texture(atlas, &state.trail, &state.looks);
        let color = model.image("trail", &color)?;
        let glow = paint.glow_texture(atlas, &state.trail, &state.looks);
        let glow = model.image("glow", &glow)?;
        document["images"] = json!([color, glow]);
        document["samplers"] = json!([{
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR,
            "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE,
        }]);
        document["textures"] =
            json!([{ "source": 0, "sampler": 0 }, { "source": 1, "sampler": 0 }]);
    }
    document["accessors"] = model.accessors.into();
    document["bufferViews"] = model.views.into();
    document["buffers"] = json!([{ "byteLength": model.binary.len() }]);
    write_chunks(&document, &model.binary, out)
}

/// One node for each object, with its rotation as a quaternion.
fn nodes(export: &Export<'_>) -> Vec<Value> {
    let objects = export.scene.settings.objects.iter();
    objects
        .zip(&export.world_from_object)
        .enumerate()
        .map(|(mesh, (object, pose))| {
            let turn = Quat::from_mat3a(&pose.matrix3).normalize();
            json!({
                "name": object.name,
                "mesh": mesh,
                "translation": export.in_world(pose.translation.into()).to_array(),
                "rotation": turn.to_array(),
            })
        })
        .collect()
}

/// Without a far plane, as in pictures. glTF cannot shift a picture, so that the camera has an angle that is wide enough for all that a
/// shifted picture shows.
fn camera(camera: &Camera) -> Value {
    let wider = 1.0 + camera.shift.abs().max_element();
    let half = ((0.5 * camera.vertical_fov).tan() * wider).atan();
    json!({
        "name": "picture",
        "type": "perspective",
        "perspective": { "yfov": 2.0 * half, "znear": 0.01 * camera.scene_radius },
    })
}

fn camera_node(export: &Export<'_>) -> Value {
    let camera = &export.view.camera;
    let axes = Mat3::from_cols(camera.right(), camera.up(), camera.backward());
    json!({
        "name": "picture",
        "camera": 0,
        "translation": export.in_world(camera.eye()).to_array(),
        "rotation": Quat::from_mat3(&axes).normalize().to_array(),
    })
}

fn material(colors: Colors) -> Value {
    let mut material = json!({
        "name": "slime",
        "doubleSided": true,
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": ROUGHNESS },
    });
    if colors == Colors::Texture {
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
        material["emissiveTexture"] = json!({ "index": 1 });
        material["emissiveFactor"] = json!([GLOW, GLOW, GLOW]);
    }
    material
}

/// The binary part, and the views and accessors into it.
#[derive(Default)]
struct Model {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Model {
    /// The triangles of one object.
    fn primitive(
        &mut self,
        export: &Export<'_>,
        range: &ObjectRange,
        normals: &[Vec3],
        paint: &Paint,
        colors: Colors,
    ) -> Value {
        let (surface, atlas) = (&export.setup.surface, &export.setup.atlas);
        let triangles = range.triangles.0..range.triangles.1;
        let Shared { corners, indices } =
            corners::share(surface, atlas, normals, triangles, Split::CreasesAndSeams);
        let of_vertices = |value: &dyn Fn(u32) -> [f32; 3]| -> Vec<[f32; 3]> {
            corners.iter().map(|&corner| value(corner)).collect()
        };
        let positions = of_vertices(&|corner| corners::position(surface, corner).to_array());
        let directions = of_vertices(&|corner| normals[corner as usize].to_array());
        let values = corners
            .iter()
            .map(|&corner| export.trail_and_second_look(corners::atlas_position(atlas, corner)));
        let (trail, second_look): (Vec<f32>, Vec<f32>) = values.unzip();

        let position = self.attribute(&positions, FLOAT, "VEC3");
        let (low, high) = bounds(&positions);
        self.accessors[position]["min"] = json!(low);
        self.accessors[position]["max"] = json!(high);
        let mut attributes = json!({
            "POSITION": position,
            "NORMAL": self.attribute(&directions, FLOAT, "VEC3"),
            "_TRAIL": self.attribute(&trail, FLOAT, "SCALAR"),
        });
        match colors {
            Colors::Texture => {
                let side = atlas.size as f32;
                let places: Vec<[f32; 2]> = corners
                    .iter()
                    .map(|&corner| corners::atlas_position(atlas, corner).map(|x| x / side))
                    .collect();
                attributes["TEXCOORD_0"] = self.attribute(&places, FLOAT, "VEC2").into();
            }
            Colors::Vertex => {
                // Linear light, unlike a texture's bytes; four channels, because vertices are aligned to four bytes.
                let channel = |light: f32| (65_535.0 * light.clamp(0.0, 1.0)).round() as u16;
                let both = trail.iter().zip(&second_look);
                let colors = both.map(|(&trail, &second_look)| {
                    let color = paint.color(trail, second_look).extend(1.0);
                    color.to_array().map(channel)
                });
                let colors: Vec<[u16; 4]> = colors.collect();
                let color = self.attribute(&colors, UNSIGNED_SHORT, "VEC4");
                self.accessors[color]["normalized"] = true.into();
                attributes["COLOR_0"] = color.into();
            }
        }
        let view = self.view(bytemuck::cast_slice(&indices), Some(ELEMENT_ARRAY_BUFFER));
        let indices = self.accessor(view, indices.len(), UNSIGNED_INT, "SCALAR");
        json!({ "attributes": attributes, "indices": indices, "material": 0 })
    }

    /// One value a vertex.
    fn attribute<T: bytemuck::Pod>(&mut self, values: &[T], component: u32, kind: &str) -> usize {
        let view = self.view(bytemuck::cast_slice(values), Some(ARRAY_BUFFER));
        self.accessor(view, values.len(), component, kind)
    }

    fn accessor(&mut self, view: usize, count: usize, component: u32, kind: &str) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        }));
        self.accessors.len() - 1
    }

    /// Appends a picture as PNG, and returns its description.
    fn image(&mut self, name: &str, picture: &image::RgbImage) -> io::Result<Value> {
        let mut png = Cursor::new(Vec::new());
        picture
            .write_to(&mut png, image::ImageFormat::Png)
            .map_err(io::Error::other)?;
        let view = self.view(png.get_ref(), None);
        Ok(json!({ "name": name, "bufferView": view, "mimeType": "image/png" }))
    }

    /// Appends bytes; they begin at a multiple of four.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len(),
        });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.binary.extend_from_slice(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let points = || positions.iter().map(|&position| Vec3::from_array(position));
    let low = points().fold(Vec3::INFINITY, Vec3::min);
    let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
    (low.to_array(), high.to_array())
}

/// The container: a header, the description padded with blanks, the binary part padded with zeros.
fn write_chunks(document: &Value, binary: &[u8], out: &mut impl Write) -> io::Result<()> {
    let mut text = serde_json::to_vec(document)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + text.len() + 8 + binary.len();
    let length = u32::try_from(length).map_err(|_| {
        io::Error::other(
            "the model is larger than 4 GiB, which a GLB cannot be: use a smaller texture (atlas.size) or mesh",
        )
    })?;
    out.write_all(b"glTF")?;
    for word in [2, length, text.len() as u32] {
        out.write_all(&word.to_le_bytes())?;
    }
    out.write_all(b"JSON")?;
    out.write_all(&text)?;
    out.write_all(&(binary.len() as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    out.write_all(binary)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::render::View;
    use crate::render::view::points;
    use crate::scene::Scene;
    use crate::scene::settings::Settings;

    /// Would catch: a camera without the shift of pictures, for which the scene lies partly beside the picture.
    #[test]
    fn the_camera_sees_all_that_pictures_show() {
        let mut settings = Settings::default();
        "builtin:torus?major=24&minor=12".clone_into(&mut settings.objects[0].mesh);
        let scene = Scene::from_settings("torus".to_owned(), settings, "".into()).unwrap();
        let size = Vec2::new(1280.0, 720.0);
        let of_pictures = View::of(&scene, size).camera;
        let are_all_seen = |camera: &Camera| {
            points(&scene).all(|point| {
                let pixel = camera.pixel(point, size).expect("it is before the eye");
                pixel.cmpge(Vec2::ZERO).all() && pixel.cmple(size).all()
            })
        };
        let mut unshifted = of_pictures;
        unshifted.shift = Vec2::ZERO;
        assert!(are_all_seen(&of_pictures) && !are_all_seen(&unshifted));
        let angle = camera(&of_pictures)["perspective"]["yfov"].as_f64();
        unshifted.vertical_fov = angle.unwrap() as f32;
        assert!(are_all_seen(&unshifted), "by {angle:?}");
    }
}
