//! Food and markers of the running simulation: put there, taken away, and what is left of them.

use std::sync::Arc;

use super::super::food::buffers::FoodBuffers;
use super::super::food::{FoodPlace, Pantry, places};
use super::super::snapshot::FoodState;
use super::Simulation;
use crate::error::{Error, Result};
use crate::scene::foods;
use crate::scene::settings::Settings;

/// Food that takes the place of what there is.
pub(super) struct Served {
    pantry: Pantry,
    buffers: Option<FoodBuffers>,
}

impl Simulation {
    /// The food of changed settings, if it is other food. What stays where it is keeps what is left of it.
    pub(super) fn served(&self, settings: &Settings) -> Result<Option<Served>> {
        if settings.foods == self.settings.foods && settings.feeding == self.settings.feeding {
            return Ok(None);
        }
        if let [problem, ..] = &foods::problems(settings)[..] {
            return Err(Error::Invalid(problem.clone()));
        }
        let setup = &self.setup;
        let places = places(settings, &setup.surface, setup.radius)?;
        if places == setup.pantry.places {
            return Ok(None);
        }
        let pantry = Pantry::new(&setup.surface, &setup.atlas, places, Some(&setup.pantry))?;
        let left = pantry.kept(&setup.pantry, &self.remaining()?);
        let buffers = self.buffers_of(&pantry, &left)?;
        Ok(Some(Served { pantry, buffers }))
    }

    /// Lets it be there from the next step on.
    pub(super) fn serve(&mut self, served: Served) {
        // Others who look at the setup keep the one that they have.
        Arc::make_mut(&mut self.setup).pantry = served.pantry;
        self.state.food = served.buffers;
    }

    /// The food of a snapshot.
    pub(super) fn restored_food(&self, food: &FoodState) -> Result<Option<FoodBuffers>> {
        self.buffers_of(&self.setup.pantry, &food.remaining)
    }

    fn buffers_of(&self, pantry: &Pantry, left: &[u32]) -> Result<Option<FoodBuffers>> {
        if pantry.is_empty() {
            return Ok(None);
        }
        let meals = pantry.meals(Some(left));
        Ok(Some(FoodBuffers::new(&self.ctx, pantry, &meals)?))
    }

    /// What is left of each food, counted in meals, copied to the host like [`snapshot`](Self::snapshot); of markers and of
    /// food without end always 1.
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

    /// Where the foods and markers lie, first those that the settings name.
    #[must_use]
    pub fn food_places(&self) -> &[FoodPlace] {
        &self.setup.pantry.places
    }
}
