//! The lit surface with the trail on it.

use glam::Vec4;

use super::fields::Field;
use super::sides::Sides;
use super::{Renderer, Shot};
use crate::gpu::{Buffer, PassRecorder};
use crate::render::develop::Bloom;
use crate::scene::settings::{Part, Show};
use crate::sim::Texture;
use crate::sim::draws::{
    QuickSurfaceArgs, QuickSurfaceParams, SurfaceArgs, SurfaceDraw, SurfaceParams,
};

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
            // Colours that mean something must stay as they are.
            show if show.is_flat() || show == Show::Headings || Field::of(show).is_some() => Self {
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
        let (params, is_plain) = self.surface_params(shot);
        let pipelines = shot.pipelines;
        if let (true, Some(surface), Some(shared)) =
            (is_plain, &pipelines.quick_surface, &self.shared)
        {
            let state = shot.state;
            let args = QuickSurfaceArgs {
                shared_vertices: &shared.vertices,
                poses: &state.objects.poses.texels,
                trail: &state.trail.front,
                colors: &self.colors,
                brightest: &self.brightest,
                distances: &state.near.distances,
                clearance: &state.atlas.clearance,
            };
            let params = QuickSurfaceParams {
                clip_from_world: params.clip_from_world,
                eye: params.eye,
                trail_share: params.trail_share,
                key_direction: params.key_direction,
                glow: params.glow,
                size: params.size,
                pitch: params.pitch,
                lamp: params.lamp,
                occlusion: params.occlusion,
                relief: params.relief,
                wetness: params.wetness,
                reach: params.reach,
            };
            let surface = surface.of(shot.fronts_only);
            return pass.draw_indexed(surface, &shared.indices, args, params);
        }
        let surface = if is_plain {
            &pipelines.plain_surface
        } else {
            &pipelines.surface
        };
        // Only the second look reads weights.
        self.draw_corners(
            pass,
            shot,
            (surface, &self.colors, &shot.state.trail.front),
            params,
        );
    }

    /// The second look in its own colours, over the first by its weight at each place.
    pub(super) fn draw_second_look(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let (Some(looks), Some(_)) = (&shot.state.looks, shot.view.second_colors) else {
            return;
        };
        let (params, is_plain) = self.surface_params(shot);
        let surface = &shot.pipelines.second_looks[usize::from(!is_plain)];
        self.draw_corners(pass, shot, (surface, &self.second_colors, looks), params);
    }

    fn draw_corners(
        &self,
        pass: &mut PassRecorder<'_>,
        shot: &Shot<'_>,
        (surface, colors, looks): (&Sides<SurfaceDraw>, &Buffer<Vec4>, &Texture<f32>),
        params: SurfaceParams,
    ) {
        let state = shot.state;
        let args = SurfaceArgs {
            corners: &state.surface.corners,
            vertices: &state.surface.vertices,
            normals: &self.normals,
            openness: &self.openness,
            strips: &state.surface.strips,
            poses: &state.objects.poses.texels,
            trail: &state.trail.front,
            colors,
            brightest: &self.brightest,
            charts: &self.charts,
            distances: &state.near.distances,
            looks,
        };
        let surface = surface.of(shot.fronts_only);
        pass.draw(surface, self.shape.corner_count, 1, args, params);
    }

    /// What the surface is drawn with, and whether it has neither relief nor charts.
    fn surface_params(&self, shot: &Shot<'_>) -> (SurfaceParams, bool) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let (trail_share, chart_share) = match view.show {
            // Points must stand out from the bare surface.
            show if show.has(Part::Points) => (0.0, view.charts_under_trail()),
            Show::Charts => (0.0, 1.0),
            _ => (view.trail_over_charts(), view.charts_under_trail()),
        };
        let lighting = &shot.lighting;
        let is_plain = lighting.relief == 0.0 && chart_share == 0.0;
        let height = match is_plain {
            true => lighting.height * view.wetness,
            false => lighting.relief,
        };
        let params = SurfaceParams {
            clip_from_world: view.camera.clip_from_world(size),
            eye: view.camera.eye(),
            trail_share,
            key_direction: view.light.direction(&view.camera),
            glow: lighting.glow,
            size: self.shape.size,
            pitch: self.shape.pitch,
            chart_share,
            relief: height * self.shape.radius,
            lamp: lighting.lamp,
            occlusion: view.occlusion,
            wetness: view.wetness,
            reach: state.near.reach,
        };
        (params, is_plain)
    }
}
