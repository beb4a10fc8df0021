//! The camera is kept where the scene fits into the picture, as long as nobody turns it elsewhere.

use glam::{Affine3A, Vec2, Vec3};
use myxo::render::Camera;
use myxo::render::view::AtlasWindow;

use super::interface::Interface;

impl Interface {
    /// Looks at the whole scene, or at the whole atlas.
    pub(super) fn fit(&mut self) {
        if self.document.view.show.is_flat() {
            self.document.view.atlas = AtlasWindow::default();
        } else {
            self.document.view.camera.target = self.outline.0;
            self.refit();
        }
    }

    /// Looks at the picked object where it is, or else at all.
    pub(super) fn frame_picked(&mut self, poses: &[Affine3A]) {
        let picked = self.hands.selected;
        let picked = picked.and_then(|i| Some((poses.get(i)?, self.hands.vertices.get(i)?)));
        match picked {
            Some((pose, own)) if !self.document.view.show.is_flat() => {
                let places = own.iter().map(|place| pose.transform_point3(*place));
                self.hands.framed = places.collect();
            }
            _ => self.fit(),
        }
    }

    /// Fits the scene into the picture from the present direction, and keeps it fitted.
    pub(super) fn refit(&mut self) {
        self.fitted = Some((self.document.view.camera, Vec2::ZERO));
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

    /// Is the camera where the last fit has put it?
    pub(super) fn is_fitted(&self) -> bool {
        { self.fitted }.is_some_and(|(fitted, _)| fitted == self.document.view.camera)
    }

    /// Fits the scene into a picture of another size, if the camera still is where the last fit has put it. An object that
    /// has come is brought into the picture in any case.
    pub(super) fn keep_fitting(&mut self, size: Vec2) {
        let newcomer = std::mem::take(&mut self.hands.newcomer);
        if self.is_fitted() && !newcomer.is_empty() {
            self.document.view.camera.target = self.outline.0;
            self.refit();
        } else if !self.navigation.is_flying() {
            let mut wide = self.document.view.camera;
            wide.fit_points(newcomer, size);
            let distance = &mut self.document.view.camera.distance;
            *distance = distance.max(wide.distance);
        }
        let framed = std::mem::take(&mut self.hands.framed);
        if !framed.is_empty() {
            let low = framed.iter().copied().fold(Vec3::MAX, Vec3::min);
            let high = framed.iter().copied().fold(Vec3::MIN, Vec3::max);
            self.document.view.camera.target = low.midpoint(high);
            self.document.view.camera.fit_points(framed, size);
        }
        let camera = &mut self.document.view.camera;
        if self
            .fitted
            .is_some_and(|(fitted, fitted_size)| fitted == *camera && fitted_size != size)
        {
            camera.fit_points(self.outline.1.iter().copied(), size);
            self.fitted = Some((*camera, size));
        }
    }
}
