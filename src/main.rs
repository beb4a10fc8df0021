//! The `myxo` executable: [`cli`] reads the command line, [`lab`] is the window, and the library does the work.
//! Only `cli/lab.rs` uses the window; code that both need is beside them: [`console`], [`measured`], [`room`],
//! [`own_presets`].

mod cli;
mod console;
mod lab;
mod measured;
mod own_presets;
mod room;

fn main() -> std::process::ExitCode {
    cli::main()
}
