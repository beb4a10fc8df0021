//! `myxo info`: devices, drivers, limits, and what is missing and how to get it.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use myxo::gpu::{Context, ContextOptions, DeviceInfo, GpuError, default_cache_folder, devices};
use myxo::render::output::Output;
use myxo::scene::parameters::grouped;
use myxo::sim::memory::{human, largest_atlas, most_particles};
use myxo::{Error, Result};
use serde_json::{Value, json};

use super::{Command, Outcome};
use crate::console;

/// Show devices, drivers and limits, and what is missing and how to get it
///
/// What a device may lack is Vulkan 1.2, a queue for compute, VK_KHR_push_descriptor, and what pictures need. Limits of descriptors and
/// invocations are checked when kernels are made: `myxo selftest` shows whether a device meets them.
///
/// Exits 1 if there is no usable device.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo info
  myxo info --device llvmpipe   is there such a device, and would it do?
  myxo info --json")]
pub struct Info {
    /// Prints JSON
    #[arg(long)]
    json: bool,
    /// The device to check: its number or a part of its name
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
}

/// A tool or folder that commands use.
struct Tool {
    name: &'static str,
    /// What was found.
    found: Option<String>,
    /// Its use, and how to get it.
    otherwise: String,
}

impl Command for Info {
    /// Prints the facts; fails if there is no usable device.
    fn run(&self) -> Result<Outcome> {
        let (chosen, validation) = open(self.device.as_deref());
        if let Err(error @ GpuError::UnknownDevice { .. }) = chosen {
            return Err(Error::Gpu(error));
        }
        let (devices, trouble) = match devices() {
            Ok(devices) => (devices, None),
            Err(error) => (Vec::new(), Some(error)),
        };
        let tools = tools(validation);
        let index = chosen.as_ref().ok().copied();
        let text = if self.json {
            let value = as_json(&devices, index, &tools);
            serde_json::to_string_pretty(&value).expect("facts are plain") + "\n"
        } else {
            as_text(&devices, index, &tools)
        };
        console::print(&text)?;
        match (trouble, chosen) {
            (Some(error), _) | (None, Err(error)) => Err(Error::Gpu(error)),
            (None, Ok(_)) => Ok(Outcome::Done),
        }
    }
}

/// Is the layer for `--validate` installed?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Validation {
    Found,
    Missing,
    /// Not known without a device.
    Unknown,
}

/// Opens the device as commands would, with validation if it is installed; returns the device's index.
fn open(device: Option<&str>) -> (Result<usize, GpuError>, Validation) {
    let open = |validation| {
        Context::new(&ContextOptions {
            device: device.map(str::to_owned),
            validation,
            ..ContextOptions::default()
        })
        .map(|ctx| ctx.info().index)
    };
    match open(true) {
        Ok(index) => (Ok(index), Validation::Found),
        Err(GpuError::NoValidation) => (open(false), Validation::Missing),
        Err(_) => (open(false), Validation::Unknown),
    }
}

fn tools(validation: Validation) -> [Tool; 4] {
    let display = ["WAYLAND_DISPLAY", "DISPLAY"].into_iter().find_map(|name| {
        let value = std::env::var(name).ok().filter(|value| !value.is_empty())?;
        Some(format!("{name}={value}"))
    });
    let ffmpeg = in_path("ffmpeg").map(|path| path.display().to_string());
    let videos = Output::try_videos();
    let what = ".mp4 files need it, with libx264 (Debian: apt install ffmpeg)";
    [
        Tool {
            name: "validation layer",
            found: (validation == Validation::Found).then(|| "found".to_owned()),
            otherwise: match validation {
                Validation::Unknown => "not known without a device",
                _ => {
                    "missing; --validate and the tests need it (Debian: apt install vulkan-validationlayers)"
                }
            }
            .to_owned(),
        },
        Tool {
            name: "ffmpeg",
            found: ffmpeg.clone().filter(|_| videos.is_ok()),
            otherwise: match (ffmpeg, videos) {
                (Some(path), Err(error)) => format!("{path} cannot encode H.264 ({error}); {what}"),
                _ => format!("missing; {what}"),
            },
        },
        Tool {
            name: "display",
            found: display,
            otherwise: "none; `myxo lab` needs one, `myxo render` does not".to_owned(),
        },
        Tool {
            name: "cache",
            found: default_cache_folder().map(|folder| folder.display().to_string()),
            otherwise:
                "none, as there is no home folder: kernels and atlases are made again at each start"
                    .to_owned(),
        },
    ]
}

