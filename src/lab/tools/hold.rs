//! The pointer while a button is held, from every event of a frame: on a slow device one frame may have the press, a
//! long way and the release, and the pointer is elsewhere when it is shown.

use egui::{Event, PointerButton, Pos2, Response, Ui, Vec2};

/// From one corner of a way to the next at the least, points.
const STRIDE: f32 = 16.0;
/// A press that moves less than this is a click, points.
const CLICK: f32 = 6.0;

/// The state of a button that is held.
#[derive(Clone, Debug, Default)]
pub struct Hold {
    /// The last press; none if that was not for the picture.
    pressed: Option<Pos2>,
    /// The last position of the pointer while it is held.
    last: Option<Pos2>,
    /// It has gone farther than a click.
    is_drag: bool,
}

/// The events of the button in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Held {
    /// The place of the press.
    pub press: Option<Pos2>,
    /// The place of the release.
    pub release: Option<Pos2>,
    /// How far it was dragged, wherever; nothing while it may become a click.
    pub drag: Vec2,
    /// The pointer's ways over the picture while it was held.
    pub ways: Vec<Way>,
}

/// A part of a way over the picture; a pointer that rests has one of a single point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Way {
    pub points: Vec<Pos2>,
    /// It begins with the press.
    pub begins: bool,
    /// It ends with the release.
    pub ends: bool,
}

impl Way {
    /// How long it is, points.
    pub fn length(&self) -> f32 {
        let pairs = self.points.windows(2);
        pairs.map(|pair| pair[0].distance(pair[1])).sum()
    }

    /// Its corners, without those that follow too closely.
    pub fn corners(&self) -> Vec<Pos2> {
        let mut corners: Vec<Pos2> = Vec::new();
        for point in &self.points {
            if corners
                .last()
                .is_none_or(|last| last.distance(*point) >= STRIDE)
            {
                corners.push(*point);
            }
        }
        // The way ends at the pointer.
        corners.extend(self.points.last().filter(|end| corners.last() != Some(end)));
        corners
    }
}

impl Hold {
    /// The last press over the picture and for it.
    pub fn pressed(&self) -> Option<Pos2> {
        self.pressed
    }

    /// Has the pointer gone farther than a click since the press, whether the button is down or not?
    pub fn is_drag(&self) -> bool {
        self.is_drag
    }

    /// Is it held?
    pub fn is_down(&self) -> bool {
        self.last.is_some()
    }

    /// Takes in a frame over the picture, which `response` covers; a press `is_free` to mean it.
    pub fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        button: PointerButton,
        is_free: bool,
    ) -> Held {
        let (events, is_down) = ui.input(|i| {
            let is_down = i.pointer.button_down(button);
            (i.events.clone(), is_down)
        });
        let is_over = |at: Pos2| {
            let layer = ui.ctx().layer_id_at(at);
            response.rect.contains(at) && layer.is_none_or(|layer| layer == response.layer_id)
        };
        let held = self.take(&events, button, is_free, is_over);
        if !is_down {
            // Releases may be lost, with the window's focus.
            self.last = None;
        }
        held
    }

    fn take(
        &mut self,
        events: &[Event],
        wanted: PointerButton,
        is_free: bool,
        is_over: impl Fn(Pos2) -> bool,
    ) -> Held {
        let mut held = Held::default();
        let mut way = Way {
            points: self.last.filter(|at| is_over(*at)).into_iter().collect(),
            ..Way::default()
        };
        for event in events {
            match *event {
                Event::PointerButton {
                    pos,
                    button,
                    pressed: true,
                    ..
                } if button == wanted => {
                    self.is_drag = false;
                    held.push(std::mem::take(&mut way));
                    self.pressed = (is_free && is_over(pos)).then_some(pos);
                    self.last = self.pressed;
                    held.press = self.pressed;
                    way.points.extend(self.pressed);
                    way.begins = true;
                }
                Event::PointerMoved(pos) => {
                    let Some(last) = self.last.as_mut() else {
                        continue;
                    };
                    held.drag += pos - std::mem::replace(last, pos);
                    self.is_drag |= self.pressed.is_some_and(|at| at.distance(pos) > CLICK);
                    if is_over(pos) {
                        way.points.push(pos);
                    } else {
                        held.push(std::mem::take(&mut way));
                    }
                }
                Event::PointerButton {
                    pos,
                    button,
                    pressed: false,
                    ..
                } if button == wanted => {
                    let Some(last) = self.last.take() else {
                        continue;
                    };
                    held.drag += pos - last;
                    way.points.extend(Some(pos).filter(|at| is_over(*at)));
                    way.ends = true;
                    held.release = Some(pos);
                    held.push(std::mem::take(&mut way));
                }
                _ => {}
            }
        }
        held.push(way);
        if !self.is_drag {
            held.drag = Vec2::ZERO;
        }
        held
    }
}

