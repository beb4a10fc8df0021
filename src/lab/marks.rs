//! Marks of objects: hidden in the picture, or locked against its tools. These marks belong to the window: no scene file has
//! them, and the simulation runs the same with and without them.

use myxo::scene::settings::ObjectSettings;

/// The marks of one object.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mark {
    /// Name and mesh together are which object it is.
    name: String,
    mesh: String,
    is_hidden: bool,
    is_locked: bool,
}

impl Mark {
    /// Is it a mark of this object?
    fn is_of(&self, object: &ObjectSettings) -> bool {
        self.name == object.name && self.mesh == object.mesh
    }
}

/// One mark for each object that is edited.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    all: Vec<Mark>,
}

/// The marks of running objects; objects beyond the end are neither hidden nor locked.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunningMarks {
    /// Not drawn, and not picked.
    pub hidden: Vec<bool>,
    /// Not picked, and not painted.
    pub locked: Vec<bool>,
}

impl RunningMarks {
    /// Is this object hidden?
    pub fn is_hidden(&self, object: usize) -> bool {
        self.hidden.get(object) == Some(&true)
    }

    /// Is it locked?
    pub fn is_locked(&self, object: usize) -> bool {
        self.locked.get(object) == Some(&true)
    }
}

impl Marks {
    /// Follows the objects as they are edited. A new object is not marked, also where it replaces another one, and a renamed one
    /// keeps its marks.
    pub fn follow(&mut self, objects: &[ObjectSettings]) {
        let are_as_many = objects.len() == self.all.len();
        let mut pairs = self.all.iter().zip(objects);
        if are_as_many && pairs.all(|(mark, object)| mark.is_of(object)) {
            return;
        }
        let followed = objects.iter().enumerate().map(|(i, object)| {
            let was = self.of(objects, i);
            Mark {
                name: object.name.clone(),
                mesh: object.mesh.clone(),
                is_hidden: was.is_some_and(|was| was.is_hidden),
                is_locked: was.is_some_and(|was| was.is_locked),
            }
        });
        self.all = followed.collect();
    }

    /// The mark of one of these objects: the one with its name and mesh. An object in the same place with the same mesh, of which
    /// no mark has the name, was renamed.
    fn of(&self, objects: &[ObjectSettings], place: usize) -> Option<&Mark> {
        let object = &objects[place];
        let by_name = self.all.iter().find(|mark| mark.is_of(object));
        let was_renamed =
            |mark: &&Mark| mark.mesh == object.mesh && !objects.iter().any(|one| mark.is_of(one));
        let are_as_many = objects.len() == self.all.len();
        let by_place = || self.all.get(place).filter(|_| are_as_many);
        by_name.or_else(|| by_place().filter(was_renamed))
    }

    /// The marks of objects that run, which may not have the names yet that are edited.
    pub fn of_running(&self, running: &[ObjectSettings]) -> RunningMarks {
        let marks = (0..running.len()).map(|place| self.of(running, place));
        let marks = marks.map(|mark| mark.map_or((false, false), |m| (m.is_hidden, m.is_locked)));
        let (hidden, locked) = marks.unzip();
        RunningMarks { hidden, locked }
    }

    /// Is this object hidden?
    pub fn is_hidden(&self, object: usize) -> bool {
        self.all.get(object).is_some_and(|mark| mark.is_hidden)
    }

    /// Is it locked?
    pub fn is_locked(&self, object: usize) -> bool {
        self.all.get(object).is_some_and(|mark| mark.is_locked)
    }

    /// Is any object hidden?
    pub fn any_is_hidden(&self) -> bool {
        self.all.iter().any(|mark| mark.is_hidden)
    }

    /// Hides an object, or shows it.
    pub fn hide(&mut self, object: usize, is_hidden: bool) {
        if let Some(mark) = self.all.get_mut(object) {
            mark.is_hidden = is_hidden;
        }
    }

    /// Locks an object, or frees it.
    pub fn lock(&mut self, object: usize, is_locked: bool) {
        if let Some(mark) = self.all.get_mut(object) {
            mark.is_locked = is_locked;
        }
    }

    /// Is this the only object that is shown, of several?
    pub fn is_isolated(&self, object: usize) -> bool {
        let mut marks = self.all.iter().enumerate();
        self.all.len() > 1 && marks.all(|(i, mark)| mark.is_hidden == (i != object))
    }

