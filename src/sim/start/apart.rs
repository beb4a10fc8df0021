//! One particle a cell at the start: those that begin in a cell with another one draw another place, and go to the nearest free cell if there
//! is hardly any.

use glam::{DVec2, Vec2};

use super::super::cells::cell_of;
use super::super::types::{Motion, Particle};
use crate::error::{Error, Result};
use crate::mesh::atlas::{Atlas, Control};
use crate::mesh::surface::Surface;
use crate::mesh::walk::Frame;
use crate::scene::parameters::grouped;
use crate::strict::{settled, within};

/// How many other places a particle draws. Where 95 % of the cells are taken, four of five find a free one.
const DRAWS: u32 = 32;

/// If so many particles in a row have found none, the places from which they draw are full, and no other one draws.
const IN_VAIN: usize = 256;

/// Moves particles until no two have one cell. In each cell the first one stays; the others draw other places on their object, by their id and
/// the number of the attempt, until one is in a free cell: so all free cells are as likely as the start rule makes them, and no crowds arise
/// round cells that were drawn twice. Those that find none go where a flood from their first cell through texels
/// side by side, and over seams, first finds room: on their object, unless it is full. Headings are laid onto the triangles there. A chart
/// thinner than a texel may have cells whose middles are not on it: no particle goes to one if it would come to lie in another cell.
///
/// # Errors
/// When it was stopped, or there are more particles than cells that can hold one.
pub fn apart(
    (particles, motions): (&mut [Particle], &mut [Motion]),
    surface: &Surface,
    atlas: &Atlas,
    homes: &[u32],
    draw_again: impl Fn(u32, u32, u32) -> Option<(Particle, Motion)>,
    control: &Control<'_>,
) -> Result<()> {
    let mut taken = vec![false; homes.len()];
    let mut crowded = Vec::new();
    for (slot, particle) in particles.iter().enumerate() {
        let cell = cell_of(particle, atlas, homes);
        if std::mem::replace(&mut taken[cell as usize], true) {
            crowded.push((cell, slot));
        }
    }
    let mut left = Vec::new();
    let mut in_vain = 0;
    for (done, (cell, slot)) in crowded.into_iter().enumerate() {
        if done.is_multiple_of(256) {
            control.check()?;
        }
        let Particle { id, triangle, .. } = particles[slot];
        let object = surface.triangles[triangle as usize].object;
        let attempts = if in_vain < IN_VAIN { DRAWS } else { 0 };
        let mut places = (1..=attempts).filter_map(|attempt| draw_again(id, object, attempt));
        let free = places.find(|(place, _)| {
            let cell = cell_of(place, atlas, homes) as usize;
            !std::mem::replace(&mut taken[cell], true)
        });
        match free {
            Some(free) => {
                (particles[slot], motions[slot]) = free;
                in_vain = 0;
            }
            None => {
                left.push((cell, slot));
                in_vain += 1;
            }
        }
    }
    let mut crowded = left;
    crowded.sort_unstable();
    let mut floods = Floods::new(atlas, homes);
    let (count, to_move) = (particles.len(), crowded.len());
    let mut rest = 0;
    for (done, (cell, slot)) in crowded.into_iter().enumerate() {
        if done.is_multiple_of(256) {
            control.check()?;
        }
        let place = loop {
            let free = floods.next_free(cell, &taken).or_else(|| {
                let is_free = |&cell: &usize| !taken[cell] && atlas.density[cell] > 0.0;
                rest = (rest..taken.len()).find(is_free).unwrap_or(taken.len());
                (rest < taken.len()).then_some(rest as u32)
            });
            let Some(free) = free else {
                return Err(too_many(count, count - to_move + done));
            };
            taken[free as usize] = true;
            let place = place_in(free, particles[slot].id, atlas);
            if cell_of(&place, atlas, homes) == free {
                break place;
            }
        };
        move_to((&mut particles[slot], &mut motions[slot]), place, surface);
    }
    Ok(())
}

fn too_many(count: usize, room: usize) -> Error {
    Error::Invalid(format!(
        "particles.count = {}: there is one particle a cell, and {} cells of the texture can hold one: use fewer particles, raise atlas.size, or \
         let them share cells (physarum.model = \"thesis\" and physarum.occupancy_rounds = 0)",
        grouped(count as f64),
        grouped(room as f64),
    ))
}

/// A particle on the centre of a cell, or where its triangle is nearest to that.
fn place_in(cell: u32, id: u32, atlas: &Atlas) -> Particle {
    let (triangle, u, v) = (atlas.surface_point_of(cell)).expect("cells have a triangle");
    Particle {
        triangle,
        u: settled(u),
        v: settled(within(v, 0.0, 1.0 - u)),
        id,
    }
}

