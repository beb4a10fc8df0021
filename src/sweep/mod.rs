//! Sweeps: runs of one scene at many points of its parameters, and one table of them all.
//!
//! A [`Study`] says which runs there are. Each run is a [`Job`], and its result a [`Row`] in a [`Folder`], written as soon as the run is
//! done. So a sweep that is ended goes on where it was: what has a row is not run again. `myxo sweep` does the jobs by processes of this
//! machine, the Python package by any executor; both use these files, and can go on with each other's folders. If the study asks for
//! pictures, each run has one beside its row, or a note why there is none.

mod folder;
mod identity;
mod job;
mod picture;
mod row;
mod sample;
mod study;
mod table;
mod workers;

pub use folder::{Folder, Shard};
pub use identity::{Contents, identity, key_of};
pub use job::{Finished, Job, check_keys};
pub use picture::{LONGEST_SIDE, Picture, Unseen, check_pictures, picture_size, unseen};
pub use row::Row;
pub use sample::{Method, sample};
pub use study::{Axis, Study};
pub use workers::{largest, processes, threads};
