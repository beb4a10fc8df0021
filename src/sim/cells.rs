//! Cells: the owned texels, of which every texel of the surface has one. Particles may be one a cell, and sensors may read whole cells.

use super::claims::RANK_BITS;
use super::field::{atlas_position, texel_at};
use super::types::Particle;
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Seam;
use crate::scene::parameters::grouped;
use crate::scene::settings::{MOST_POPULATION, Settings, Strategy};

/// Per texel its cell: an owned texel is its own, a gutter texel has the owned texel across the seam that it takes most of, the first of
/// equal ones. Other texels, where no particle can be, are their own.
#[must_use]
pub fn homes(atlas: &Atlas) -> Vec<u32> {
    let mut homes: Vec<u32> = (0..atlas.density.len() as u32).collect();
    for seam in &atlas.seams {
        homes[seam.texel as usize] = heaviest(seam);
    }
    homes
}

fn heaviest(seam: &Seam) -> u32 {
    let units = seam.units();
    let mut best = 0;
    for k in 1..4 {
        if units[k] > units[best] {
            best = k;
        }
    }
    seam.source[best]
}

/// The cell that a particle is in.
#[must_use]
pub fn cell_of(particle: &Particle, atlas: &Atlas, homes: &[u32]) -> u32 {
    let map = &atlas.maps[particle.triangle as usize];
    let position = atlas_position(map, particle.u, particle.v);
    homes[texel_at(position, atlas.pitch) as usize]
}

/// How many particles are in a cell with one that comes before them: 0 if there is one a cell.
#[must_use]
pub fn sharing_count(particles: &[Particle], atlas: &Atlas, homes: &[u32]) -> usize {
    let mut taken = vec![false; homes.len()];
    let cells = (particles.iter()).map(|particle| cell_of(particle, atlas, homes));
    let sharing = cells.filter(|&cell| std::mem::replace(&mut taken[cell as usize], true));
    sharing.count()
}

/// Checks that the particles of a scene with one particle a cell have cells, and ranks of their own, and those of a population that grows
/// and shrinks room.
///
/// # Errors
/// When there are more particles than cells, or than ranks, or than a population may have; says how many there may be.
pub fn check_room(settings: &Settings, atlas: &Atlas) -> Result<()> {
    let (count, cells) = (settings.particles.count, atlas.owned_count);
    if settings.population.is_on() && count > MOST_POPULATION {
        return Err(Error::Invalid(format!(
            "particles.count = {}: where their number changes (population.frequency) there may be {}, at the most",
            grouped(count.into()),
            grouped(MOST_POPULATION.into()),
        )));
    }
    if !settings.physarum.rules().is_crowded() {
        return Ok(());
    }
    let most = 1 << RANK_BITS;
    if count > most {
        return Err(Error::Invalid(format!(
            "particles.count = {}: with one particle a cell there may be {}, at the most",
            grouped(count.into()),
            grouped(most.into()),
        )));
    }
    if count > cells {
        return Err(Error::Invalid(format!(
            "particles.count = {}: there is one particle a cell, and the texture has {} cells: use fewer particles, raise atlas.size from {}, or \
             let them share cells (physarum.model = \"thesis\" and physarum.occupancy_rounds = 0)",
            grouped(count.into()),
            grouped(cells.into()),
            grouped(settings.atlas.size.into()),
        )));
    }
    Ok(())
}

/// Checks that the rules of a scene go together.
///
/// # Errors
/// When particles restart, at places where others may be, and there is one particle a cell; or when particles change objects, and
/// their number changes.
pub fn check_rules(settings: &Settings) -> Result<()> {
    if settings.population.is_on() && settings.strategy() != Strategy::None {
        return Err(Error::Invalid(format!(
            "population.frequency = {}: particles divide and die only where they stay on their objects: use a single object, transfer.strategy = \
             \"none\", or population.frequency = 0",
            settings.population.frequency
        )));
    }
    if settings.physarum.rules().is_crowded() && settings.strategy() == Strategy::Respawn {
        return Err(Error::Invalid(
            "transfer.strategy = \"respawn\": there is one particle a cell, and particles that restart could share one, wherever they do: \
             choose another strategy, or let particles share cells (physarum.model = \"thesis\" and physarum.occupancy_rounds = 0)"
                .to_owned(),
        ));
    }
    Ok(())
}
