//! The `myxo` executable: [`cli`] reads the command line, [`lab`] is the window, and the library does the work.

mod cli;
mod lab;

fn main() -> std::process::ExitCode {
    cli::main()
}
