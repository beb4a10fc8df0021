//! Marks of objects: hidden in the picture, or locked against its tools. These marks belong to the window: no scene file has
//! them, and the simulation runs the same with and without them.

use myxo::scene::settings::ObjectSettings;

/// The marks of one object.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Mark {
    name: String,
    is_hidden: bool,
    is_locked: bool,
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
    /// Follows the objects as they are edited. A new object is not marked, and a renamed one keeps its marks.
    pub fn follow(&mut self, objects: &[ObjectSettings]) {
        let names = || objects.iter().map(|object| &object.name);
        if names().eq(self.all.iter().map(|mark| &mark.name)) {
            return;
        }
        let are_as_many = objects.len() == self.all.len();
        let followed = names().enumerate().map(|(i, name)| {
            let by_name = self.all.iter().find(|mark| mark.name == *name);
            let by_place = are_as_many.then(|| &self.all[i]);
            let by_place = by_place.filter(|mark| !names().any(|name| *name == mark.name));
            let was = by_name.or(by_place);
            Mark {
                name: name.clone(),
                is_hidden: was.is_some_and(|was| was.is_hidden),
                is_locked: was.is_some_and(|was| was.is_locked),
            }
        });
        self.all = followed.collect();
    }

    /// The marks of objects that run. Until they have the names that are edited, their places count.
    pub fn of_running(&self, running: &[ObjectSettings]) -> RunningMarks {
        let are_as_many = running.len() == self.all.len();
        let marks = running.iter().enumerate().map(|(i, object)| {
            let by_name = self.all.iter().find(|mark| mark.name == object.name);
            by_name.or_else(|| self.all.get(i).filter(|_| are_as_many))
        });
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
