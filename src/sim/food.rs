//! Food and markers: their places, the distances of texels along the surface, and the scent that sensors read.
//!
//! The host measures the distances; simulation and twin begin from one [`FoodSet`]. The kernels `digest` and `scent` update
//! amounts and scents as food is eaten, and `project` adds to the trail on food.

pub mod buffers;
mod places;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec3, UVec2};
use rayon::prelude::*;

use super::types::{Mark, Meal};
use crate::error::{Error, Result};
use crate::mesh::atlas::{Atlas, AtlasError, Control};
use crate::mesh::surface::{Seam, Surface};
use crate::mesh::surface_distance::SurfaceDistance;
use crate::mesh::walk::SurfacePoint;

pub use places::{nearest_on_object, places};

/// Levels of a scent; `shaders/digest.comp` and `shaders/project.comp` have an equal constant.
pub const LEVELS: u32 = 64;
/// `LEVELS * amount + amount` fits in 32 bits.
pub const MOST_AMOUNT: u32 = 60_000_000;
/// Most entries of the falloff table, one per texel and food that reaches it: as many as a storage block of every device
/// holds.
const MOST_FALLOFFS: usize = 1 << 24;
/// Name of the measuring of distances to food in progress reports.
pub const MEASURING: &str = "measuring food";
/// The share of a food's work that measures paths over triangles. The rest processes texels.
const WAYS_SHARE: f32 = 0.8;
/// A marker is drawn as food with this share of its radius, but no larger than [`MARKER_RADIUS`].
const MARKER_SHARE: f64 = 0.08;
/// As a share of the object's own extent.
const MARKER_RADIUS: f64 = 0.03;

/// Falloffs below this count as 0: products with smaller ones could underflow on some devices.
const FAINTEST: f32 = 1e-20;

/// A food or a marker and its place. Lengths are world lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoodPlace {
    /// The object that it lies on and moves with.
    pub object: u32,
    /// Its place on the surface.
    pub point: SurfacePoint,
    /// The distance along the surface up to which sensors read it.
    pub radius: f64,
    /// Trail units that are added to sensor readings at its place; negative to repel.
    pub strength: f32,
    /// The distance along the surface up to which it is eaten; 0 for a marker.
    pub size: f64,
    /// Its number of meals; 0 for an endless food.
    pub amount: u32,
    /// Trail units that it adds to the trail in a step, at each of its texels in [`FoodSet::projected`]; 0 for none.
    pub projection: f32,
}

impl FoodPlace {
    /// Distance up to which it has an effect.
    fn reach(&self) -> f64 {
        self.radius.max(self.size)
    }

    /// Does the other food have the same place and reach, with any strength and amount?
    fn reaches_as(&self, other: &Self) -> bool {
        (self.point, self.reach()) == (other.point, other.reach())
    }

    /// The share of the strength at a distance: 1 at its place, 0 from the radius on.
    #[must_use]
    pub fn falloff(&self, distance: f64) -> f64 {
        let share = (1.0 - distance / self.radius).max(0.0);
        share * share
    }