    /// Shows this object alone, or all if it is alone already.
    pub fn isolate(&mut self, object: usize) {
        let is_alone = self.is_isolated(object);
        for (i, mark) in self.all.iter_mut().enumerate() {
            mark.is_hidden = !is_alone && i != object;
        }
    }

    /// Hides none.
    pub fn show_all(&mut self) {
        self.all.iter_mut().for_each(|mark| mark.is_hidden = false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn objects(names: &[&str]) -> Vec<ObjectSettings> {
        let named = |name: &&str| ObjectSettings {
            name: (*name).to_owned(),
            ..ObjectSettings::default()
        };
        names.iter().map(named).collect()
    }

    #[test]
    fn marks_stay_with_their_objects() {
        let mut marks = Marks::default();
        marks.follow(&objects(&["a", "b", "c"]));
        marks.hide(1, true);
        marks.lock(2, true);
        // One goes, one comes, two change places, one gets another name.
        marks.follow(&objects(&["b", "c"]));
        assert!(marks.is_hidden(0) && marks.is_locked(1));
        marks.follow(&objects(&["b", "c", "d"]));
        assert!(!marks.is_hidden(2) && !marks.is_locked(2));
        marks.follow(&objects(&["c", "b", "d"]));
        assert!(marks.is_locked(0) && marks.is_hidden(1));
        marks.follow(&objects(&["c", "better", "d"]));
        assert!(marks.is_locked(0) && marks.is_hidden(1) && !marks.is_hidden(0));
        // The running objects still have their old names.
        let running = marks.of_running(&objects(&["c", "b", "d"]));
        assert_eq!(running.hidden, [false, true, false]);
        assert_eq!(running.locked, [true, false, false]);
        let fewer = marks.of_running(&objects(&["d", "c"]));
        assert_eq!(fewer.locked, [false, true]);
        assert!(!fewer.is_hidden(7) && !fewer.is_locked(7));
    }

    #[test]
    fn marks_do_not_jump_to_other_objects() {
        let with_mesh = |name: &str, mesh: &str| ObjectSettings {
            name: name.to_owned(),
            mesh: mesh.to_owned(),
            ..ObjectSettings::default()
        };
        let [ring, ball, knot] = ["ring", "ball", "knot"].map(|name| with_mesh(name, name));
        let mut marks = Marks::default();
        marks.follow(&[ring.clone(), ball.clone()]);
        marks.hide(1, true);
        // The other one goes.
        marks.follow(std::slice::from_ref(&ball));
        assert!(marks.is_hidden(0));
        marks.follow(&[ring.clone(), ball.clone()]);
        assert!(!marks.is_hidden(0) && marks.is_hidden(1));
        // Another object replaces the hidden one: under its own name, under that of the hidden one, and in another order.
        let of_that_name = with_mesh("ball", "knot");
        for replaced in [
            [ring.clone(), knot.clone()],
            [ring.clone(), of_that_name.clone()],
            [of_that_name, ring.clone()],
            [knot, ring.clone()],
        ] {
            let mut marks = marks.clone();
            let running = marks.of_running(&replaced);
            assert_eq!(running.hidden, [false, false], "until it runs");
            marks.follow(&replaced);
            assert!(!marks.any_is_hidden(), "{replaced:?}");
        }
        // Two that change names are still the two.
        let swapped = [with_mesh("ball", "ring"), with_mesh("ring", "ball")];
        marks.follow(&swapped);
        assert!(!marks.is_hidden(0) && marks.is_hidden(1));
    }

    #[test]
    fn one_is_shown_alone_and_all_again() {
        let mut marks = Marks::default();
        marks.follow(&objects(&["a", "b", "c"]));
        marks.hide(0, true);
        marks.isolate(0);
        assert!(marks.is_isolated(0) && !marks.is_hidden(0) && marks.is_hidden(1));
        marks.isolate(2);
        assert!(marks.is_isolated(2) && marks.is_hidden(0));
        marks.isolate(2);
        assert!(!marks.any_is_hidden());
        marks.hide(1, true);
        marks.show_all();
        assert!(!marks.any_is_hidden());
        // A single one is not alone among others.
        marks.follow(&objects(&["a"]));
        assert!(!marks.is_isolated(0));
    }
}
