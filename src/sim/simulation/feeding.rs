//! Food and markers of the running simulation: adding and removing them, and their remaining amounts.

use std::sync::{Arc, Weak};

use super::super::course::Course;
use super::super::food::buffers::FoodBuffers;
use super::super::food::{FoodPlace, FoodSet, places, scent_of};
use super::super::plan::Means;
use super::super::setup::Setup;
use super::super::snapshot::FoodState;
use super::super::types::Meal;
use super::{Simulation, pipelines_of};
use crate::error::{Error, Result};
use crate::gpu::{Context, GpuError};
use crate::mesh::atlas::Control;
use crate::scene::foods;
use crate::scene::settings::Settings;

/// Food that replaces the present food.
pub(super) struct Served {
    food_set: FoodSet,
    buffers: Option<FoodBuffers>,
    /// The remaining meals in the buffers.
    meals: Vec<Meal>,
}

impl Served {
    /// The buffers of a food set, with `left` remaining meals of each food.
    fn new(ctx: &Arc<Context>, food_set: FoodSet, left: &[u32]) -> Result<Self> {
        let meals = food_set.meals(Some(left));
        let buffers = (!food_set.is_empty())
            .then(|| FoodBuffers::new(ctx, &food_set, &meals))
            .transpose()?;
        Ok(Self {
            food_set,
            buffers,
            meals,
        })
    }

    /// Updates the remaining meals, because food was eaten in the meantime.
    fn keep(&mut self, ctx: &Context, left: &[u32]) -> Result<()> {
        let meals = self.food_set.meals(Some(left));
        if let Some(buffers) = self.buffers.as_ref().filter(|_| meals != self.meals) {
            let scents = |meals: &[Meal]| -> Vec<u32> {
                meals.iter().map(|meal| meal.scent.to_bits()).collect()
            };
            let smells_as_before = scents(&meals) == scents(&self.meals);
            ctx.upload(&buffers.meals, &meals)?;
            if !smells_as_before {
                ctx.upload(&buffers.scent, &scent_of(&self.food_set, &meals))?;
            }
        }
        self.meals = meals;
        Ok(())
    }
}

/// Other food for a running simulation: the slow part of its preparation, for any thread.
pub struct FoodOrder {
    /// Weak, because measuring takes long and needs no device, and must not keep the device alive.
    ctx: Weak<Context>,
    /// The settings with this food.
    course: Course,
    means: Means,
    /// Remaining meals of the present food.
    remaining: Vec<u32>,
}

/// Other food, measured; [`Simulation::apply_with_food`] puts it into effect.
pub struct PreparedFood {
    /// The settings that it was ordered with.
    settings: Settings,
    /// None if no place has changed, and scents cross as before.
    served: Option<Served>,
    /// The food before.
    before: Vec<FoodPlace>,
    /// Did its scents cross from object to object?
    crossed: bool,
}

impl FoodOrder {
    /// Measures the distances of texels from it, and makes the kernels that the first food needs.
    ///
    /// # Errors
    /// When a food is too far from its object or on none, there are too many, or they reach too many texels; when the device is lost or was
    /// destroyed in the meantime; and when it was cancelled.
    pub fn prepare(self, control: &Control<'_>) -> Result<PreparedFood> {
        let Course {
            setup, settings, ..
        } = &self.course;
        let food_set = measured(setup, settings, control)?;
        let ctx = self.ctx.upgrade().filter(|ctx| !ctx.is_lost());
        let ctx = ctx.ok_or_else(|| GpuError::DeviceLost {
            call: "preparing food",
            last: "food was being measured without it".to_owned(),
        })?;
        let served = food_set
            .map(|food_set| {
                let left = food_set.kept(&setup.food_set, &self.remaining);
                Served::new(&ctx, food_set, &left)
            })
            .transpose()?;
        // The first food needs other kernels, which the device keeps in its cache until they are needed.
        pipelines_of(
            &ctx,
            &self.course.setup,
            &self.course.of_every_kernel(settings, self.means),
        )?;
        Ok(PreparedFood {
            before: setup.food_set.places.clone(),
            crossed: setup.food_set.crosses,
            settings: settings.clone(),
            served,
        })
    }
}