    /// Its mark in pictures.
    fn mark(&self, surface: &Surface) -> Mark {
        let [a, b, c] = surface.corners[self.point.triangle as usize]
            .map(|vertex| surface.positions[vertex as usize].as_dvec3());
        let middle = a + self.point.u * (b - a) + self.point.v * (c - a);
        let (first, end) = surface.objects[self.object as usize].vertices;
        let own = &surface.positions[first as usize..end as usize];
        let extent = own.iter().fold(0.0_f32, |far, p| far.max(p.length()));
        let marker = (MARKER_SHARE * self.radius).min(MARKER_RADIUS * f64::from(extent));
        let is_food = self.size > 0.0;
        Mark {
            position: middle.as_vec3(),
            object: self.object,
            normal: (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3(),
            radius: if is_food { self.size } else { marker } as f32,
            is_food: is_food.into(),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        }
    }

    /// Its state on the device: uneaten, or with `remaining` meals.
    #[must_use]
    pub fn meal(&self, remaining: Option<u32>) -> Meal {
        let Self {
            amount,
            strength,
            projection,
            ..
        } = *self;
        let mut meal = Meal {
            // Endless food always has a remaining meal.
            remaining: if amount == 0 {
                1
            } else {
                remaining.unwrap_or(amount).min(amount)
            },
            eaten: 0,
            amount,
            level: LEVELS,
            strength,
            scent: strength,
            projection,
            pad0: 0,
        };
        if amount > 0 {
            meal.smell();
        }
        meal
    }
}

impl Meal {
    /// Sets the scent by the remaining amount, in levels.
    pub(super) fn smell(&mut self) {
        self.level = (LEVELS * self.remaining).div_ceil(self.amount);
        self.scent = self.strength * (self.level as f32 * (1.0 / LEVELS as f32));
    }
}

/// The texels within reach of one food: each owned one with its distance.
type Reached = Vec<(u32, f32)>;

/// All data of food and markers that does not change as food is eaten.
#[derive(Clone, Debug, Default)]
pub struct FoodSet {
    /// All foods and markers.
    pub places: Vec<FoodPlace>,
    /// The texels that any food reaches, ascending, each with its first entry in `falloffs`; then one more with the end of the table.
    pub scented: Vec<UVec2>,
    /// The falloff table: for each texel and food that reaches it, the food's index and the bits of its falloff there.
    pub falloffs: Vec<UVec2>,
    /// One per texel: the food that is eaten there, counted from 1, or 0. Empty in scenes without foods and markers.
    pub plates: Vec<u32>,
    /// The texels at which food is projected into the trail, ascending, each with the index of the food.
    pub projected: Vec<UVec2>,
    /// The mark of each in pictures.
    pub marks: Vec<Mark>,
    /// Do scents cross from object to object?
    pub crosses: bool,
    /// The texels within reach of each place, kept so that unchanged places need not be measured again.
    reached: Vec<Arc<Reached>>,
}

impl FoodSet {
    /// Measures the distances of texels from these places, or takes them from `before` if it has them. Reports progress as
    /// [`MEASURING`].
    ///
    /// # Errors
    /// When the falloff table would have more entries than it may, and [`AtlasError::Cancelled`] when it was cancelled.
    pub fn new(
        surface: &Surface,
        atlas: &Atlas,
        places: Vec<FoodPlace>,
        before: Option<&Self>,
        control: &Control<'_>,
    ) -> Result<Self> {
        if places.is_empty() {
            return Ok(Self::default());
        }
        let reached = reached_by_all(surface, atlas, &places, before, control)?;
        let count: usize = reached.iter().map(|reached| reached.len()).sum();
        let both = places.iter().zip(&reached);
        let mut entries: Vec<(u32, u32, f32)> = Vec::with_capacity(count);
        let mut plates = vec![0; atlas.density.len()];
        let mut nearest = vec![f32::INFINITY; atlas.density.len()];
        let mut falloff = vec![0.0_f32; atlas.density.len()];
        for (food, (place, reached)) in (0..).zip(both) {
            control.check()?;
            for &(texel, distance) in reached.iter() {
                let value = place.falloff(distance.into()) as f32;
                if value >= FAINTEST {
                    falloff[texel as usize] = value;
                    entries.push((texel, food, value));
                }
                // If two discs overlap, the nearer food is eaten.
                if f64::from(distance) < place.size && distance < nearest[texel as usize] {
                    nearest[texel as usize] = distance;
                    plates[texel as usize] = food + 1;
                }
            }
            let filled = atlas.seams.iter().filter_map(|seam| {
                let value = mixed(seam, &falloff);
                (value >= FAINTEST).then_some((seam.texel, food, value))
            });
            entries.extend(filled);
            for &(texel, _) in reached.iter() {
                falloff[texel as usize] = 0.0;
            }
        }
        for seam in &atlas.seams {
            plates[seam.texel as usize] = plates[seam.main_source() as usize];
        }
        refuse_too_many(entries.len())?;
        entries.par_sort_unstable_by_key(|&(texel, food, _)| (texel, food));
        let mut scented: Vec<UVec2> = Vec::new();
        for (i, &(texel, ..)) in (0..).zip(&entries) {
            if scented.last().is_none_or(|last| last.x != texel) {
                scented.push(UVec2::new(texel, i));
            }
        }
        scented.push(UVec2::new(0, entries.len() as u32));
        let falloffs = entries.iter();
        Ok(Self {
            falloffs: falloffs
                .map(|&(_, food, value)| UVec2::new(food, value.to_bits()))
                .collect(),
            marks: places.iter().map(|place| place.mark(surface)).collect(),
            projected: projected(atlas, &places, &reached),
            crosses: false,
            places,
            scented,
            plates,
            reached,
        })
    }

    /// This set, with or without scents that cross from object to object.
    #[must_use]
    pub fn crossing(self, crosses: bool) -> Self {
        Self { crosses, ..self }
    }

