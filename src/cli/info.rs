//! `myxo info`: devices, drivers, limits, and what is missing and how to get it.

use clap::Args;
use myxo::Result;

use super::options::DeviceOptions;
use super::{Outcome, not_built_in};

/// Show devices, drivers and limits, and what is missing and how to get it
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo info
  myxo info --device llvmpipe
  myxo info --json")]
pub struct Info {
    /// Prints JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    device: DeviceOptions,
}

impl Info {
    /// Prints what there is.
    pub fn run(&self) -> Result<Outcome> {
        let _ = (self.json, &self.device);
        Err(not_built_in("the list of devices"))
    }
}
