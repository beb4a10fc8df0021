//! The numbers of elements in a scene's buffers: exact, from its setup, or approximate, from its settings and meshes alone.

use super::buffers::Counts;
use super::distance::{GROUP, MOST_HINTS, TILE_SAMPLES};
use super::restarts::Restarts;
use super::setup::Setup;
use super::sorting::Segments;
use super::transfers::{capacity, most_displaced};
use crate::mesh::surface::NONE;
use crate::scene::Scene;
use crate::scene::settings::Settings;

impl Counts {
    /// The exact counts of a scene, from its setup.
    #[must_use]
    pub fn of(setup: &Setup, settings: &Settings) -> Self {
        let (atlas, distance, food_set) = (&setup.atlas, &setup.distance, &setup.food_set);
        let count = |len: usize| len as u64;
        let objects = count(setup.poses.len());
        let triangles = count(setup.surface.corners.len());
        Self {
            particles: count(setup.particles.len()),
            objects,
            texels: count(atlas.texel_count()),
            blocks: count(atlas.blocks.len()),
            seams: count(atlas.seams.len()),
            rows: count(atlas.exchange.rows.len()),
            entries: count(atlas.exchange.packed_entries()),
            triangles,
            vertices: count(setup.vertices.len()),
            segment: segment(settings, count(setup.particles.len()), objects),
            bins: setup.bins.count.into(),
            windows: if settings.strategy().has_windows() {
                objects
            } else {
                1
            },
            transfers: capacity(settings, setup).into(),
            respawn: if settings.strategy().respawns() {
                (triangles, objects)
            } else {
                (1, 1)
            },
            restarts: Restarts::lengths(setup, settings),
            painted: count(setup.bias.len()),
            looks: count(setup.looks.len()),
            homes: count(setup.homes.len()),
            trail_objects: if settings.has_own_rates() {
                count(atlas.texel_count())
            } else {
                0
            },
            crowd: if settings.physarum.rules().is_crowded() {
                (count(setup.particles.len()), count(atlas.texel_count()))
            } else {
                (0, 0)
            },
            population: match setup.population {
                Some(_) => (count(setup.particles.len()), count(atlas.texel_count())),
                None => (0, 0),
            },
            foods: count(food_set.places.len()),
            scents: (
                count(food_set.scented.len()),
                count(food_set.falloffs.len()),
            ),
            projected: count(food_set.projected.len()),
            crosses: settings.scent_crosses(),
            samples: count(distance.samples.len()),
            tiles: count(distance.tiles.len()),
            job_tiles: count(distance.tiles_len()),
            hints: distance.hint_count().into(),
            nodes: count(distance.trees.nodes.len()),
            is_drawn: settings.uses_raster(),
            outlines: if settings.uses_raster() {
                owning_triangles(&atlas.owner)
            } else {
                0
            },
        }
    }

    /// The approximate counts of a scene that has no atlas yet. Those of seams, of the lists of transfers and of the texels within reach of
    /// food are unknown; with several objects, every texel counts as owned.
    #[must_use]
    pub fn about(scene: &Scene) -> Self {
        let settings = &scene.settings;
        let objects = scene.surface.objects.len() as u64;
        let triangles = scene.surface.corners.len() as u64;
        let texels = texel_count(settings.atlas.size.into());
        let samples = if objects > 1 { texels } else { 0 };
        let nodes = if objects > 1 { triangles } else { 0 };
        let rules = settings.physarum.rules();
        let tiles = samples / u64::from(TILE_SAMPLES);
        Self {
            particles: settings.slots().into(),
            segment: segment(settings, settings.slots().into(), objects),
            objects,
            texels,
            triangles,
            vertices: scene.surface.positions.len() as u64,
            windows: 1,
            transfers: 1,
            respawn: (1, 1),
            restarts: (2, 1),
            painted: if settings.areas.map.is_empty() {
                0
            } else {
                texels
            },
            looks: if settings.second_look.map.is_empty() {
                0
            } else {
                texels
            },
            homes: if rules.has_cells() || settings.population.is_on() {
                texels
            } else {
                0
            },
            trail_objects: if settings.has_own_rates() { texels } else { 0 },
            crowd: if rules.is_crowded() {
                (settings.slots().into(), texels)
            } else {
                (0, 0)
            },
            population: if settings.population.is_on() {
                (settings.slots().into(), texels)
            } else {
                (0, 0)
            },
            foods: settings.food_count() as u64,
            crosses: settings.scent_crosses(),
            samples,
            tiles,
            job_tiles: tiles + objects * u64::from(GROUP / TILE_SAMPLES) * u64::from(objects > 1),
            hints: objects.saturating_sub(1).min(MOST_HINTS.into()),
            nodes,
            ..Self::default()
        }
    }
}

/// Room for particles that are reordered: for the longest segment, as on a graphics card, and with windows for all that a step can
/// displace, which is all if particles are born.
fn segment(settings: &Settings, particles: u64, objects: u64) -> u64 {
    let strategy = settings.strategy();
    let sorted = if strategy.may_sort() {
        Segments::room(particles as u32).into()
    } else {
        1
    };
    let displaced = if strategy.has_windows() && settings.population.is_on() {
        particles
    } else if strategy.has_windows() {
        most_displaced(settings.transfer.buffer_size, objects as u32, particles)
    } else {
        1
    };
    sorted.max(displaced)
}

/// Texels of a texture of so many along its side: rows are padded to whole quads.
pub(super) fn texel_count(size: u64) -> u64 {
    size.next_multiple_of(4) * size
}

/// Triangles that own a texel.
fn owning_triangles(owner: &[u32]) -> u64 {
    let mut owners = owner.to_vec();
    owners.sort_unstable();
    owners.dedup();
    owners.len() as u64 - u64::from(owners.last() == Some(&NONE))
}