/// Puts a particle on a place.
fn move_to((particle, motion): (&mut Particle, &mut Motion), place: Particle, surface: &Surface) {
    let triangle = place.triangle;
    let [from, to] = [particle.triangle, triangle].map(|triangle| Frame::of(surface, triangle));
    let [p, h] = [motion.heading_p, motion.heading_h].map(f64::from);
    let heading = p * from.p + h * from.h;
    let laid = DVec2::new(heading.dot(to.p), heading.dot(to.h));
    if triangle != particle.triangle && laid.length() > super::UPRIGHT {
        let Vec2 { x, y } = laid.normalize().as_vec2();
        (motion.heading_p, motion.heading_h) = (settled(x), settled(y));
    }
    *particle = place;
}

/// Floods from one cell after another.
struct Floods<'a> {
    atlas: &'a Atlas,
    homes: &'a [u32],
    /// Per texel: the last flood that got there, counted from 1.
    seen: Vec<u32>,
    count: u32,
    /// The cells that the present flood has got to, in order, the first of which it began from; and how many of them it has looked round.
    cells: Vec<u32>,
    done: usize,
    /// The place in `cells` of the next one that may be free.
    next: usize,
}

impl<'a> Floods<'a> {
    fn new(atlas: &'a Atlas, homes: &'a [u32]) -> Self {
        Self {
            atlas,
            homes,
            seen: vec![0; homes.len()],
            count: 0,
            cells: Vec::new(),
            done: 0,
            next: 0,
        }
    }

    /// The next free cell of the flood from a cell; none if it has found all that it can get to. A flood goes on where it was.
    fn next_free(&mut self, from: u32, taken: &[bool]) -> Option<u32> {
        if self.cells.first() != Some(&from) {
            self.count += 1;
            self.cells.clear();
            (self.done, self.next) = (0, 0);
            self.get_to(from);
        }
        loop {
            while let Some(&cell) = self.cells.get(self.next) {
                self.next += 1;
                if !taken[cell as usize] {
                    return Some(cell);
                }
            }
            let cell = *self.cells.get(self.done)?;
            self.done += 1;
            let pitch = self.atlas.pitch;
            // A chart's gutter lies between it and the texture's sides.
            for beside in [cell - pitch, cell - 1, cell + 1, cell + pitch] {
                let home = self.homes[beside as usize];
                if self.atlas.density[home as usize] > 0.0 {
                    self.get_to(home);
                }
            }
        }
    }

    fn get_to(&mut self, cell: u32) {
        if std::mem::replace(&mut self.seen[cell as usize], self.count) != self.count {
            self.cells.push(cell);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface::{AtlasMap, NONE};
    use crate::sim::cells::{homes, sharing_count};

    /// A needle takes the place of a triangle, so that most of its cells have their nearest places in others. Would catch: particles that are
    /// moved to such a cell, and then share another one, and a search without end, or a panic, where no cell is left.
    #[test]
    fn no_two_share_a_cell_of_a_needle() {
        let (surface, mut atlas) = Atlas::of_cells("cube", 64);
        let homes = homes(&atlas);
        let own = |cell: &usize| atlas.owner[*cell] == 0 && atlas.owner[*cell - 3] == 0;
        let tip = (3..homes.len()).find(own);
        let tip = tip.expect("a triangle has more than three texels in a row") as u32;
        atlas.maps[0] = AtlasMap {
            origin: atlas.centre_of(tip) - Vec2::new(0.0, 0.3),
            du: Vec2::new(0.0, 0.1),
            dv: Vec2::new(-4.0, 0.0),
        };
        let cells = (0..homes.len() as u32).filter(|&cell| atlas.owner[cell as usize] != NONE);
        let holds = |&cell: &u32| cell_of(&place_in(cell, 0, &atlas), &atlas, &homes) == cell;
        let room = cells.filter(holds).count() as u32;
        assert!(room + 20 < atlas.owned_count);

        let particle = |id| Particle {
            triangle: 0,
            u: 0.0,
            v: 0.0,
            id,
        };
        let heading = Motion {
            heading_p: 1.0,
            heading_h: 0.0,
            pending: 0.0,
            flags: 0,
        };
        let all = |count: u32| {
            let mut particles: Vec<Particle> = (0..count).map(particle).collect();
            let mut motions = vec![heading; count as usize];
            let both = (&mut particles[..], &mut motions[..]);
            let same = |id, _, _| Some((particle(id), heading));
            let moved = apart(both, &surface, &atlas, &homes, same, &Control::default());
            (moved, sharing_count(&particles, &atlas, &homes))
        };
        let (moved, sharing) = all(600);
        assert!(moved.is_ok() && sharing == 0, "{moved:?}, {sharing}");
        let (moved, sharing) = all(room);
        assert!(moved.is_ok() && sharing == 0, "{moved:?}, {sharing}");
        let message = all(room + 1).0.unwrap_err().to_string();
        let says = format!(
            "and {} cells of the texture can hold one",
            grouped(room.into())
        );
        assert!(message.contains(&says), "{message}");
    }
}
