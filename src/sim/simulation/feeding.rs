//! Food and markers of the running simulation: put there, taken away, and what is left of them.

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

/// Food that takes the place of what there is.
pub(super) struct Served {
    food_set: FoodSet,
    buffers: Option<FoodBuffers>,
    /// As the buffers have them.
    meals: Vec<Meal>,
}

impl Served {
    /// The buffers of a food set, with `left` meals left of each food.
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

    /// Updates the meals left, because food was eaten meanwhile.
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

/// Other food for a running simulation: what takes long about it, to be done by any thread.
pub struct FoodOrder {
    /// Measuring takes long and needs no device, so it keeps none from ending.
    ctx: Weak<Context>,
    /// With the settings that ask for it.
    course: Course,
    means: Means,
    /// Meals left of the present food.
    remaining: Vec<u32>,
}

/// Other food, measured; [`Simulation::apply_with_food`] lets it be there.
pub struct PreparedFood {
    /// The settings that it was ordered with.
    settings: Settings,
    /// None where all lies as it did.
    served: Option<Served>,
    /// How that was.
    before: Vec<FoodPlace>,
}

impl FoodOrder {
    /// Measures how far every texel is from it, and makes the kernels that the first food needs.
    ///
    /// # Errors
    /// When a food lies off its object or on none, there are too many, or they reach too many texels; when the device is lost
    /// or has ended meanwhile; and when it was stopped.
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
        // The first food has kernels of its own: the device keeps them until they are asked for.
        pipelines_of(
            &ctx,
            &self.course.setup,
            &self.course.of_every_kernel(settings, self.means),
        )?;
        Ok(PreparedFood {
            before: setup.food_set.places.clone(),
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

    /// Asks for it.
    pub fn put_into(&self, settings: &mut Settings) {
        settings.foods.clone_from(&self.settings.foods);
        settings.feeding = self.settings.feeding.clone();
    }

    /// Is it also based on the present food?
    fn is_for(&self, settings: &Settings, there: &FoodSet) -> bool {
        self.is_of(settings) && (self.served.is_some() || self.before == there.places)
    }
}

/// Do both ask for the same food?
fn has_same_food(a: &Settings, b: &Settings) -> bool {
    a.foods == b.foods && a.feeding == b.feeding
}

/// The food of changed settings; none where it lies as it did.
fn measured(setup: &Setup, settings: &Settings, control: &Control<'_>) -> Result<Option<FoodSet>> {
    if let [problem, ..] = &foods::problems(settings)[..] {
        return Err(Error::Invalid(problem.clone()));
    }
    let places = places(settings, &setup.surface, &setup.origins, setup.radius)?;
    if places == setup.food_set.places {
        return Ok(None);
    }
    let (surface, before) = (&setup.surface, Some(&setup.food_set));
    let food_set = FoodSet::new(surface, &setup.atlas, places, before, control)?;
    Ok(Some(food_set))
}

impl Simulation {
    /// The food of changed settings, if it is other food than what there is, as an order for any thread. Until it is
    /// prepared, what there was stays.
    #[must_use]
    pub fn order_food(&self, settings: &Settings) -> Option<FoodOrder> {
        (!has_same_food(settings, self.settings())).then(|| FoodOrder {
            ctx: Arc::downgrade(&self.ctx),
            course: self.course.with_settings(settings),
            means: self.means(),
            // A guess: what is eaten meanwhile is seen to when it is served.
            remaining: self.remaining().unwrap_or_default(),
        })
    }

    /// The food of changed settings, if it is other food. What stays where it is keeps what is left of it.
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
        // Other owners of the setup keep theirs.
        Arc::make_mut(&mut self.course.setup).food_set = served.food_set;
        self.state.food = served.buffers;
    }

    /// The food of a snapshot.
    pub(super) fn restored_food(&self, food: &FoodState) -> Result<Option<FoodBuffers>> {
        let food_set = &self.setup().food_set;
        let meals = food_set.meals(Some(&food.remaining));
        let buffers = (!food_set.is_empty()).then(|| FoodBuffers::new(&self.ctx, food_set, &meals));
        Ok(buffers.transpose()?)
    }

    /// Meals left of each food, copied to the host like [`snapshot`](Self::snapshot); always 1 for markers and for
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
