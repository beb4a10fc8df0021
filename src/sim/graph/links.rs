//! The texels that a network covers, and which of them touch: within a chart, over a seam, and where objects touch.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::{DAffine3, DVec3};

use super::surroundings::Surroundings;
use crate::mesh::surface::NONE;
use crate::sim::network::AROUND;

/// Texels whose centres are no more than so many texel sides apart touch, if the atlas does not say it: a diagonal, and a little more.
const TOUCH: f64 = 1.6;

/// Texels whose sides differ by no more than this factor are alike.
const ALIKE: f64 = 2.0;

/// A walk between two of them that belong together goes over no more than so many.
const MOST_STEPS: usize = 4096;

/// Covers bare parts of fewer texels than this, connected by their sides: they are noise.
pub fn cover_holes(around: &Surroundings<'_>, covered: &mut [bool], smallest: usize) {
    let atlas = around.atlas;
    let across = across(around);
    let pitch = i64::from(atlas.pitch);
    let rows = covered.len() as i64 / pitch;
    let mut is_seen = vec![false; covered.len()];
    for start in 0..covered.len() {
        let is_bare = |texel: usize| atlas.owner[texel] != NONE && !covered[texel];
        if !is_bare(start) || std::mem::replace(&mut is_seen[start], true) {
            continue;
        }
        let mut part = vec![start];
        let mut done = 0;
        while let Some(&at) = part.get(done) {
            done += 1;
            let (x, y) = (at as i64 % pitch, at as i64 / pitch);
            for (dx, dy) in AROUND.into_iter().step_by(2) {
                let (x, y) = (x + dx, y + dy);
                if !((0..pitch).contains(&x) && (0..rows).contains(&y)) {
                    continue;
                }
                let there = (y * pitch + x) as usize;
                let other = if atlas.owner[there] == NONE {
                    across[there]
                } else {
                    there as u32
                };
                if other != NONE
                    && is_bare(other as usize)
                    && !std::mem::replace(&mut is_seen[other as usize], true)
                {
                    part.push(other as usize);
                }
            }
        }
        if part.len() < smallest {
            part.into_iter().for_each(|texel| covered[texel] = true);
        }
    }
}

/// For each gutter texel the one that it stands for, across a seam.
fn across(around: &Surroundings<'_>) -> Vec<u32> {
    let mut across = vec![NONE; around.atlas.owner.len()];
    for seam in &around.atlas.seams {
        across[seam.texel as usize] = seam.main_source();
    }
    across
}

/// Covered texels, numbered from 0, and which of them touch.
#[derive(Debug)]
pub struct Links {
    /// The texel of each.
    pub texels: Vec<u32>,
    /// The numbers of those that each one touches, ascending.
    pub beside: Vec<Vec<u32>>,
    /// Does a bare part of the surface, or no surface, lie beside it?
    pub is_border: Vec<bool>,
    /// The place of each, in scene radii.
    pub places: Vec<DVec3>,
    /// The side of each texel, in scene radii.
    pub sides: Vec<f64>,
    /// The object of each.
    pub objects: Vec<u32>,
    /// For links over glued edges, the motion that carries the second to where the first has it beside itself. Places alone would lie
    /// apart.
    pub glued: HashMap<(u32, u32), DAffine3>,
}

impl Links {
    /// The links among all texels for which `covered` is true.
    pub fn of(around: &Surroundings<'_>, covered: &[bool]) -> Self {
        let atlas = around.atlas;
        let owned = (0..covered.len() as u32).filter(|&t| atlas.owner[t as usize] != NONE);
        let texels: Vec<u32> = owned.filter(|&texel| covered[texel as usize]).collect();
        let mut number = vec![NONE; covered.len()];
        for (i, &texel) in (0..).zip(&texels) {
            number[texel as usize] = i;
        }
        let across = across(around);
        let mut links = Self {
            places: texels.iter().map(|&texel| around.place(texel)).collect(),
            sides: texels.iter().map(|&texel| around.side(texel)).collect(),
            objects: texels.iter().map(|&texel| around.object(texel)).collect(),
            beside: vec![Vec::new(); texels.len()],
            is_border: vec![false; texels.len()],
            glued: HashMap::new(),
            texels,
        };
        links.link_neighbours(around, &number, &across);
        links.close_seams(around);
        if around.surface.objects.len() > 1 {
            links.link_contacts();
        }
        links
    }

