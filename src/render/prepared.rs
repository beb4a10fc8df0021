//! Data for pictures that the host computes without a device: smooth normals, ambient occlusion of corners, colours of charts, shared
//! vertices. Large meshes take a while, so this is a separate step that can run in parallel with others.

use bytemuck::allocation::pod_collect_to_vec;
use glam::{Vec3, Vec4};

use super::backs;
use super::charts;
use super::hues::object_light;
use super::normals::{CREASE_ANGLE, corner_normals, pack_normal};
use super::occlusion::{MOST_PLACES, openness};
use super::shared_vertices::{Corners, SharedVertex, share};
use crate::mesh::surface::Surface;
use crate::scene::parameters::grouped;
use crate::sim::Setup;

/// The data that a [`Renderer`](super::Renderer) uploads.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// For quick pictures: vertices for corners with equal attributes, and the vertex of each corner.
    pub(super) shared: Option<(Vec<SharedVertex>, Vec<u32>)>,
    /// Packed, one for each corner of each triangle.
    pub(super) normals: Vec<u32>,
    /// How much of the sky each corner sees, four to a word.
    pub(super) openness: Vec<u32>,
    /// If ambient occlusion was not computed: the number of its places.
    unlooked: Option<usize>,
    /// One per object.
    pub(super) object_colors: Vec<Vec4>,
    /// The kind of each texel, and the colour of its chart.
    pub(super) texels: Vec<u32>,
    /// The colour and the seams of each triangle.
    pub(super) charts: Vec<u32>,
    /// Bounding boxes of the objects, lowest and highest corners in object space, if no back face can be seen from outside.
    pub(super) boxes: Option<Vec<[Vec3; 2]>>,
}

impl Prepared {
    /// Computes the data for pictures of a setup.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        Self::with_most_places(setup, MOST_PLACES)
    }

    /// As [`new`](Self::new), with another limit on the places for which the openness is computed.
    fn with_most_places(setup: &Setup, most_places: usize) -> Self {
        let (surface, atlas) = (&setup.surface, &setup.atlas);
        let normals = corner_normals(surface, CREASE_ANGLE);
        let (mut openness, unlooked) = match openness(surface, &normals, most_places) {
            Ok(found) => (found, None),
            Err(places) => (vec![u8::MAX; normals.len()], Some(places)),
        };
        let normals: Vec<u32> = normals.into_iter().map(pack_normal).collect();
        openness.resize(openness.len().next_multiple_of(4), u8::MAX);
        let objects = 0..setup.poses.len();
        let chart_colors = charts::chart_colors(surface, atlas);
        Self {
            shared: None,
            normals,
            openness: pod_collect_to_vec::<u8, u32>(&openness),
            unlooked,
            object_colors: objects
                .clone()
                .map(|i| object_light(i).extend(1.0))
                .collect(),
            texels: charts::texel_words(surface, atlas, &chart_colors),
            charts: charts::triangle_words(surface, atlas, &chart_colors),
            boxes: objects.map(|i| box_of_solid(surface, i)).collect(),
        }
    }

    /// A warning about missing features of pictures, if any.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        self.unlooked.map(|places| {
            format!(
                "ambient occlusion is left out: there are {} corners to compute it for, more than {}",
                grouped(places as f64),
                grouped(MOST_PLACES as f64)
            )
        })
    }

    /// As [`new`](Self::new), for many quick pictures on a device that is a CPU: those take a fifth to a third less time,
    /// and 28 to 108 bytes per triangle more of the device's memory.
    #[must_use]
    pub fn for_quick(setup: &Setup) -> Self {
        let rest = Self::new(setup);
        let shared = share(&Corners {
            vertex_of: &setup.corners,
            vertices: &setup.vertices,
            maps: &setup.atlas.maps,
            normals: &rest.normals,
            openness: bytemuck::cast_slice(&rest.openness),
        });
        Self {
            shared: Some(shared),
            ..rest
        }
    }
}

/// The box around an object, unless back faces can be seen from outside.
fn box_of_solid(surface: &Surface, object: usize) -> Option<[Vec3; 2]> {
    let (first, end) = surface.objects[object].triangles;
    let corners = &surface.corners[first as usize..end as usize];
    let is_solid = surface.is_closed(object) && !backs::are_seen(&surface.positions, corners);
    is_solid.then(|| surface.bounds(object))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Context, ContextOptions};
    use crate::mesh::atlas::Control;
    use crate::scene::{Overrides, Scene};
    use crate::sim::Simulation;
    use std::path::Path;

    #[test]
    fn what_is_left_out_is_said() {
        let ctx = match Context::new(&ContextOptions::default()) {
            Ok(ctx) => ctx,
            Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
                return eprintln!("skipped: {error}");
            }
            Err(error) => panic!("{error}"),
        };
        let set = ["particles.count=500", "atlas.size=64"].map(str::to_owned);
        let overrides = Overrides {
            set: set.into(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new("cube"), &overrides).unwrap();
        let setup = Simulation::set_up(ctx.info(), &scene, &Control::default()).unwrap();
        assert_eq!(Prepared::for_quick(&setup).warning(), None);
        let normals = corner_normals(&setup.surface, CREASE_ANGLE);
        let places = openness(&setup.surface, &normals, 0).unwrap_err();
        let most = |places| Prepared::with_most_places(&setup, places);
        assert_eq!(most(places).warning(), None);
        let prepared = most(places - 1);
        assert!(prepared.openness.iter().all(|&four| four == u32::MAX));
        let warning = prepared.warning().unwrap();
        let there_are = format!("there are {} corners", grouped(places as f64));
        assert!(
            warning.contains(&there_are) && warning.contains("more than 200,000"),
            "{warning}"
        );
    }
}
