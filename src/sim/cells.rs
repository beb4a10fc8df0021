//! Cells: the owned texels, of which every texel of the surface has one. Particles may be one a cell, and sensors may read whole cells.

use rayon::prelude::*;

use super::field::{atlas_position, texel_at, weights_at};
use super::types::Particle;
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::{AtlasMap, NONE};
use crate::scene::parameters::grouped;
use crate::scene::settings::{MOST_POPULATION, Settings, Strategy};
use crate::strict::{settled, within};

/// Per texel its cell: an owned texel is its own, a gutter texel has the owned texel across the seam that it takes most of, the first of
/// equal ones. Other texels, where no particle can be, are their own.
#[must_use]
pub fn homes(atlas: &Atlas) -> Vec<u32> {
    let mut homes: Vec<u32> = (0..atlas.density.len() as u32).collect();
    for seam in &atlas.seams {
        homes[seam.texel as usize] = seam.main_source();
    }
    homes
}

/// Where a particle is born in a cell, on a triangle with this map: under the cell's middle, or at another place if that does not lie on
/// the triangle. As in `shaders/divide_begin.comp`.
#[must_use]
pub fn birthplace(map: &AtlasMap, cell: u32, pitch: u32) -> [f32; 2] {
    let middle = [cell % pitch, cell / pitch].map(|x| x as f32 + 0.5);
    let [u, v] = weights_at(map, middle);
    let u = settled(within(u, 0.0, 1.0));
    [u, settled(within(v, 0.0, 1.0 - u))]
}

/// Per texel the triangle on which particles are born in it, its owner. [`NONE`] where there is no cell, or where the place of a birth
/// would lie in another one: a chart that is thinner than a texel may have a cell whose middle is not on it.
#[must_use]
pub fn nests(atlas: &Atlas, homes: &[u32]) -> Vec<u32> {
    let nest = |(cell, &triangle): (usize, &u32)| {
        if triangle == NONE {
            return NONE;
        }
        let map = &atlas.maps[triangle as usize];
        let [u, v] = birthplace(map, cell as u32, atlas.pitch);
        let texel = texel_at(atlas_position(map, u, v), atlas.pitch);
        match homes[texel as usize] as usize == cell {
            true => triangle,
            false => NONE,
        }
    };
    atlas.owner.par_iter().enumerate().map(nest).collect()
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
pub fn sharing_count<'a>(
    particles: impl IntoIterator<Item = &'a Particle>,
    atlas: &Atlas,
    homes: &[u32],
) -> usize {
    let mut taken = vec![false; homes.len()];
    let cells = (particles.into_iter()).map(|particle| cell_of(particle, atlas, homes));
    let sharing = cells.filter(|&cell| std::mem::replace(&mut taken[cell as usize], true));
    sharing.count()
}

/// Checks that the particles of a scene with one particle a cell have cells, and those of a population that grows and shrinks room.
///
/// # Errors
/// When there are more particles than cells, or than a population may have; says how many there may be.
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

/// Checks that the rules of a scene, and the bounds of its population, go together.
///
/// # Errors
/// When particles restart, at places where others may be, and there is one particle a cell.
pub fn check_rules(settings: &Settings) -> Result<()> {
    if settings.physarum.rules().is_crowded() && settings.strategy() == Strategy::Respawn {
        return Err(Error::Invalid(
            "transfer.strategy = \"respawn\": there is one particle a cell, and particles that restart could share one, wherever they do: \
             choose another strategy, or let particles share cells (physarum.model = \"thesis\" and physarum.occupancy_rounds = 0)"
                .to_owned(),
        ));
    }
    check_bounds(settings)
}

/// Checks that particles can divide and survive by the bounds of a population.
fn check_bounds(settings: &Settings) -> Result<()> {
    let population = &settings.population;
    if !population.is_on() {
        return Ok(());
    }
    for (what, least, most, window, so) in [
        (
            "division",
            population.division_least,
            population.division_most,
            population.division_window,
            "no particle would divide",
        ),
        (
            "survival",
            population.survival_least,
            population.survival_most,
            population.survival_window,
            "every particle would die",
        ),
    ] {
        let side = 2 * u64::from(window / 2) + 1;
        let cells = side * side;
        let more_than = if least > most {
            format!("population.{what}_most = {most}")
        } else if settings.physarum.rules().is_crowded() && u64::from(least) > cells {
            format!("the {cells} cells, one particle each, of population.{what}_window = {window}")
        } else {
            continue;
        };
        return Err(Error::Invalid(format!(
            "population.{what}_least = {least}: it is more than {more_than}, so {so}: lower the one or raise the other"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::scene::settings::Model;

    /// Would catch: bounds that no particle can meet, accepted in silence, and bounds that some can meet, refused.
    #[test]
    fn bounds_that_none_can_meet_are_refused() {
        let said = |change: fn(&mut Settings)| {
            let mut settings = Settings::default();
            settings.physarum.model = Model::Jones;
            settings.population.frequency = 5;
            change(&mut settings);
            check_rules(&settings).err().map(|error| error.to_string())
        };
        type Change = fn(&mut Settings);
        let refused: [(Change, &str); 3] = [
            (
                |s| s.population.survival_least = 25,
                "population.survival_least = 25: it is more than population.survival_most = 24, so every",
            ),
            (
                |s| s.population.division_most = 0,
                "population.division_least = 1: it is more than population.division_most = 0, so no",
            ),
            (
                |s| {
                    s.population.survival_window = 4;
                    (s.population.survival_least, s.population.survival_most) = (26, 81);
                },
                "population.survival_least = 26: it is more than the 25 cells, one particle each, of population.survival_window = 4",
            ),
        ];
        for (change, keys) in refused {
            let message = said(change).expect(keys);
            assert!(message.contains(keys), "{message}");
        }
        let accepted: [fn(&mut Settings); 5] = [
            |_| (),
            |s| s.population.survival_least = 24,
            |s| (s.population.survival_least, s.population.survival_most) = (25, 25),
            // Several particles a cell.
            |s| {
                s.physarum.model = Model::Thesis;
                (s.population.survival_least, s.population.survival_most) = (26, 81);
            },
            // The number of particles is constant.
            |s| (s.population.frequency, s.population.survival_least) = (0, 25),
        ];
        for change in accepted {
            assert_eq!(said(change), None);
        }
    }

    /// A needle takes the place of a triangle, with its tip at the middle of one of its cells. Would catch: births in the others, which would
    /// come to that cell.
    #[test]
    fn no_particle_is_born_beside_its_cell() {
        let (_, mut atlas) = Atlas::of_cells("cube", 64);
        let homes = homes(&atlas);
        let owner = &atlas.owner;
        let is_own = |cell: usize| owner[cell] == 0;
        let mut cells = 3..owner.len();
        let tip = cells.find(|&cell| is_own(cell) && is_own(cell - 3));
        let tip = tip.expect("a triangle has more than three texels in a row");
        let middle = atlas.centre_of(tip as u32);
        atlas.maps[0] = AtlasMap {
            origin: middle - Vec2::new(0.0, 0.3),
            du: Vec2::new(0.0, 0.1),
            dv: Vec2::new(-4.0, 0.0),
        };
        let nests = nests(&atlas, &homes);
        assert_eq!((nests[tip], nests[tip - 3]), (0, NONE));
        let others = (atlas.owner.iter().zip(&nests)).filter(|(owner, _)| **owner != 0);
        assert!(others.clone().count() > 1000);
        for (owner, nest) in others {
            assert_eq!(owner, nest);
        }
    }
}
