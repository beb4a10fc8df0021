//! One particle a cell at the start: those that begin in a cell with another one go to the nearest free cell.

use glam::{DVec2, Vec2};

use super::super::cells::cell_of;
use super::super::types::{Motion, Particle};
use crate::error::Result;
use crate::mesh::atlas::{Atlas, Control};
use crate::mesh::surface::Surface;
use crate::mesh::walk::Frame;
use crate::strict::{settled, within};

/// Moves particles until no two have one cell. In each cell the first one stays; the others go where a flood from that cell through texels
/// side by side, and over seams, first finds room: on their object, unless it is full. Headings are laid onto the triangles there.
///
/// # Errors
/// When it was stopped.
///
/// # Panics
/// When there are more particles than cells.
pub fn apart(
    (particles, motions): (&mut [Particle], &mut [Motion]),
    surface: &Surface,
    atlas: &Atlas,
    homes: &[u32],
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
    crowded.sort_unstable();
    let mut floods = Floods::new(atlas, homes);
    let mut rest = 0;
    for (done, (cell, slot)) in crowded.into_iter().enumerate() {
        if done.is_multiple_of(256) {
            control.check()?;
        }
        let free = floods.next_free(cell, &taken).unwrap_or_else(|| {
            while taken[rest] || atlas.density[rest] <= 0.0 {
                rest += 1;
            }
            rest as u32
        });
        taken[free as usize] = true;
        move_to(
            (&mut particles[slot], &mut motions[slot]),
            free,
            surface,
            atlas,
        );
    }
    Ok(())
}

/// Puts a particle on the centre of a cell.
fn move_to(
    (particle, motion): (&mut Particle, &mut Motion),
    cell: u32,
    surface: &Surface,
    atlas: &Atlas,
) {
    let (triangle, u, v) = (atlas.surface_point_of(cell)).expect("cells have a triangle");
    let [from, to] = [particle.triangle, triangle].map(|triangle| Frame::of(surface, triangle));
    let [p, h] = [motion.heading_p, motion.heading_h].map(f64::from);
    let heading = p * from.p + h * from.h;
    let laid = DVec2::new(heading.dot(to.p), heading.dot(to.h));
    if triangle != particle.triangle && laid.length() > super::UPRIGHT {
        let Vec2 { x, y } = laid.normalize().as_vec2();
        (motion.heading_p, motion.heading_h) = (settled(x), settled(y));
    }
    *particle = Particle {
        triangle,
        u: settled(u),
        v: settled(within(v, 0.0, 1.0 - u)),
        id: particle.id,
    };
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
