//! Particles as points of light, in the order of their ids.

use glam::Vec2;

use super::{Renderer, Shot, world_per_pixel};
use crate::gpu::{Access, PassRecorder, Recorder, Threads};
use crate::render::colormap::ground;
use crate::render::draw_order;
use crate::render::view::View;
use crate::scene::settings::Show;
use crate::sim::State;
use crate::sim::draws::{ParticlesArgs, ParticlesParams};
use crate::sim::kernels::{DrawOrderArgs, DrawOrderParams};

impl Renderer {
    /// Records the kernels before the pass that draws them.
    pub(super) fn order_particles(&self, rec: &mut Recorder, state: &State, view: &View) {
        rec.dispatch(
            &self.draw_order,
            Threads(self.shape.particle_count),
            DrawOrderArgs {
                particles: &state.particles.texels,
                order: &self.order,
            },
            DrawOrderParams {
                particle_count: self.shape.particle_count,
                stride: self.particle_stride(view),
            },
        );
        rec.make_visible(Access::Vertex, &[&self.order]);
    }

    pub(super) fn draw_particles(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let camera = &view.camera;
        let drawn = self.particles_drawn(view);
        let is_hued = view.show == Show::Headings;
        let pipeline = match is_hued {
            true => &shot.pipelines.headings,
            false => &shot.pipelines.particles,
        };
        pass.draw(
            pipeline,
            drawn,
            1,
            ParticlesArgs {
                particles: &state.particles.texels,
                corners: &state.surface.corners,
                vertices: &state.surface.vertices,
                poses: &state.objects.poses.texels,
                colors: &self.colors,
                motions: &state.motions.texels,
                order: &self.order,
            },
            ParticlesParams {
                clip_from_world: camera.clip_from_world(size),
                eye: camera.eye(),
                lift: 0.003 * self.shape.radius
                    + view.particle_size * world_per_pixel(camera, size),
                diameter: view.particle_size.max(1.0),
                strength: strength(
                    drawn.min(self.shape.usual_count),
                    self.shape.radius,
                    view,
                    size,
                ),
                hued: u32::from(is_hued),
                ground: ground(view.darkest),
                mortal: u32::from(state.growth.is_some()),
            },
        );
    }

    /// How many particles a picture with this view has, if it shows particles; dead ones count, but are not seen.
    #[must_use]
    pub fn particles_drawn(&self, view: &View) -> u32 {
        draw_order::drawn(self.shape.particle_count, self.particle_stride(view))
    }

    fn particle_stride(&self, view: &View) -> u32 {
        // At most as many as a storage block can list.
        let most = view.most_particles.min(self.order.len() as u32);
        draw_order::stride(self.shape.particle_count, most)
    }
}

/// The light of one point, such that usual densities are bright but not overexposed.
fn strength(drawn: u32, radius: f32, view: &View, size: Vec2) -> f32 {
    let radius_in_pixels = radius / world_per_pixel(&view.camera, size);
    let area = (std::f32::consts::PI * radius_in_pixels * radius_in_pixels).max(1.0);
    light_of_size(drawn as f32, area, view.particle_size)
}

/// The light of a point of this size in pixels, if so many are on an area of so many pixels. Points are drawn no smaller than a pixel:
/// finer ones have as much less light as their area is smaller.
fn light_of_size(drawn: f32, area: f32, size: f32) -> f32 {
    let diameter = size.max(1.0);
    // Half of the particles are on the far side.
    let points_in_a_pixel = 0.5 * drawn * diameter * diameter / area;
    let part = size / diameter;
    (0.18 / points_in_a_pixel.max(1e-6)).clamp(0.03, 0.8) * (part * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: points finer than a pixel that are as bright as those of a pixel, or brighter.
    #[test]
    fn finer_points_are_dimmer() {
        for drawn in [0.02, 1.0, 40.0] {
            let whole = light_of_size(drawn, 1.0, 1.0);
            let quarter = light_of_size(drawn, 1.0, 0.5);
            assert!((quarter - 0.25 * whole).abs() < 1e-6, "{quarter}, {whole}");
        }
        let (one, two) = (light_of_size(2.0, 1.0, 1.0), light_of_size(2.0, 1.0, 2.0));
        assert!((one - 0.18).abs() < 1e-6 && (two - 0.045).abs() < 1e-6);
    }
}
