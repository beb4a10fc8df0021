//! Problems of a scene: the first ones with their texts, and the total number.

use std::fmt::{self, Write as _};

use super::parameters::OutOfRange;
use crate::plain_text;

/// Problems that a message lists, and that are kept; the others are counted.
pub const MOST_LISTED: usize = 20;

/// One problem of a scene file, a preset or a `--set`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Its place: `line 7`, `--set trail.decay=2`, `preset spots`; empty without a particular place.
    pub place: String,
    /// The problem, and advice.
    pub message: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.is_empty() {
            f.write_str(&self.message)
        } else {
            write!(f, "{}: {}", self.place, self.message)
        }
    }
}

impl From<OutOfRange> for Problem {
    fn from(out: OutOfRange) -> Self {
        let OutOfRange {
            key,
            value,
            allowed,
        } = out;
        Self::from(format!("{key} = {value} is out of range: {allowed}"))
    }
}

/// A problem without a particular place.
impl From<String> for Problem {
    fn from(message: String) -> Self {
        let place = String::new();
        Self { place, message }
    }
}

/// The problems of one scene. A file may have millions: the memory that they take does not grow with their number or their
/// length.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Problems {
    listed: Vec<Problem>,
    count: usize,
}

impl Problems {
    /// Adds a problem. Each of its texts is shortened to a line.
    pub fn push(&mut self, problem: Problem) {
        self.push_with(|| problem);
    }

    /// Adds a problem whose texts are made only if they are listed.
    pub fn push_with(&mut self, problem: impl FnOnce() -> Problem) {
        self.count += 1;
        if self.listed.len() < MOST_LISTED {
            let Problem { place, message } = problem();
            self.listed.push(Problem {
                place: plain_text::quoted(&place).into_owned(),
                message: plain_text::quoted(&message).into_owned(),
            });
        }
    }

    /// The number of problems, listed or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Are there no problems?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The listed problems.
    pub fn iter(&self) -> std::slice::Iter<'_, Problem> {
        self.listed.iter()
    }

    /// All problems of `scene`, as a message.
    pub(super) fn describe(&self, scene: &str) -> String {
        let scene = plain_text::quoted(scene);
        match &self.listed[..] {
            [only] => format!("{scene}: {only}"),
            listed => {
                let mut text = format!("{scene}: {} things are wrong:", self.count);
                for problem in listed {
                    let _ = write!(text, "\n  {problem}");
                }
                if self.count > listed.len() {
                    let _ = write!(text, "\n  and {} more", self.count - listed.len());
                }
                text
            }
        }
    }
}

/// A list of the first names, and the number of the others.
pub(super) fn listed<'n>(mut names: impl Iterator<Item = &'n str>) -> String {
    let first: Vec<&str> = names.by_ref().take(MOST_LISTED).collect();
    match names.count() {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

impl Extend<Problem> for Problems {
    fn extend<T: IntoIterator<Item = Problem>>(&mut self, problems: T) {
        problems.into_iter().for_each(|problem| self.push(problem));
    }
}

impl FromIterator<Problem> for Problems {
    fn from_iter<T: IntoIterator<Item = Problem>>(problems: T) -> Self {
        let mut all = Self::default();
        all.extend(problems);
        all
    }
}

impl From<Vec<Problem>> for Problems {
    fn from(problems: Vec<Problem>) -> Self {
        problems.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a list that keeps every text of a file with millions of mistakes, or builds texts that are not shown.
    #[test]
    fn only_listed_problems_have_texts() {
        let mut problems = Problems::default();
        let mut made = 0;
        for i in 0..1000 {
            problems.push_with(|| {
                made += 1;
                Problem {
                    place: format!("line {i}"),
                    message: "x".repeat(100_000),
                }
            });
        }
        assert_eq!((made, problems.len()), (MOST_LISTED, 1000));
        let text = problems.describe("a.toml");
        assert!(text.starts_with("a.toml: 1000 things are wrong:\n  line 0: xxx"));
        assert!(text.ends_with("letters more)\n  and 980 more"), "{text}");
        assert!(text.len() < 20_000, "{}", text.len());
    }
}