impl Held {
    fn push(&mut self, way: Way) {
        if !way.points.is_empty() {
            self.ways.push(way);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Modifiers, pos2, vec2};

    const PRIMARY: PointerButton = PointerButton::Primary;

    fn button(x: f32, pressed: bool) -> Event {
        Event::PointerButton {
            pos: pos2(x, 0.0),
            button: PRIMARY,
            pressed,
            modifiers: Modifiers::NONE,
        }
    }

    fn moved(x: f32) -> Event {
        Event::PointerMoved(pos2(x, 0.0))
    }

    fn way(xs: &[f32], begins: bool, ends: bool) -> Way {
        Way {
            points: xs.iter().map(|x| pos2(*x, 0.0)).collect(),
            begins,
            ends,
        }
    }

    #[test]
    fn one_slow_frame_has_the_whole_way() {
        let mut hold = Hold::default();
        let events = [
            moved(-9.0),
            button(0.0, true),
            moved(30.0),
            moved(80.0),
            button(90.0, false),
            moved(500.0),
        ];
        let held = hold.take(&events, PRIMARY, true, |_| true);
        assert_eq!(held.press, Some(pos2(0.0, 0.0)));
        assert_eq!(held.release, Some(pos2(90.0, 0.0)));
        assert_eq!(held.ways, [way(&[0.0, 30.0, 80.0, 90.0], true, true)]);
        assert_eq!(held.ways[0].length(), 90.0);
        assert_eq!(held.drag, vec2(90.0, 0.0));
        assert!(!hold.is_down() && hold.pressed() == held.press);
        // Two clicks are two.
        let clicks = [true, false, true, false].map(|pressed| button(5.0, pressed));
        assert_eq!(
            hold.clone().take(&clicks, PRIMARY, true, |_| true).drag,
            Vec2::ZERO
        );
        assert_eq!(hold.take(&clicks, PRIMARY, true, |_| true).ways.len(), 2);
    }

    #[test]
    fn a_way_continues_from_frame_to_frame_and_stops_beside_the_picture() {
        let mut hold = Hold::default();
        let is_over = |at: Pos2| at.x < 100.0;
        let mut ways = |events: &[Event]| hold.take(events, PRIMARY, true, is_over).ways;
        assert_eq!(ways(&[button(0.0, true)]), [way(&[0.0], true, false)]);
        assert_eq!(ways(&[]), [way(&[0.0], false, false)], "it rests");
        let there_and_back = [moved(50.0), moved(120.0), moved(60.0)];
        assert_eq!(
            ways(&there_and_back),
            [way(&[0.0, 50.0], false, false), way(&[60.0], false, false)]
        );
        assert_eq!(
            ways(&[button(70.0, false)]),
            [way(&[60.0, 70.0], false, true)]
        );
        assert_eq!(ways(&[moved(80.0)]), []);
        // A press that begins elsewhere, or closes a list, is not for the picture.
        assert_eq!(ways(&[button(120.0, true), moved(60.0)]), []);
        assert_eq!(
            hold.take(&[button(9.0, true)], PRIMARY, false, is_over)
                .ways,
            []
        );
        assert_eq!(hold.pressed(), None);
    }

    #[test]
    fn corners_that_follow_closely_are_one() {
        let xs: Vec<f32> = (0..=50).map(|x| x as f32).collect();
        let corners = way(&xs, true, true).corners();
        let wanted = [0.0, 16.0, 32.0, 48.0, 50.0].map(|x| pos2(x, 0.0));
        assert_eq!(corners, wanted);
        assert_eq!(way(&[3.0, 3.0], true, true).corners(), [pos2(3.0, 0.0)]);
    }
}
