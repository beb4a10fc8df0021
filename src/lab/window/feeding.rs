//! Food that the window has changed, put into the running simulation when it is measured.

use crate::lab::feeding::*;
use crate::lab::lost::is_loss;
use crate::lab::window::Lab;
use myxo::Result;

impl Lab {
    /// Lets the food be there that is ready. What was refused goes back to what there is, and is said.
    pub(super) fn take_food(&mut self, context: &egui::Context) -> Result<()> {
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        let served = match self.feeder.take(&stage.simulation) {
            None => return Ok(()),
            Some(Fed::Ready(food)) => {
                let mut settings = stage.simulation.settings().clone();
                food.put_into(&mut settings);
                let asked = settings.clone();
                let served = stage.simulation.apply_with_food(&settings, *food);
                served.map_err(|error| (Box::new(asked), error))
            }
            Some(Fed::Refused(asked, error)) => Err((asked, error)),
        };
        // With the next device it is there.
        if let Err((_, error)) = &served
            && is_loss(error)
        {
            return served.map_err(|(_, error)| error);
        }
        // What was eaten and what lies there is drawn without a step.
        stage.forget_picture();
        let runs = stage.simulation.settings();
        self.interface
            .document
            .running
            .foods
            .clone_from(&runs.foods);
        self.interface.document.running.feeding = runs.feeding.clone();
        if let Err((refused, error)) = served {
            self.interface.food_is_refused(&refused);
            self.interface.notices.say(context, error.to_string(), true);
        }
        self.host.request_redraw();
        Ok(())
    }
}
