//! The program from the command line: every command, its files and its errors.

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
mod network;
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
mod sweep;
mod views;
