//! Food on the device.

use std::sync::Arc;

use glam::UVec2;

use super::{FoodSet, scent_of};
use crate::gpu::{Buffer, Context, DispatchGroups, GpuError};
use crate::sim::buffers::{self, Counts};
use crate::sim::texture::Texture;
use crate::sim::types::{Mark, Meal};

/// Buffers of food and markers.
pub struct FoodBuffers {
    /// One per food or marker: its remaining amount.
    pub meals: Buffer<Meal>,
    /// Their marks in pictures.
    pub marks: Buffer<Mark>,
    /// One per texel, gutters filled: trail units that are added to sensor readings.
    pub scent: Texture<f32>,
    /// One per texel, gutters filled: that scent and what crosses from other objects, if scents do.
    pub around: Option<Texture<f32>>,
    /// One per texel, gutters filled: the food that is eaten there, counted from 1, or 0.
    pub plates: Texture<u32>,
    /// As [`FoodSet::scented`].
    pub scented: Buffer<UVec2>,
    /// As [`FoodSet::falloffs`].
    pub falloffs: Buffer<UVec2>,
    /// As [`FoodSet::projected`].
    pub projected: Buffer<UVec2>,
    /// The groups of the dispatch that sums up scents again.
    pub groups: Buffer<DispatchGroups>,
    /// The number of foods and markers.
    pub food_count: u32,
}

impl FoodBuffers {
    /// Takes the memory and uploads the data; `meals` are the amounts of foods.
    ///
    /// # Errors
    /// No memory.
    pub fn new(ctx: &Arc<Context>, food_set: &FoodSet, meals: &[Meal]) -> Result<Self, GpuError> {
        let field = scent_of(food_set, meals);
        let counts = &Counts {
            foods: meals.len() as u64,
            texels: food_set.plates.len() as u64,
            scents: (
                food_set.scented.len() as u64,
                food_set.falloffs.len() as u64,
            ),
            projected: food_set.projected.len() as u64,
            crosses: food_set.crosses,
            ..Counts::default()
        };
        let scent = buffers::SCENT.of(ctx, counts, &field)?;
        let plates = buffers::PLATES.of(ctx, counts, &food_set.plates)?;
        // Markers without a radius reach nothing.
        let falloffs = or_one(&food_set.falloffs);
        let projected = or_one(&food_set.projected);
        Ok(Self {
            meals: buffers::MEALS.of(ctx, counts, meals)?,
            marks: buffers::MARKS.of(ctx, counts, &food_set.marks)?,
            scent: Texture::new(ctx, scent)?,
            around: (food_set.crosses)
                .then(|| Texture::new(ctx, buffers::SCENT_AROUND.zeroed(ctx, counts)?))
                .transpose()?,
            plates: Texture::new(ctx, plates)?,
            scented: buffers::SCENTED.of(ctx, counts, &food_set.scented)?,
            falloffs: buffers::FALLOFFS.of(ctx, counts, falloffs)?,
            projected: buffers::PROJECTED.of(ctx, counts, projected)?,
            groups: buffers::SCENT_GROUPS.zeroed(ctx, counts)?,
            food_count: meals.len() as u32,
        })
    }

    /// The scent that sensors read.
    #[must_use]
    pub fn sensed(&self) -> &Texture<f32> {
        self.around.as_ref().unwrap_or(&self.scent)
    }

    /// The scent with what crosses from other objects.
    ///
    /// # Panics
    /// Where scents do not cross.
    #[must_use]
    pub fn around(&self) -> &Texture<f32> {
        self.around.as_ref().expect("scents cross contacts")
    }
}

/// Buffers have at least one element.
fn or_one(elements: &[UVec2]) -> &[UVec2] {
    if elements.is_empty() {
        &[UVec2::ZERO]
    } else {
        elements
    }
}
