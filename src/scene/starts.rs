//! Checks of starts beyond the ranges of their keys.

use std::path::Path;

use super::BUILTIN;
use super::error::SceneError;
use super::problems::{Problem, listed};
use super::settings::{Heading, Settings, Start, StartSettings};

/// Makes the paths of masks and area maps absolute.
pub(super) fn from_everywhere(settings: &mut Settings, folder: &Path) {
    let objects = settings.objects.iter_mut();
    let masks = objects.map(|object| &mut object.start.mask);
    let scenes = [
        &mut settings.particles.start_mask,
        &mut settings.areas.map,
        &mut settings.second_look.map,
    ];
    for mask in masks.chain(scenes) {
        if !mask.is_empty() && !mask.starts_with(BUILTIN) {
            make_whole(mask, folder);
        }
    }
}

/// Makes a path relative to a folder absolute. A path through a name that is not Unicode is not changed, because a scene file cannot hold
/// it.
pub(super) fn make_whole(path: &mut String, folder: &Path) {
    let whole = folder.join(&*path);
    let whole = std::path::absolute(&whole).unwrap_or(whole);
    if let Some(text) = whole.to_str() {
        text.clone_into(path);
    }
}

/// Checks that starts have their inputs: an object of that name, a mask, a direction. Objects must have names.
pub(super) fn check(scene: &str, settings: &Settings) -> Result<(), SceneError> {
    let mut messages = Vec::new();
    let wanted = &settings.particles.start_object;
    let mut names = settings.objects.iter().map(|object| object.name.as_str());
    if !wanted.is_empty() && !names.clone().any(|name| name == wanted) {
        messages.push(format!(
            "particles.start_object: there is no object \"{wanted}\"; there is {}",
            listed(names.by_ref())
        ));
    }
    if settings.has_start_shares()
        && settings
            .objects
            .iter()
            .all(|object| object.start.share == 0.0)
    {
        messages.push(
            "object.N.start.share is 0 for every object, so no particle could begin: give one a share above 0"
                .to_owned(),
        );
    }
    let (scenes, own) = settings.starts();
    for start in own.into_iter().flatten().chain([scenes]) {
        let StartSettings {
            prefix,
            place,
            mask,
            heading,
            direction,
            ..
        } = start;
        if place == Start::Mask && mask.is_empty() {
            messages.push(format!(
                "{prefix}mask is empty: name the PNG that says where particles begin"
            ));
        }
        if heading == Heading::Aligned && direction == [0.0; 3] {
            messages.push(format!(
                "{prefix}direction = [0, 0, 0] is no direction to head in"
            ));
        }
    }
    SceneError::unless_empty(scene, messages.into_iter().map(Problem::from).collect())
}
