//! Single foods and markers, and a scene's settings for all food.

use serde::Serialize;

use super::Settings;

/// Foods and markers that a scene may have, scattered ones among them.
pub const MOST_FOODS: usize = 256;

/// `[[food]]`: a food, or with `size = 0` a marker, on the surface of an object, with which it moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoodSettings {
    /// The name of the object that it lies on; may be empty where there is only one.
    pub object: String,
    /// In the object's own coordinates, as its mesh has them: the nearest point of its surface is the place.
    pub at: [f64; 3],
    /// How far along the surface it is sensed, in scene radii.
    pub radius: f32,
    /// Trail units added to a sensor at its place; negative repels.
    pub strength: f32,
    /// Its meals; 0 is endless.
    pub amount: u32,
    /// How far along the surface it is eaten, in scene radii; 0 for a marker.
    pub size: f32,
    /// Trail units that each of its texels adds to the trail in a step, before the trail spreads; 0 for none.
    pub projection: f32,
}

impl Default for FoodSettings {
    fn default() -> Self {
        let FeedingSettings {
            radius,
            strength,
            amount,
            size,
            projection,
            ..
        } = FeedingSettings::default();
        Self {
            object: String::new(),
            at: [0.0; 3],
            radius,
            strength,
            amount,
            size,
            projection,
        }
    }
}

impl FoodSettings {
    /// Is it a marker, which particles don't eat?
    #[must_use]
    pub fn is_marker(&self) -> bool {
        self.size == 0.0
    }
}

/// `[feeding]`: food that is scattered over all objects, and the behaviour of particles that have eaten.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeedingSettings {
    /// How many foods are scattered besides those that have a `[[food]]` of their own.
    pub scattered: u32,
    /// As [`FoodSettings::radius`], of scattered ones.
    pub radius: f32,
    /// As [`FoodSettings::strength`].
    pub strength: f32,
    /// As [`FoodSettings::amount`].
    pub amount: u32,
    /// As [`FoodSettings::size`].
    pub size: f32,
    /// As [`FoodSettings::projection`].
    pub projection: f32,
    /// The share of its projection that a texel of any food keeps in steps in which particles deposit on it or on one of the eight beside
    /// it.
    pub projection_covered: f32,
    /// For how many steps a particle that has eaten is fed.
    pub fed_steps: u32,
    /// How many particles a fed one counts as where it deposits.
    pub fed_deposit: u32,
    /// Factor of fed particles on attraction by food and markers.
    pub fed_attraction: f32,
    /// The share of a scent that crosses from object to object where they touch; 0 for none.
    pub scent_across: f32,
}

impl Default for FeedingSettings {
    fn default() -> Self {
        Self {
            scattered: 0,
            radius: 0.5,
            strength: 20.0,
            amount: 0,
            size: 0.03,
            projection: 0.0,
            projection_covered: 1.0,
            fed_steps: 150,
            fed_deposit: 4,
            fed_attraction: 0.0,
            scent_across: 0.0,
        }
    }
}

impl Settings {
    /// The object that a food lies on, if there is one with that name.
    #[must_use]
    pub fn object_of(&self, food: &FoodSettings) -> Option<usize> {
        if food.object.is_empty() && self.objects.len() == 1 {
            return Some(0);
        }
        let mut objects = self.objects.iter();
        objects.position(|object| object.name == food.object)
    }

    /// All foods and markers, scattered ones among them.
    #[must_use]
    pub fn food_count(&self) -> usize {
        self.foods.len() + self.feeding.scattered as usize
    }

    /// Does the scent of food and markers cross from object to object?
    #[must_use]
    pub fn scent_crosses(&self) -> bool {
        self.feeding.scent_across > 0.0 && self.objects.len() > 1 && self.food_count() > 0
    }

    /// Is any food projected into the trail?
    #[must_use]
    pub fn projects(&self) -> bool {
        let is_scattered = self.feeding.scattered > 0 && self.feeding.projection > 0.0;
        is_scattered || self.foods.iter().any(|food| food.projection > 0.0)
    }
}
