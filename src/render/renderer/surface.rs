//! The lit surface with the trail on it.

use super::{Renderer, Shot};
use crate::gpu::PassRecorder;
use crate::scene::settings::Show;
use crate::sim::draws::{QuickSurfaceArgs, QuickSurfaceParams, SurfaceArgs, SurfaceParams};

/// Light that the trail sends out itself, as a share of its colour.
const GLOW: f32 = 0.34;
/// The same where the trail is the only light, and what is left of the other light then.
const GLOW_ALONE: f32 = 1.25;
pub(super) const LAMP_BESIDE_GLOW: f32 = 0.10;
/// How high the brightest trail stands as a relief, scene radii.
const RELIEF: f32 = 0.03;
/// What the trail sends out itself there: shadows on it must be seen.
const GLOW_OF_RELIEF: f32 = 0.05;

impl Renderer {
    /// Every object, lit, with the trail on it.
    pub(super) fn draw_surface(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let camera = &view.camera;
        let (trail_share, chart_share) = match view.show {
            // Points stand out from what is bare.
            Show::Particles | Show::Headings => (0.0, view.charts_under_trail()),
            Show::Charts => (0.0, 1.0),
            _ => (view.trail_over_charts(), view.charts_under_trail()),
        };
        let (lamp, glow) = match view.show {
            Show::Glow => (LAMP_BESIDE_GLOW, GLOW_ALONE),
            Show::Relief => (1.0, GLOW_OF_RELIEF),
            _ => (1.0, GLOW),
        };
        let relief = match view.show {
            Show::Relief => RELIEF * self.shape.radius,
            _ => 0.0,
        };
        let (clip_from_world, eye) = (camera.clip_from_world(size), camera.eye());
        let key_direction = view.light.direction(camera);
        let pipelines = shot.pipelines;
        let is_plain = relief == 0.0 && chart_share == 0.0;
        if let (true, Some(surface), Some(shared)) =
            (is_plain, &pipelines.quick_surface, &self.shared)
        {
            pass.draw_indexed(
                surface.of(shot.fronts_only),
                &shared.indices,
                QuickSurfaceArgs {
                    shared_vertices: &shared.vertices,
                    poses: &state.poses_view,
                    trail: &state.trail.front_views.texels,
                    colors: &self.colors,
                    brightest: &self.brightest,
                    distances: &state.distance_views.distances,
                    clearance: &state.clearance,
                },
                QuickSurfaceParams {
                    clip_from_world,
                    eye,
                    trail_share,
                    key_direction,
                    glow,
                    size: self.shape.size,
                    pitch: self.shape.pitch,
                    lamp,
                    occlusion: view.occlusion,
                    reach: state.reach,
                },
            );
            return;
        }
        let surface = if is_plain {
            &pipelines.plain_surface
        } else {
            &pipelines.surface
        };
        pass.draw(
            surface.of(shot.fronts_only),
            self.shape.corner_count,
            1,
            SurfaceArgs {
                corners: &state.corners,
                vertices: &state.vertices,
                normals: &self.normals,
                openness: &self.openness,
                strips: &state.strips,
                poses: &state.poses_view,
                trail: &state.trail.front_views.texels,
                colors: &self.colors,
                brightest: &self.brightest,
                charts: &self.charts,
                distances: &state.distance_views.distances,
            },
            SurfaceParams {
                clip_from_world,
                eye,
                trail_share,
                key_direction,
                glow,
                size: self.shape.size,
                pitch: self.shape.pitch,
                chart_share,
                relief,
                lamp,
                occlusion: view.occlusion,
                reach: state.reach,
            },
        );
    }
}