/// The path of a program.
fn in_path(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

fn as_text(devices: &[DeviceInfo], chosen: Option<usize>, tools: &[Tool]) -> String {
    let commit = myxo::commit().map_or(String::new(), |commit| format!(" (commit {commit})"));
    let mut text = format!("myxo {}{commit}\n\nDevices:\n", env!("CARGO_PKG_VERSION"));
    if devices.is_empty() {
        text.push_str("  none\n");
    }
    for device in devices {
        let mark = if chosen == Some(device.index) {
            "  <- is used"
        } else {
            ""
        };
        let _ = writeln!(text, "  {}{mark}", device.line());
        for (what, value) in facts(device) {
            let _ = writeln!(text, "       {what:<16} {value}");
        }
    }
    text.push_str("\nBeside devices:\n");
    for tool in tools {
        let _ = writeln!(
            text,
            "  {:<18} {}",
            tool.name,
            tool.found.as_deref().unwrap_or(&tool.otherwise)
        );
    }
    text
}

fn facts(device: &DeviceInfo) -> Vec<(&'static str, String)> {
    let yes_no = |yes: bool, no: &str| if yes { "yes".to_owned() } else { no.to_owned() };
    let heaps: Vec<String> = device
        .heaps
        .iter()
        .map(|heap| {
            format!(
                "{} {}",
                human(heap.size),
                if heap.device_local {
                    "on the device"
                } else {
                    "of the host"
                }
            )
        })
        .collect();
    vec![
        ("Vulkan", device.api_version.clone()),
        (
            "timestamps",
            if device.has_timestamps() {
                format!(
                    "{} ns a tick, {} bits",
                    device.timestamp_period, device.timestamp_valid_bits
                )
            } else {
                "unavailable: kernel times cannot be measured".to_owned()
            },
        ),
        (
            "pictures",
            yes_no(
                device.has_dynamic_rendering,
                "no: it lacks VK_KHR_dynamic_rendering or a graphics queue",
            ),
        ),
        ("memory", heaps.join(", ")),
        ("one binding", human(device.max_storage_buffer_range)),
        (
            "texel buffer",
            format!(
                "{} elements",
                grouped(device.max_texel_buffer_elements.into())
            ),
        ),
        (
            "room for",
            format!(
                "{} particles{}, or an atlas of {side} x {side} texels",
                grouped(most_particles(device) as f64),
                if device.has_pages { ", in pages" } else { "" },
                side = largest_atlas(device)
            ),
        ),
        (
            "image side",
            format!(
                "{} pixels, {} samples each",
                grouped(device.max_image_side.into()),
                device.max_samples
            ),
        ),
        (
            "kernels",
            if device.takes_card_forms() {
                "in their form for graphics cards".to_owned()
            } else {
                "in their plain form, with texel buffers".to_owned()
            },
        ),
        (
            "dispatch",
            format!(
                "{} groups of {} invocations, {} in lock-step",
                grouped(device.max_group_count.into()),
                device.max_group_invocations,
                device.subgroup_size
            ),
        ),
    ]
}

fn as_json(devices: &[DeviceInfo], chosen: Option<usize>, tools: &[Tool]) -> Value {
    let device = |device: &DeviceInfo| {
        json!({
            "index": device.index,
            "name": device.name,
            "kind": device.kind.as_str(),
            "driver": device.driver,
            "driver_version": device.driver_version,
            "api_version": device.api_version,
            "missing": device.missing,
            "timestamp_period_ns": device.timestamp_period,
            "timestamp_valid_bits": device.timestamp_valid_bits,
            "has_dynamic_rendering": device.has_dynamic_rendering,
            "has_calibrated_timestamps": device.has_calibrated_timestamps,
            "heaps": device.heaps.iter().map(|heap| json!({
                "size_in_bytes": heap.size,
                "device_local": heap.device_local,
            })).collect::<Vec<_>>(),
            "max_storage_buffer_range": device.max_storage_buffer_range,
            "max_memory_allocation_size": device.max_memory_allocation_size,
            "max_texel_buffer_elements": device.max_texel_buffer_elements,
            "max_group_count": device.max_group_count,
            "max_group_invocations": device.max_group_invocations,
            "max_push_constants": device.max_push_constants,
            "max_image_side": device.max_image_side,
            "max_samples": device.max_samples,
            "subgroup_size": device.subgroup_size,
            "has_card_forms": device.has_card_forms,
            "takes_card_forms": device.takes_card_forms(),
            "has_pages": device.has_pages,
            "most_particles": most_particles(device),
            "largest_atlas": largest_atlas(device),
        })
    };
    let tool = |tool: &Tool| (tool.name.replace(' ', "_"), json!(tool.found));
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "commit": myxo::commit(),
        "chosen": chosen,
        "devices": devices.iter().map(device).collect::<Vec<_>>(),
        "tools": tools.iter().map(tool).collect::<serde_json::Map<_, _>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_tools_say_how_to_get_them() {
        let tools = tools(Validation::Missing);
        let text = as_text(&[], None, &tools);
        assert!(
            text.contains("apt install vulkan-validationlayers"),
            "{text}"
        );
        assert!(text.contains("Devices:\n  none\n"), "{text}");
        let value = as_json(&[], None, &tools);
        assert_eq!(
            (&value["chosen"], &value["tools"]["validation_layer"]),
            (&Value::Null, &Value::Null)
        );
        assert!(in_path("sh").is_some() && in_path("no such program").is_none());
    }
}