    /// May a scent fall, because food is eaten that ends?
    #[must_use]
    pub fn may_fall(&self) -> bool {
        let mut places = self.places.iter();
        places.any(|place| place.amount > 0 && place.size > 0.0)
    }

    /// Is there neither food nor marker?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Number of texels that any food or marker reaches.
    #[must_use]
    pub fn scented_count(&self) -> u32 {
        self.scented.len().saturating_sub(1) as u32
    }

    /// The state of each on the device, with `remaining` meals if given, otherwise with all of them.
    #[must_use]
    pub fn meals(&self, remaining: Option<&[u32]>) -> Vec<Meal> {
        let places = self.places.iter().enumerate();
        places
            .map(|(i, place)| place.meal(remaining.map(|remaining| remaining[i])))
            .collect()
    }

    /// The remaining meals of each after a change from `before` to this set. Unchanged foods keep theirs, and so does a food that has
    /// moved, if it is the only one.
    #[must_use]
    pub fn kept(&self, before: &Self, remaining: &[u32]) -> Vec<u32> {
        let mut was: Vec<Option<(&FoodPlace, u32)>> = (before.places.iter())
            .zip(remaining.iter().copied())
            .map(Some)
            .collect();
        let same = |a: &FoodPlace, b: &FoodPlace| (a.point, a.amount) == (b.point, b.amount);
        let mut take = |place: &FoodPlace| {
            let mut old = was.iter_mut();
            let old = old.find(|old| old.is_some_and(|(old, _)| same(old, place)));
            old.and_then(|old| old.take().map(|(_, left)| left))
        };
        let mut kept: Vec<Option<u32>> = self.places.iter().map(&mut take).collect();
        let gone = only(was.iter().map(Option::is_some));
        if let Some(moved) = only(kept.iter().map(Option::is_none)).filter(|new| gone == Some(*new))
            && before.places[moved].amount == self.places[moved].amount
        {
            kept[moved] = Some(remaining[moved]);
        }
        let places = self.places.iter().zip(kept);
        places
            .map(|(place, kept)| place.meal(kept).remaining)
            .collect()
    }
}

/// The scent that sensors read, one value per texel, gutters filled, for the amounts in `meals`.
#[must_use]
pub fn scent_of(food_set: &FoodSet, meals: &[Meal]) -> Vec<f32> {
    let mut field = vec![0.0; food_set.plates.len()];
    for texel in food_set.scented.windows(2) {
        let falloffs = &food_set.falloffs[texel[0].y as usize..texel[1].y as usize];
        field[texel[0].x as usize] = scent_at(falloffs, meals);
    }
    field
}

/// The scent at a texel: the sum over foods of falloff times strength left.
#[must_use]
pub fn scent_at(falloffs: &[UVec2], meals: &[Meal]) -> f32 {
    let mut sum = 0.0;
    for entry in falloffs {
        sum += meals[entry.x as usize].scent * f32::from_bits(entry.y);
    }
    sum
}

/// The index of the only true value, if exactly one is true.
fn only(are: impl Iterator<Item = bool>) -> Option<usize> {
    let mut places = are.enumerate().filter(|(_, is)| *is);
    let place = places.next().map(|(i, _)| i);
    place.filter(|_| places.next().is_none())
}

/// The texels within reach of each place, taken from `before` if it has them.
fn reached_by_all(
    surface: &Surface,
    atlas: &Atlas,
    places: &[FoodPlace],
    before: Option<&FoodSet>,
    control: &Control<'_>,
) -> Result<Vec<Arc<Reached>>> {
    let known = |place: &FoodPlace| {
        let before = before?;
        let same = before.places.iter().position(|was| was.reaches_as(place));
        same.map(|i| Arc::clone(&before.reached[i]))
    };
    // The finished share of each, as the bits of a float.
    let done: Vec<AtomicU32> = places.iter().map(|_| AtomicU32::new(0)).collect();
    let reported = Mutex::new(0.0_f32);
    let report = |i: usize, share: f32| {
        done[i].store(share.to_bits(), Ordering::Relaxed);
        // One report at a time, so that none is lower than the one before.
        let mut reported = reported.lock().unwrap_or_else(PoisonError::into_inner);
        let shares = done
            .iter()
            .map(|share| f32::from_bits(share.load(Ordering::Relaxed)));
        *reported = reported.max(shares.sum::<f32>() / places.len() as f32);
        control.step(MEASURING, *reported)
    };
    let count = AtomicUsize::new(0);
    let all = places.par_iter().enumerate().map(|(i, place)| {
        let reached = match known(place) {
            Some(reached) => reached,
            None => {
                let of_this = |_: &'static str, share: f32| {
                    // The next check detects a cancellation.
                    let _ = report(i, WAYS_SHARE * share);
                };
                let control = Control {
                    progress: Some(&of_this),
                    ..*control
                };
                Arc::new(reached(surface, atlas, place, &control)?)
            }
        };
        // Checked before all are measured, because too many would take long.
        refuse_too_many(count.fetch_add(reached.len(), Ordering::Relaxed) + reached.len())?;
        report(i, 1.0)?;
        Ok(reached)
    });
    all.collect()
}

