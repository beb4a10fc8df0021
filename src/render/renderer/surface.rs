//! The lit surface with the trail on it.

use super::fields::Field;
use super::{Renderer, Shot};
use crate::gpu::PassRecorder;
use crate::render::develop::Bloom;
use crate::scene::settings::{Part, Show};
use crate::sim::draws::{QuickSurfaceArgs, QuickSurfaceParams, SurfaceArgs, SurfaceParams};

/// The lighting of a view.
#[derive(Clone, Copy)]
pub(super) struct Lighting {
    /// Share of the usual light on surfaces and food.
    pub lamp: f32,
    /// Share of it that the background emits.
    pub background: f32,
    /// Light that the trail emits, as a share of its colour.
    glow: f32,
    /// Light that food emits, as a share of its colour.
    pub food_glow: f32,
    /// Height of the brightest trail as a relief, scene radii.
    relief: f32,
    /// Height of the brightest trail on a wet surface, scene radii.
    height: f32,
    /// Light that blooms, if any does, and how much for each unit of the view's bloom.
    bloom: Option<Bloom>,
}

impl Lighting {
    const USUAL: Self = Self {
        lamp: 1.0,
        background: 1.0,
        glow: 0.34,
        food_glow: 0.0,
        relief: 0.0,
        height: 0.014,
        bloom: Some(Bloom {
            threshold: 0.30,
            slope: 1.6,
            strength: 0.24,
        }),
    };

    /// The bloom of a view with this lighting.
    pub(super) fn bloom(&self, share: f32) -> Option<Bloom> {
        let bloom = self.bloom.filter(|_| share > 0.0)?;
        Some(Bloom {
            strength: bloom.strength * share,
            ..bloom
        })
    }

    pub(super) fn of(show: Show) -> Self {
        match show {
            Show::Glow => Self {
                lamp: 0.10,
                background: 0.25,
                glow: 1.25,
                food_glow: 0.22,
                bloom: Some(Bloom {
                    threshold: 0.02,
                    slope: 2.5,
                    strength: 0.9,
                }),
                ..Self::USUAL
            },
            Show::Relief => Self {
                // Shading must be visible on it.
                glow: 0.05,
                relief: 0.03,
                ..Self::USUAL
            },
            show if show.is_flat() || Field::of(show).is_some() => Self {
                bloom: None,
                ..Self::USUAL
            },
            _ => Self::USUAL,
        }
    }
}

impl Renderer {
    /// Every object, lit, with the trail on it.
    pub(super) fn draw_surface(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let camera = &view.camera;
        let (trail_share, chart_share) = match view.show {
            // Points must stand out from the bare surface.
            show if show.has(Part::Points) => (0.0, view.charts_under_trail()),
            Show::Charts => (0.0, 1.0),
            _ => (view.trail_over_charts(), view.charts_under_trail()),
        };
        let Lighting { lamp, glow, .. } = shot.lighting;
        let is_plain = shot.lighting.relief == 0.0 && chart_share == 0.0;
        let height = match is_plain {
            true => shot.lighting.height * view.wetness,
            false => shot.lighting.relief,
        };
        let relief = height * self.shape.radius;
        let (clip_from_world, eye) = (camera.clip_from_world(size), camera.eye());
        let key_direction = view.light.direction(camera);
        let pipelines = shot.pipelines;
        if let (true, Some(surface), Some(shared)) =
            (is_plain, &pipelines.quick_surface, &self.shared)
        {
            pass.draw_indexed(
                surface.of(shot.fronts_only),
                &shared.indices,
                QuickSurfaceArgs {
                    shared_vertices: &shared.vertices,
                    poses: &state.objects.poses.texels,
                    trail: &state.trail.front,
                    colors: &self.colors,
                    brightest: &self.brightest,
                    distances: &state.near.distances,
                    clearance: &state.atlas.clearance,
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
                    relief,
                    wetness: view.wetness,
                    reach: state.near.reach,
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
                corners: &state.surface.corners,
                vertices: &state.surface.vertices,
                normals: &self.normals,
                openness: &self.openness,
                strips: &state.surface.strips,
                poses: &state.objects.poses.texels,
                trail: &state.trail.front,
                colors: &self.colors,
                brightest: &self.brightest,
                charts: &self.charts,
                distances: &state.near.distances,
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
                wetness: view.wetness,
                reach: state.near.reach,
            },
        );
    }
}
