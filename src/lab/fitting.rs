//! The camera is kept where the scene fits into the free part of the picture, until the user moves it.

use glam::Vec3;
use myxo::render::Camera;
use myxo::render::view::{AtlasWindow, margins};

use crate::lab::document::{Document, Room};

/// Brings these points into the middle of the free part of the picture.
fn fit(camera: &mut Camera, points: impl IntoIterator<Item = Vec3>, room: Room) {
    let [left, above, right, below] = margins(room.size);
    let margins = [left, above, right + room.covered, below];
    camera.fit_centered(points, room.size, margins);
}

impl Document {
    /// Looks at the whole scene, or at the whole atlas.
    pub(super) fn fit(&mut self) {
        if self.view.show.is_flat() {
            self.view.atlas = AtlasWindow::default();
        } else {
            self.view.camera.target = self.outline.0;
            self.refit();
        }
    }

    /// Brings the camera to where the scene's own stands.
    pub(super) fn go_home(&mut self) {
        self.view.camera = self.home;
        if self.loaded.camera.distance <= 0.0 {
            self.refit();
        }
    }

    /// Fits the scene into the picture from the present direction, and keeps it fitted.
    pub(super) fn refit(&mut self) {
        self.fitted = Some((self.view.camera, Room::default()));
    }

    /// Another field of view fits from elsewhere.
    pub(super) fn fit_again(&mut self, fits: bool) {
        if fits && !self.is_fitted() {
            self.refit();
        }
    }

    /// A camera that shows the whole scene is to show it from every side of a turn.
    pub(super) fn stand_back(&self, camera: &mut Camera, size: [u32; 2]) {
        if self.is_fitted() {
            let size = glam::UVec2::from_array(size).as_vec2();
            camera.fit_all_round(self.outline.1.iter().copied(), size);
        }
    }

    /// Looks at these places from the present direction.
    pub(super) fn frame(&mut self, places: Vec<Vec3>, room: Room) {
        if places.is_empty() {
            return;
        }
        let low = places.iter().copied().fold(Vec3::MAX, Vec3::min);
        let high = places.iter().copied().fold(Vec3::MIN, Vec3::max);
        self.view.camera.target = low.midpoint(high);
        fit(&mut self.view.camera, places, room);
    }

    /// Is the camera where the last fit has put it?
    pub(super) fn is_fitted(&self) -> bool {
        { self.fitted }.is_some_and(|(fitted, _)| fitted == self.view.camera)
    }

    /// Fits the scene into a picture that has another size or is covered otherwise, if the camera still is where the last fit has put it.
    /// An object that has come, with these vertices, is brought into the picture in any case.
    pub(super) fn keep_fitting(&mut self, room: Room, newcomer: Vec<Vec3>, is_flying: bool) {
        if self.is_fitted() && !newcomer.is_empty() {
            self.view.camera.target = self.outline.0;
            self.refit();
        } else if !is_flying {
            let mut wide = self.view.camera;
            wide.fit_points(newcomer, room.size);
            let distance = &mut self.view.camera.distance;
            *distance = distance.max(wide.distance);
        }
        if (self.fitted).is_some_and(|(fitted, last)| fitted == self.view.camera && last != room) {
            let points = self.outline.1.iter().copied();
            let camera = &mut self.view.camera;
            fit(camera, points, room);
            self.fitted = Some((*camera, room));
        }
    }
}
