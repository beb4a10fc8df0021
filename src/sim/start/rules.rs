//! Rules of starts from a scene's settings.

use glam::{DVec3, Vec3};

use super::mask::{Mask, MaskTable};
use super::{StartHeading, StartPlace, StartRule, Starts, nearest_point};
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::scene::Scene;
use crate::scene::settings::{Heading, Start, StartSettings};
use crate::sim::food::FoodPlace;

/// The pictures of a scene's start rules: the scene's, and one for each object.
#[derive(Clone, Debug)]
pub struct Masks {
    scene: Option<Mask>,
    own: Vec<Option<Mask>>,
}

impl Masks {
    /// Reads them.
    ///
    /// # Errors
    /// When one cannot be read, or is not a picture.
    pub fn open(scene: &Scene) -> Result<Self> {
        let open = |start: &StartSettings<'_>| -> Result<Option<Mask>> {
            match start.place {
                Start::Mask => {
                    let path = scene.folder.join(start.mask);
                    Mask::open(&path, scene.settings.atlas.size).map(Some)
                }
                _ => Ok(None),
            }
        };
        let (scenes, own) = scene.settings.starts();
        let own = own.iter().map(|start| match start {
            Some(start) => open(start),
            None => Ok(None),
        });
        Ok(Self {
            scene: open(&scenes)?,
            own: own.collect::<Result<_>>()?,
        })
    }
}

impl Starts {
    /// The rules of a scene's settings.
    ///
    /// # Errors
    /// When a mask is black at all places where particles could begin, or has too many pixels for so many triangles.
    pub fn of(scene: &Scene, atlas: &Atlas, masks: &Masks, foods: &[FoodPlace]) -> Result<Self> {
        let (scenes, own) = scene.settings.starts();
        let own = own.iter().zip(&masks.own).map(|(start, mask)| {
            let start = start.as_ref();
            start
                .map(|start| rule(scene, atlas, start, mask.as_ref(), foods))
                .transpose()
        });
        Ok(Self {
            scene: rule(scene, atlas, &scenes, masks.scene.as_ref(), foods)?,
            own: own.collect::<Result<_>>()?,
            shares: scene.settings.start_shares(),
        })
    }
}

fn rule(
    scene: &Scene,
    atlas: &Atlas,
    start: &StartSettings<'_>,
    mask: Option<&Mask>,
    foods: &[FoodPlace],
) -> Result<StartRule> {
    let surface = &scene.surface;
    let object = start.object.map(|object| object as u32);
    let poses = scene.world_from_object();
    let place = scene.center + scene.radius * Vec3::from_array(start.at);
    let places: Vec<Vec3> = poses
        .iter()
        .map(|world_from_object| world_from_object.inverse().transform_point3(place))
        .collect();
    let centre = || nearest_point(surface, &places, object);
    let radius = f64::from(start.radius * scene.radius);
    let far = || places.iter().map(|place| place.as_dvec3()).collect();
    let along = || {
        let direction = Vec3::from_array(start.direction);
        let turned = poses.iter().map(|world_from_object| {
            let inverse = world_from_object.inverse();
            inverse.transform_vector3(direction).as_dvec3()
        });
        turned.collect::<Vec<DVec3>>()
    };
    Ok(StartRule {
        place: match (start.place, mask) {
            (Start::Mask, Some(mask)) => {
                StartPlace::Mask(MaskTable::new(mask, surface, atlas, object)?)
            }
            (Start::Uniform | Start::Mask, _) => StartPlace::Everywhere,
            (Start::Point, _) => StartPlace::Point(centre()),
            (Start::Ring, _) => StartPlace::Ring {
                centre: centre(),
                radius,
            },
            (Start::Disc, _) => StartPlace::Disc {
                centre: centre(),
                radius,
            },
            (Start::Food, _) => {
                let food = foods.get(scene.settings.particles.start_food as usize);
                let food = food.ok_or_else(|| {
                    Error::Invalid(
                        "there is no such food to begin on: see particles.start_food".to_owned(),
                    )
                })?;
                StartPlace::Disc {
                    centre: food.point,
                    radius: food.size,
                }
            }
        },
        object,
        heading: match start.heading {
            Heading::Auto => StartHeading::Auto,
            Heading::Random => StartHeading::Random,
            Heading::Aligned => StartHeading::Aligned(along()),
            Heading::Radial => StartHeading::Radial(far()),
            Heading::Inward => StartHeading::Inward(far()),
        },
    })
}