    /// Links those that lie side by side or corner to corner. A gutter texel stands for the one across the seam.
    fn link_neighbours(&mut self, around: &Surroundings<'_>, number: &[u32], across: &[u32]) {
        let atlas = around.atlas;
        let pitch = i64::from(atlas.pitch);
        let rows = number.len() as i64 / pitch;
        let chart = |texel: u32| atlas.chart[atlas.owner[texel as usize] as usize];
        let motions = around.motions();
        for i in 0..self.texels.len() {
            let texel = self.texels[i];
            let (x, y) = (i64::from(texel) % pitch, i64::from(texel) / pitch);
            for (k, (dx, dy)) in AROUND.into_iter().enumerate() {
                let (x, y) = (x + dx, y + dy);
                if !((0..pitch).contains(&x) && (0..rows).contains(&y)) {
                    continue;
                }
                let there = (y * pitch + x) as usize;
                let other = match atlas.owner[there] {
                    NONE => across[there],
                    _ if chart(there as u32) == chart(texel) => there as u32,
                    _ => NONE,
                };
                if other == NONE || other == texel {
                    // Where the mesh ends.
                    self.is_border[i] |= k % 2 == 0 && around.is_at_open_border(texel);
                    continue;
                }
                let mut motion = None;
                if around.is_glued_between(texel, other) {
                    motion = around.motion_between(&motions, texel, other);
                    if motion.is_none() {
                        // No edge, nor two of them, leads from one to the other.
                        self.is_border[i] |= k % 2 == 0;
                        continue;
                    }
                }
                match number[other as usize] {
                    // A corner does not make a border: bare texels are not connected by corners.
                    NONE => self.is_border[i] |= k % 2 == 0,
                    other => self.link_over(i as u32, other, motion),
                }
            }
        }
    }

