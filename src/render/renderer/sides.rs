//! Back-face culling: back faces of solid objects are hidden by front faces, as long as the eye is outside. Devices that are CPUs draw
//! faster without them.

use std::sync::Arc;

use glam::{DAffine3, Vec2, Vec3};

use crate::gpu::{Context, Draw, GpuError, RasterOptions, RasterPipeline};
use crate::render::camera::Camera;
use crate::sim::types::Pose;

/// A pipeline in two forms.
pub(super) struct Sides<D> {
    both: RasterPipeline<D>,
    fronts: RasterPipeline<D>,
}

impl<D: Draw> Sides<D> {
    pub(super) fn new(
        ctx: &Arc<Context>,
        constants: &D::Constants,
        options: RasterOptions,
    ) -> Result<Self, GpuError> {
        let fronts = RasterOptions {
            cull_back_faces: true,
            ..options
        };
        Ok(Self {
            both: RasterPipeline::new(ctx, constants, options)?,
            fronts: RasterPipeline::new(ctx, constants, fronts)?,
        })
    }

    pub(super) fn of(&self, fronts_only: bool) -> &RasterPipeline<D> {
        if fronts_only {
            &self.fronts
        } else {
            &self.both
        }
    }
}

/// Does the camera see only the outside of solid objects? `boxes` are their bounding boxes, lowest and highest corners in object space.
pub(super) fn is_outside(camera: &Camera, size: Vec2, boxes: &[[Vec3; 2]], poses: &[Pose]) -> bool {
    // Points nearer than the near plane are not drawn, so the eye counts as being there.
    let margin = 1.01 * camera.near_corner(size);
    let eye = camera.eye().as_dvec3();
    boxes.iter().zip(poses).all(|(&[low, high], pose)| {
        let eye = DAffine3::from(pose)
            .inverse()
            .transform_point3(eye)
            .as_vec3();
        (eye - eye.clamp(low, high)).length() > margin
    })
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat};

    use super::*;

    #[test]
    fn an_eye_is_outside_of_boxes_where_objects_are_now() {
        let camera = Camera {
            target: Vec3::ZERO,
            distance: 3.0,
            ..Camera::default()
        };
        let eye = camera.eye();
        let size = Vec2::new(400.0, 100.0);
        let is_outside = |camera: &Camera, boxes: &[[Vec3; 2]], poses: &[Pose]| {
            super::is_outside(camera, size, boxes, poses)
        };
        let boxes = [[Vec3::splat(-1.0), Vec3::new(1.0, 1.0, 5.0)]];
        let at = |rotation, place| {
            [Pose::from(Affine3A::from_rotation_translation(
                rotation, place,
            ))]
        };
        assert!(is_outside(&camera, &boxes, &at(Quat::IDENTITY, 20.0 * eye)));
        assert!(!is_outside(&camera, &boxes, &at(Quat::IDENTITY, eye)));
        // Its far end rotates to the eye.
        let to_eye = Quat::from_rotation_arc(Vec3::Z, eye.normalize());
        assert!(!is_outside(&camera, &boxes, &at(to_eye, Vec3::ZERO)));
        assert!(is_outside(
            &camera,
            &boxes,
            &at(to_eye.inverse() * Quat::from_rotation_x(2.0), -eye)
        ));
        // Nearer than the near plane.
        let just_before = eye - (1.0 + 1.5 * camera.near()) * eye.normalize();
        let small = [[Vec3::splat(-1.0), Vec3::splat(1.0)]];
        let turned = at(to_eye, just_before);
        assert!(!is_outside(&camera, &small, &turned));
        assert!(is_outside(&camera, &[], &[]));
        // In the corners of a wide picture the near plane is farther from the eye.
        let wide = Camera {
            vertical_fov: 150_f32.to_radians(),
            ..camera
        };
        let beside = at(Quat::IDENTITY, eye + Vec3::Y * (1.0 + 10.0 * camera.near()));
        assert!(is_outside(&camera, &small, &beside));
        assert!(!is_outside(&wide, &small, &beside));
    }
}
