//! Fields on the surface besides the trail: edges, density, distances and nearest objects.

use super::{Renderer, Shot};
use crate::gpu::PassRecorder;
use crate::scene::settings::Show;
use crate::sim::draws::{FieldsArgs, FieldsParams};

/// The field that the shader shows: `FIELD_...` in `shaders/fields.frag`.
#[derive(Clone, Copy)]
pub(super) enum Field {
    Wireframe = 0,
    Density = 1,
    Distance = 2,
    Nearest = 3,
}

impl Field {
    /// The field of a view; `None` where it shows the lit surface or the atlas.
    pub(super) fn of(show: Show) -> Option<Self> {
        Some(match show {
            Show::Wireframe => Self::Wireframe,
            Show::Density => Self::Density,
            Show::Distance => Self::Distance,
            Show::Nearest => Self::Nearest,
            _ => return None,
        })
    }
}

impl Renderer {
    /// Draws the surface in the colours of a field.
    pub(super) fn draw_fields(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>, field: Field) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let camera = &view.camera;
        pass.draw(
            shot.pipelines.fields.of(shot.fronts_only),
            self.shape.corner_count,
            1,
            FieldsArgs {
                corners: &state.surface.corners,
                vertices: &state.surface.vertices,
                normals: &self.normals,
                openness: &self.openness,
                strips: &state.surface.strips,
                poses: &state.objects.poses.texels,
                trail: &state.trail.front,
                colors: &self.colors,
                brightest: &self.brightest,
                deposits: &state.deposits.back,
                density: &state.atlas.spread.density,
                distances: &state.near.distances,
                nearest: &state.near.nearest,
                object_colors: &self.object_colors,
            },
            FieldsParams {
                clip_from_world: camera.clip_from_world(size),
                eye: camera.eye(),
                field: field as u32,
                key_direction: view.light.direction(camera),
                occlusion: view.occlusion,
                size: self.shape.size,
                pitch: self.shape.pitch,
                reach: state.near.reach,
                usual: self.shape.usual_count as f32 / self.shape.owned_count.max(1) as f32,
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that fields have equal numbers here and in the shader, and the names of their views.
    #[test]
    fn the_shader_has_the_numbers_of_fields() {
        let shader = include_str!("../../../shaders/fields.frag");
        for show in Show::ALL {
            if let Some(field) = Field::of(*show) {
                let (name, number) = (show.word().to_uppercase(), field as u32);
                let constant = format!("const uint FIELD_{name} = {number}u;");
                assert!(shader.contains(&constant), "{constant}");
            }
        }
    }
}