impl PreparedFood {
    /// Is it the food of these settings?
    #[must_use]
    pub fn is_of(&self, settings: &Settings) -> bool {
        has_same_food(&self.settings, settings)
    }

    /// Puts this food into settings.
    pub fn put_into(&self, settings: &mut Settings) {
        settings.foods.clone_from(&self.settings.foods);
        settings.feeding = self.settings.feeding.clone();
    }

    /// Is it also based on the present food?
    fn is_for(&self, settings: &Settings, there: &FoodSet) -> bool {
        let is_still_there = self.before == there.places && self.crossed == there.crosses;
        self.is_of(settings) && (self.served.is_some() || is_still_there)
    }
}

/// Do both settings have the same food?
fn has_same_food(a: &Settings, b: &Settings) -> bool {
    a.foods == b.foods && a.feeding == b.feeding
}

/// The food of changed settings; none if no place has changed, and scents cross as before.
fn measured(setup: &Setup, settings: &Settings, control: &Control<'_>) -> Result<Option<FoodSet>> {
    if let [problem, ..] = &foods::problems(settings)[..] {
        return Err(Error::Invalid(problem.clone()));
    }
    let places = places(settings, &setup.surface, &setup.origins, setup.radius)?;
    let crosses = settings.scent_crosses();
    if places == setup.food_set.places && crosses == setup.food_set.crosses {
        return Ok(None);
    }
    let (surface, before) = (&setup.surface, Some(&setup.food_set));
    let food_set = FoodSet::new(surface, &setup.atlas, places, before, control)?;
    Ok(Some(food_set.crossing(crosses)))
}

impl Simulation {
    /// The food of changed settings, if it differs from the present food, as an order for any thread. The present food stays until the new
    /// one is prepared.
    #[must_use]
    pub fn order_food(&self, settings: &Settings) -> Option<FoodOrder> {
        (!has_same_food(settings, self.settings())).then(|| FoodOrder {
            ctx: Arc::downgrade(&self.ctx),
            course: self.course.with_settings(settings),
            means: self.means(),
            // A guess: amounts that are eaten in the meantime are corrected when it is served.
            remaining: self.remaining().unwrap_or_default(),
        })
    }

    /// The food of changed settings, if it is other food. Food that stays at its place keeps its remaining amount.
    pub(super) fn served(
        &self,
        settings: &Settings,
        prepared: Option<&mut PreparedFood>,
    ) -> Result<Option<Served>> {
        if has_same_food(settings, self.settings()) {
            return Ok(None);
        }
        let mut served = match prepared {
            Some(food) if food.is_for(settings, &self.setup().food_set) => food.served.take(),
            _ => measured(self.setup(), settings, &Control::default())?
                .map(|food_set| {
                    let left = food_set.kept(&self.setup().food_set, &self.remaining()?);
                    Served::new(&self.ctx, food_set, &left)
                })
                .transpose()?,
        };
        if let Some(served) = &mut served {
            let left = served
                .food_set
                .kept(&self.setup().food_set, &self.remaining()?);
            served.keep(&self.ctx, &left)?;
        }
        Ok(served)
    }

    /// Puts the food into effect from the next step on.
    pub(super) fn serve(&mut self, served: Served) {
        self.course.serve(served.food_set);
        self.state.food = served.buffers;
    }

    /// The food of a snapshot.
    pub(super) fn restored_food(&self, food: &FoodState) -> Result<Option<FoodBuffers>> {
        let food_set = &self.setup().food_set;
        let meals = food_set.meals(Some(&food.remaining));
        let buffers = (!food_set.is_empty()).then(|| FoodBuffers::new(&self.ctx, food_set, &meals));
        Ok(buffers.transpose()?)
    }

    /// Remaining meals of each food, copied to the host like [`snapshot`](Self::snapshot); always 1 for markers and for
    /// food without an amount.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn remaining(&self) -> Result<Vec<u32>> {
        let Some(food) = &self.state.food else {
            return Ok(Vec::new());
        };
        let meals = self.ctx.download(&food.meals)?;
        Ok(meals.iter().map(|meal| meal.remaining).collect())
    }

    /// The places of foods and markers, first those that the settings name.
    #[must_use]
    pub fn food_places(&self) -> &[FoodPlace] {
        &self.setup().food_set.places
    }
}
