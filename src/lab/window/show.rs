//! Frames: the interface, and under it a picture, a new one or the last one.

use crate::lab::place::Place;
use crate::lab::places::Places;
use crate::lab::screen::FrontImage;
use crate::lab::show::*;
use crate::lab::stage::Stage;
use crate::lab::window::Lab;
use myxo::gpu::{DepthTest, Recorder, Targets};
use myxo::{Error, Result};

/// Behind everything while there is no scene, as it is stored.
const EMPTY: [f32; 4] = [0.055, 0.06, 0.075, 1.0];

impl Lab {
    /// Shows the interface what came in.
    pub(super) fn run_interface(&mut self) -> Result<Seen> {
        let input = self.host.take_input();
        let is_asked = !input.events.is_empty();
        let facts = &self.clocks.facts;
        let (shown, output) = (self.interface).run(self.host.context(), input, facts);
        let repaint = output
            .viewport_output
            .get(&egui::ViewportId::ROOT)
            .map(|viewport| viewport.repaint_delay);
        self.host.take_output(output.platform_output, repaint);
        self.gui.update_textures(output.textures_delta)?;
        let primitives = match self.host.draws_interface() {
            true => {
                let context = self.host.context();
                context.tessellate(output.shapes, output.pixels_per_point)
            }
            false => Vec::new(),
        };
        let window = self.host.size();
        let place_of = |rect| Place::of(rect, output.pixels_per_point, window);
        Ok(Seen {
            picture: place_of(shown.picture),
            beside: shown.beside.map(place_of).filter(|place| !place.is_empty()),
            shown,
            primitives,
            pixels_per_point: output.pixels_per_point,
            repaint,
            is_asked,
        })
    }

    /// Draws the picture, or takes the last one, draws the interface over it, and shows both.
    pub(super) fn draw(&mut self, mut rec: Recorder, image: FrontImage, shot: Shot) -> Result<()> {
        let target = self.front.image(&image);
        let place = &shot.picture;
        let mut is_covered = false;
        if let Some(stage) = self.runner.stage.as_mut().filter(|_| !place.is_empty()) {
            stage.scales = self.interface.scales();
            let can_wait = self.jobs.exports.holds() || shot.answers;
            if shot.is_between {
                // The picture stays as it is.
            } else if can_wait && stage.shows(&shot.view, shot.sizes()) {
                if shot.answers {
                    self.runner.order.owe_picture();
                }
            } else if shot.refines && stage.has_picture(&shot.view, shot.sizes(), shot.is_moving) {
                stage.refine(&mut rec);
            } else {
                stage.draw(&mut rec, &shot.view, shot.sizes(), shot.is_moving)?;
            }
            let (picture, atlas) = stage.picture();
            Self::look_on(&mut self.jobs.exports, &mut rec, picture, stage.pictures)?;
            // A picture that was drawn for another place is shown in the middle of this one until the next is drawn.
            rec.copy_image_over(picture, target, place.corner, place.size);
            if let (Some(atlas), Some(place)) = (atlas, &shot.beside) {
                rec.copy_image_to(atlas, target, place.corner);
            }
            is_covered = true;
        }
        let network = self.clocks.facts.network.as_ref();
        let network = network.filter(|_| is_covered && self.interface.shows_network());
        let view = self.runner.stage.as_ref().and_then(Stage::picture_view);
        match network.zip(view) {
            None => self.lines.clear(),
            Some((found, view)) => {
                self.lines.follow(found, view);
                // An answer between slices is to be quick.
                if !shot.is_between {
                    self.lines.test_points();
                }
                if !shot.primitives.is_empty() {
                    self.lines.make(view, *place, shot.pixels_per_point);
                }
            }
        }
        let over = Targets {
            color: target,
            resolve: None,
            depth: None,
            depth_test: DepthTest::Greatest,
            clear: (!is_covered).then_some(EMPTY),
        };
        let gui = &mut self.gui;
        self.lines.draw_below(shot.primitives, |primitives| {
            rec.pass("interface", &over, |pass| {
                gui.draw(pass, target.size(), shot.pixels_per_point, primitives)
            })
        })?;
        let ring = if shot.is_between {
            &mut self.runner.answers
        } else {
            &mut self.runner.frames
        };
        self.host.will_present();
        self.front.present(ring, rec, image)?;
        self.clocks.presented();
        Ok(())
    }

    /// Reports to tests what the window shows now.
    pub(super) fn report_places(&mut self, pixels_per_point: f32, rests: bool) -> Result<()> {
        let Some(places) = &mut self.places else {
            return Ok(());
        };
        self.clocks.facts.drawn_colors = self.runner.stage.as_ref().and_then(Stage::colors);
        let is_typing = self.host.context().text_edit_focused();
        let state = (self.interface).state(&self.clocks.facts, is_typing);
        named(places.write(state, pixels_per_point, rests))
    }

    /// The contents of the window may change.
    pub(super) fn stir_places(&mut self) -> Result<bool> {
        named(self.places.as_mut().map_or(Ok(false), Places::stir))
    }

    /// The controls that this frame has named are not in the window.
    pub(super) fn forget_places(&mut self) {
        if let Some(places) = &mut self.places {
            places.forget();
        }
    }
}

/// Adds the option's name to an error in writing places.
fn named<T>(written: std::io::Result<T>) -> Result<T> {
    written.map_err(|error| Error::Invalid(format!("--places: {error}")))
}
