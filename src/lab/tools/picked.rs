//! The selection: an object that is there, or one that was asked for and is picked when it comes.

use glam::Affine3A;

use crate::lab::actions::PICK_FIRST;
use crate::lab::command::{Command, Ticket, ToolRequest, Which};
use crate::lab::desk::Desk;
use crate::lab::tools::{Tool, Tools};

impl Tools {
    /// The object that is picked.
    pub fn picked(&self) -> Option<Which> {
        let asked = self.awaited.map(Which::Asked);
        asked.or(self.selected.map(Which::Object))
    }

    /// An object is picked, or none.
    pub fn pick(&mut self, object: Option<usize>) {
        self.selected = object;
        self.awaited = None;
    }

    /// Lets the camera show the picked object; returns false if none is picked.
    pub fn frame_picked(&mut self, poses: &[Affine3A]) -> bool {
        let picked = self.selected;
        let picked = picked.and_then(|i| Some((poses.get(i)?, self.vertices.get(i)?)));
        let Some((pose, own)) = picked else {
            return false;
        };
        let places = own.iter().map(|place| pose.transform_point3(*place));
        self.framed = places.collect();
        true
    }

    /// For an object that is asked for; it is picked from now on, and shown so when it comes.
    pub fn ask(&mut self) -> Ticket {
        self.asked.0 += 1;
        self.pick(None);
        self.awaited = Some(self.asked);
        self.asked
    }

    /// An object that was asked for is there, in this place, or does not come.
    pub fn answer(&mut self, ticket: Ticket, place: Option<usize>) {
        if self.awaited == Some(ticket) {
            self.pick(place);
        }
    }
}

impl Tools {
    /// The picked object goes, unless it is the last one.
    pub(in super::super) fn remove_selected(&mut self, ctx: &egui::Context, desk: &mut Desk<'_>) {
        if self.tool == Tool::Food {
            return self.remove_food(ctx, desk);
        }
        let Some(which) = self.picked() else {
            desk.notices.say(ctx, PICK_FIRST, false);
            return;
        };
        if let Which::Object(object) = which
            && desk.document.marks.is_locked(object)
        {
            let name = &desk.document.edited.objects[object].name;
            let text = format!("{name} is locked: free it in the list of objects first");
            desk.notices.say(ctx, text, false);
            return;
        }
        let is_there = matches!(which, Which::Object(_));
        if is_there && desk.document.running.objects.len() < 2 {
            let text = "The last object stays: a scene has at least one. Add another one first";
            desk.notices.say(ctx, text, false);
            return;
        }
        self.pick(None);
        desk.commands
            .push(Command::Tool(ToolRequest::Remove(which)));
    }

    /// The picked object is hidden, and picked no longer.
    pub(in super::super) fn hide_selected(&mut self, ctx: &egui::Context, desk: &mut Desk<'_>) {
        match self.selected {
            Some(object) => {
                desk.document.marks.hide(object, true);
                self.pick(None);
            }
            None => desk.notices.say(ctx, PICK_FIRST, false),
        }
    }

    /// Duplicates the picked object. The next keys apply to the copy, also before it has arrived.
    pub(in super::super) fn duplicate_selected(
        &mut self,
        ctx: &egui::Context,
        desk: &mut Desk<'_>,
    ) {
        let Some(which) = self.picked() else {
            desk.notices.say(ctx, PICK_FIRST, false);
            return;
        };
        let ticket = self.ask();
        desk.commands
            .push(Command::Tool(ToolRequest::Duplicate(which, ticket)));
    }
}
