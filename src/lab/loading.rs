//! What the window shows while a scene is being set up and there is nothing else to show.

use egui::{Align2, RichText, vec2};
use myxo::Result;
use myxo::gpu::{DepthTest, Frames, Swapchain, Targets};
use myxo::render::gui::Gui;
use winit::window::Window;

use super::theme;

/// A window that waits for a scene.
pub struct Loading<'a> {
    /// The scene's name.
    pub name: &'a str,
    /// The window and all that draws in it.
    pub window: &'a Window,
    /// Its input, which is passed over.
    pub egui: &'a mut egui_winit::State,
    pub gui: &'a mut Gui,
    pub swapchain: &'a mut Swapchain,
    pub frames: &'a mut Frames,
}

impl Loading<'_> {
    /// Shows one picture: what is being done, and a bar of how much of all is done, 0 to 1.
    pub fn show(&mut self, doing: &str, done: f32) -> Result<()> {
        let input = self.egui.take_egui_input(self.window);
        let context = self.egui.egui_ctx().clone();
        let output = context.run_ui(input, |ui| {
            egui::Area::new("loading".into())
                .anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0))
                .show(ui.ctx(), |ui| {
                    ui.set_width(320.0);
                    ui.label(RichText::new(self.name).heading());
                    ui.label(
                        RichText::new(format!("Making the atlas: {doing}")).color(theme::WEAK),
                    );
                    ui.add(
                        egui::ProgressBar::new(done)
                            .fill(theme::ACCENT)
                            .desired_height(4.0),
                    );
                });
        });
        self.gui.update_textures(output.textures_delta)?;
        let scale = output.pixels_per_point;
        let primitives = context.tessellate(output.shapes, scale);
        let mut rec = self.frames.begin()?;
        let Some(image) = self.swapchain.acquire()? else {
            return Ok(());
        };
        let target = self.swapchain.image(&image);
        let whole = Targets {
            color: target,
            resolve: None,
            depth: None,
            depth_test: DepthTest::Greatest,
            clear: Some([0.055, 0.06, 0.075, 1.0]),
        };
        let gui = &mut self.gui;
        rec.pass("loading", &whole, |pass| {
            gui.draw(pass, target.size(), scale, &primitives)
        })?;
        self.swapchain.present(self.frames, rec, image)?;
        Ok(())
    }
}