    /// Beside a seam, gutters name only the nearest of the texels across: those between are found by where they lie.
    fn close_seams(&mut self, around: &Surroundings<'_>) {
        let atlas = around.atlas;
        let is_in_one_chart = |a: u32, b: u32| {
            let chart = |i: u32| {
                let owner = atlas.owner[self.texels[i as usize] as usize];
                atlas.chart[owner as usize]
            };
            chart(a) == chart(b)
        };
        let pitch = atlas.pitch;
        let is_side_by_side = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|i| self.texels[i as usize]);
            let apart = |a: u32, b: u32| a.abs_diff(b) < 2;
            apart(a % pitch, b % pitch) && apart(a / pitch, b / pitch)
        };
        let mut found = Vec::new();
        for i in 0..self.texels.len() as u32 {
            let beside = &self.beside[i as usize];
            let is_at_seam = (beside.iter())
                .any(|&other| !(is_in_one_chart(i, other) && is_side_by_side(i, other)));
            if !is_at_seam {
                continue;
            }
            let two_away = beside.iter().flat_map(|&between| {
                let all = self.beside[between as usize].iter();
                all.map(move |&other| (between, other))
            });
            for (between, other) in two_away {
                if other <= i || beside.contains(&other) {
                    continue;
                }
                let over = [(i, between), (between, other)].map(|pair| self.glued.get(&pair));
                let motion = match over {
                    [None, None] => None,
                    [one, two] => {
                        let [one, two] =
                            [one, two].map(|motion| motion.copied().unwrap_or(DAffine3::IDENTITY));
                        Some(one * two)
                    }
                };
                if self.touch_over(i, other, motion) {
                    found.push((i, other, motion));
                }
            }
        }
        for (i, other, motion) in found {
            self.link_over(i, other, motion);
        }
    }

    /// Links texels of different objects that lie at the same place. If one object's are much finer, each is linked to the nearest only.
    fn link_contacts(&mut self) {
        let cell = TOUCH * self.sides.iter().copied().fold(0.0, f64::max);
        if cell <= 0.0 {
            return;
        }
        let cell_of = |place: DVec3| (place / cell).floor().as_ivec3();
        let mut cells: HashMap<_, Vec<u32>> = HashMap::new();
        for (i, &place) in (0..).zip(&self.places) {
            cells.entry(cell_of(place)).or_default().push(i);
        }
        let mut found = Vec::new();
        for i in 0..self.texels.len() as u32 {
            let at = cell_of(self.places[i as usize]);
            let mut nearest: Option<(f64, u32)> = None;
            for offset in 0..27 {
                let step = glam::IVec3::new(offset % 3, offset / 3 % 3, offset / 9) - 1;
                for &other in cells.get(&(at + step)).into_iter().flatten() {
                    let differ = self.objects[i as usize] != self.objects[other as usize];
                    if !differ || !self.touch(i, other) {
                        continue;
                    }
                    let [a, b] = [i, other].map(|i| self.sides[i as usize]);
                    if a.max(b) <= ALIKE * a.min(b) {
                        found.push((i, other));
                        continue;
                    }
                    let [a, b] = [i, other].map(|i| self.places[i as usize]);
                    let apart = (a.distance_squared(b), other);
                    if nearest.is_none_or(|nearest| apart < nearest) {
                        nearest = Some(apart);
                    }
                }
            }
            found.extend(nearest.map(|(_, other)| (i, other)));
        }
        for (i, other) in found {
            self.link(i, other);
        }
    }

    fn touch(&self, a: u32, b: u32) -> bool {
        self.touch_over(a, b, None)
    }

    /// Do they touch if this motion carries the second?
    fn touch_over(&self, a: u32, b: u32, motion: Option<DAffine3>) -> bool {
        let [a, b] = [a, b].map(|i| i as usize);
        let side = 0.5 * (self.sides[a] + self.sides[b]);
        let there = motion.map_or(self.places[b], |motion| {
            motion.transform_point3(self.places[b])
        });
        self.places[a].distance(there) <= TOUCH * side
    }

    /// Links two of them, over a glued edge if there is a motion.
    fn link_over(&mut self, a: u32, b: u32, motion: Option<DAffine3>) {
        self.link(a, b);
        if let Some(motion) = motion
            && a != b
        {
            self.glued.entry((a, b)).or_insert(motion);
            self.glued.entry((b, a)).or_insert(motion.inverse());
        }
    }

    /// The motion that carries `to` to where a walk from `from` over few texels comes to it.
    pub fn motion(&self, from: u32, to: u32) -> DAffine3 {
        if self.glued.is_empty() || from == to {
            return DAffine3::IDENTITY;
        }
        let mut motions = HashMap::from([(from, DAffine3::IDENTITY)]);
        let mut found = vec![from];
        let mut done = 0;
        while let Some(&at) = found.get(done).filter(|_| done < MOST_STEPS) {
            done += 1;
            let motion = motions[&at];
            for &other in &self.beside[at as usize] {
                if motions.contains_key(&other) {
                    continue;
                }
                let step = self.glued.get(&(at, other)).copied();
                let motion = motion * step.unwrap_or(DAffine3::IDENTITY);
                if other == to {
                    return motion;
                }
                motions.insert(other, motion);
                found.push(other);
            }
        }
        DAffine3::IDENTITY
    }

    /// How far apart two of them are that touch.
    fn apart(&self, a: u32, b: u32) -> f64 {
        let [at, there] = [a, b].map(|i| self.places[i as usize]);
        match self.glued.get(&(a, b)) {
            Some(motion) => at.distance(motion.transform_point3(there)),
            None => at.distance(there),
        }
    }

    fn link(&mut self, a: u32, b: u32) {
        for (from, to) in [(a, b), (b, a)] {
            let beside = &mut self.beside[from as usize];
            if let Err(place) = beside.binary_search(&to) {
                beside.insert(place, to);
            }
        }
    }

    /// How far each is from the border of the network, in scene radii, along links, which are up to 8 % longer than straight ways. A part
    /// without a border, such as a whole object, counts from its first texel.
    pub fn depths(&self) -> Vec<f64> {
        let mut depths = vec![f64::INFINITY; self.texels.len()];
        let mut queue = BinaryHeap::new();
        for i in (0..depths.len()).filter(|&i| self.is_border[i]) {
            depths[i] = 0.5 * self.sides[i];
            queue.push(Reverse((depths[i].to_bits(), i as u32)));
        }
        let mut first = 0;
        loop {
            // Positive numbers are in the order of their bits.
            while let Some(Reverse((bits, at))) = queue.pop() {
                let depth = f64::from_bits(bits);
                if depth > depths[at as usize] {
                    continue;
                }
                for &other in &self.beside[at as usize] {
                    let beyond = depth + self.apart(at, other);
                    if beyond < depths[other as usize] {
                        depths[other as usize] = beyond;
                        queue.push(Reverse((beyond.to_bits(), other)));
                    }
                }
            }
            let Some(next) = (first..depths.len()).find(|&i| depths[i].is_infinite()) else {
                return depths;
            };
            first = next;
            depths[next] = 0.5 * self.sides[next];
            queue.push(Reverse((depths[next].to_bits(), next as u32)));
        }
    }
}