/// The owned texels within reach of a place, with their distances along the surface.
fn reached(
    surface: &Surface,
    atlas: &Atlas,
    place: &FoodPlace,
    control: &Control<'_>,
) -> Result<Reached, AtlasError> {
    let reach = place.reach();
    let distance = SurfaceDistance::with_control(surface, &[place.point], reach, control)?;
    let (first, end) = surface.objects[place.object as usize].triangles;
    let corners = |triangle: u32| {
        let corners = surface.corners[triangle as usize];
        corners.map(|vertex| surface.positions[vertex as usize].as_dvec3())
    };
    let [a, b, c] = corners(place.point.triangle);
    let middle = a + place.point.u * (b - a) + place.point.v * (c - a);
    // No path along the surface is shorter than the straight line, unless it goes over a glued edge.
    let is_glued = surface.has_glued_edges(place.object as usize);
    let is_near: Vec<bool> = (first..end)
        .map(|triangle| {
            if is_glued {
                return true;
            }
            let [a, b, c] = corners(triangle);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            middle.distance(middle.clamp(low, high)) <= reach
        })
        .collect();
    let texels = (0..atlas.owner.len() as u32).into_par_iter();
    let reached = texels
        .filter_map(|texel| {
            control.check().ok()?;
            let owner = atlas.owner[texel as usize];
            if owner < first || owner >= end || !is_near[(owner - first) as usize] {
                return None;
            }
            let (triangle, u, v) = atlas.surface_point_of(texel)?;
            let distance = distance.at(triangle, u.into(), v.into());
            (distance <= reach).then_some((texel, distance as f32))
        })
        .collect();
    control.check()?;
    Ok(reached)
}

/// The owned texels at which food is projected into the trail, each with the nearest food that is: those on its plate, and the one that
/// holds its place, so that markers and food that is smaller than a texel have one.
fn projected(atlas: &Atlas, places: &[FoodPlace], reached: &[Arc<Reached>]) -> Vec<UVec2> {
    let mut nearest: BTreeMap<u32, (f32, u32)> = BTreeMap::new();
    for (food, (place, reached)) in (0..).zip(places.iter().zip(reached)) {
        if place.projection <= 0.0 {
            continue;
        }
        let mut take = |texel: u32, distance: f32| {
            let best = nearest.entry(texel).or_insert((distance, food));
            if distance < best.0 {
                *best = (distance, food);
            }
        };
        for &(texel, distance) in reached.iter() {
            if f64::from(distance) < place.size {
                take(texel, distance);
            }
        }
        take(middle_of(atlas, &place.point), 0.0);
    }
    let nearest = nearest.into_iter();
    nearest
        .map(|(texel, (_, food))| UVec2::new(texel, food))
        .collect()
}

/// The owned texel that holds a place, or stands for the gutter texel that does.
fn middle_of(atlas: &Atlas, point: &SurfacePoint) -> u32 {
    let texel = atlas.texel_of(point.triangle, point.u as f32, point.v as f32);
    let seam = atlas.seams.iter().find(|seam| seam.texel == texel);
    seam.map_or(texel, Seam::main_source)
}

/// The value that fills a gutter texel.
fn mixed(seam: &Seam, field: &[f32]) -> f32 {
    let units = seam.units();
    let parts = (0..4).map(|k| units[k] as f32 * field[seam.source[k] as usize]);
    parts.sum::<f32>() / Seam::UNITS as f32
}

fn refuse_too_many(count: usize) -> Result<()> {
    if count <= MOST_FALLOFFS {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "foods and markers reach more texels, each counted for itself, than the {MOST_FALLOFFS} that there may be: \
         have fewer, give them smaller radii and sizes, or the atlas a smaller size"
    )))
}
