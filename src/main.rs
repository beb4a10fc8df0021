//! The `myxo` executable: everything is in [`cli`], which reads the command line, and in the library, which does it.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
