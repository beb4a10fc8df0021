//! Data for pictures that the host computes without a device: smooth normals, ambient occlusion of corners, colours of charts, shared
//! vertices. Large meshes take a while, so this is a separate step that can run in parallel with others.

use bytemuck::allocation::pod_collect_to_vec;
use glam::{Vec3, Vec4};

use super::hues::object_light;
use super::normals::{CREASE_ANGLE, corner_normals, pack_normal};
use super::occlusion::{self, MOST_PLACES, openness};
use super::shared_vertices::{Corners, SharedVertex, share};
use super::{backs, charts};
use crate::mesh::atlas::{AtlasError, Control};
use crate::scene::parameters::grouped;
use crate::sim::Setup;

/// Name of the last part of this work in progress reports.
const COLOURING: &str = "colouring charts";

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
        Self::with_control(setup, &Control::default()).expect("nothing stops it")
    }

    /// As [`new`](Self::new). `control` gets the progress, can cancel the work, and names the folder in which the occlusion is kept.
    ///
    /// # Errors
    /// [`AtlasError::Cancelled`] when it was stopped.
    pub fn with_control(setup: &Setup, control: &Control<'_>) -> Result<Self, AtlasError> {
        Self::with_most_places(setup, MOST_PLACES, control)
    }

    /// As [`with_control`](Self::with_control), with another limit on the places for which the openness is computed.
    fn with_most_places(
        setup: &Setup,
        most_places: usize,
        control: &Control<'_>,
    ) -> Result<Self, AtlasError> {
        let (surface, atlas) = (&setup.surface, &setup.atlas);
        control.step(occlusion::DOING, 0.0)?;
        let normals = corner_normals(surface, CREASE_ANGLE);
        let open = control.part(0.1..0.4, |control| {
            openness(surface, &normals, most_places, control)
        })?;
        let backs = control.part(0.4..0.85, |control| backs::seen_backs(surface, control))?;
        control.step(COLOURING, 0.85)?;
        let (mut openness, unlooked) = match open {
            Ok(found) => (found, None),
            Err(places) => (vec![u8::MAX; normals.len()], Some(places)),
        };
        let normals: Vec<u32> = normals.into_iter().map(pack_normal).collect();
        openness.resize(openness.len().next_multiple_of(4), u8::MAX);
        let objects = 0..setup.poses.len();
        let chart_colors = charts::chart_colors(surface, atlas);
        let prepared = Self {
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
            boxes: (!backs.contains(&true)).then(|| objects.map(|i| surface.bounds(i)).collect()),
        };
        control.step(COLOURING, 1.0)?;
        Ok(prepared)
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
        Self::new(setup).quick(setup)
    }

    /// As [`for_quick`](Self::for_quick), from what [`new`](Self::new) or [`with_control`](Self::with_control) has found for the
    /// setup.
    #[must_use]
    pub fn quick(self, setup: &Setup) -> Self {
        let shared = share(&Corners {
            vertex_of: &setup.corners,
            vertices: &setup.vertices,
            maps: &setup.atlas.maps,
            normals: &self.normals,
            openness: bytemuck::cast_slice(&self.openness),
        });
        Self {
            shared: Some(shared),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicBool, Ordering};

    use crate::gpu::{Context, ContextOptions};
    use crate::scene::{Overrides, Scene};
    use crate::sim::Simulation;
    use crate::sim::food::MEASURING;
    use std::path::Path;

    /// Catches a bar that is full, or goes back, while there is still work.
    #[test]
    fn progress_goes_forward_to_its_end_and_each_report_can_be_the_last() {
        let set = [
            "particles.count=500",
            "atlas.size=64",
            "food=[{radius=0.9}, {radius=0.8}]",
        ];
        for set in [&set[..2], &set] {
            let overrides = Overrides {
                set: set.iter().map(|set| (*set).to_owned()).collect(),
                ..Overrides::default()
            };
            let scene = Scene::load(Path::new("cube"), &overrides).unwrap();
            let reports = Mutex::new(Vec::new());
            let progress =
                |doing: &'static str, done: f32| reports.lock().unwrap().push((doing, done));
            let control = Control {
                progress: Some(&progress),
                ..Control::default()
            };
            let setup = control.part(0.0..0.5, |control| Setup::with_control(&scene, control));
            let setup = setup.unwrap();
            let prepared =
                control.part(0.5..1.0, |control| Prepared::with_control(&setup, control));
            assert_eq!(prepared.unwrap().normals, Prepared::new(&setup).normals);
            let all = reports.into_inner().unwrap();
            assert!(all.is_sorted_by_key(|(_, done)| *done), "{all:?}");
            assert_eq!(all.last(), Some(&(COLOURING, 1.0)));
            assert_eq!(
                all.iter().any(|(doing, _)| *doing == MEASURING),
                set.len() > 2
            );

            let of_light = all.iter().filter(|(doing, _)| *doing == occlusion::DOING);
            assert!(of_light.count() >= 3, "{all:?}");
            let mut last_ones = all
                .iter()
                .map(|(_, done)| 2.0 * done - 1.0)
                .filter(|done| *done >= 0.0);
            let stopped = last_ones.all(|last| {
                let cancelled = AtomicBool::new(false);
                let progress = |_: &'static str, done: f32| {
                    cancelled.fetch_or(done >= last - 1e-6, Ordering::Relaxed);
                };
                let control = Control {
                    progress: Some(&progress),
                    cancelled: Some(&cancelled),
                    cache: None,
                };
                Prepared::with_control(&setup, &control).err() == Some(AtlasError::Cancelled)
            });
            assert!(stopped);
        }
    }

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
        let control = Control::default();
        let found = openness(&setup.surface, &normals, 0, &control).unwrap();
        let places = found.unwrap_err();
        let most = |places| Prepared::with_most_places(&setup, places, &control).unwrap();
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
