//! The program as people run it: every command, its files, and what it says to what is wrong.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/places.rs"]
mod places;
#[path = "../program/mod.rs"]
mod program;

mod against;
mod arguments;
mod atlas;
mod bad_input;
mod bench;
mod diffuse;
mod examples;
mod export;
mod export_command;
mod files;
mod hostile;
#[cfg(unix)]
mod interrupted;
mod kernel_alone;
mod objects;
#[cfg(unix)]
mod outputs;
mod profile;
mod query;
mod runs;
mod selftest;
mod shaders;
#[cfg(unix)]
mod special_files;
mod views;
