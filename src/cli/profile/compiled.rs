//! The driver's statistics of compiled kernels, as text and as JSON.

use std::fmt::Write as _;

use myxo::gpu::{Compiled, DeviceInfo, Statistic};
use myxo::plain_text::escaped;
use serde_json::{Value, json};

/// A paragraph for each kernel, and the driver's own explanations of its terms.
pub fn text(scene: &str, driver: &str, all: &[Compiled]) -> String {
    let mut text = format!(
        "kernels of {scene} as {} has compiled them\n",
        escaped(driver)
    );
    let mut meanings: Vec<&Statistic> = Vec::new();
    for one in all {
        let numbers: Vec<String> = one
            .statistics
            .iter()
            .map(|statistic| format!("{} {}", escaped(&statistic.name), statistic.value))
            .collect();
        let numbers = match &numbers[..] {
            [] => "no numbers".to_owned(),
            _ => numbers.join(", "),
        };
        let _ = writeln!(
            text,
            "\n{}: {} in lock-step\n    {numbers}",
            one.kernel, one.subgroup_size
        );
        for statistic in &one.statistics {
            if !meanings.iter().any(|known| known.name == statistic.name) {
                meanings.push(statistic);
            }
        }
    }
    if !meanings.is_empty() {
        text.push('\n');
    }
    for statistic in meanings {
        let _ = writeln!(
            text,
            "{}: {}",
            escaped(&statistic.name),
            escaped(&statistic.description)
        );
    }
    text
}

/// The list for programs, with the specialization constants that each kernel was compiled with.
pub fn json(driver: &str, all: &[Compiled]) -> String {
    let kernel = |one: &Compiled| {
        let constants: serde_json::Map<String, Value> = one
            .constants
            .iter()
            .map(|(id, bits)| (id.to_string(), json!(bits)))
            .collect();
        json!({
            "name": one.kernel,
            "constants": constants,
            "subgroup_size": one.subgroup_size,
            "statistics": one.statistics.iter().map(|statistic| json!({
                "name": statistic.name,
                "description": statistic.description,
                "value": statistic.value,
            })).collect::<Vec<_>>(),
        })
    };
    let all: Vec<Value> = all.iter().map(kernel).collect();
    let report = json!({
        "driver": driver,
        "kernels": all,
    });
    format!("{report:#}\n")
}

/// The driver's name, its version, and its device.
pub fn driver(device: &DeviceInfo) -> String {
    let DeviceInfo {
        driver,
        driver_version,
        name,
        ..
    } = device;
    format!("{driver} {driver_version} for {name}")
}

/// Why there is no such list.
pub fn no_statistics(driver: &str) -> String {
    format!(
        "{driver} gives no statistics of the kernels that it compiles (VK_KHR_pipeline_executable_properties is missing): choose another \
         device with --device; `myxo info` lists them"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a list that leaves a number or its meaning out, or says a meaning twice.
    #[test]
    fn each_number_is_listed_and_explained_once() {
        let statistic = |name: &str, value| Statistic {
            name: name.to_owned(),
            description: format!("the {name}"),
            value,
        };
        let compiled = |kernel, registers| Compiled {
            kernel,
            constants: vec![(11, 1)],
            subgroup_size: 32,
            statistics: vec![statistic("Registers", registers), statistic("Spills", 0.0)],
        };
        let all = [compiled("advance", 48.0), compiled("diffuse", 20.0)];
        assert_eq!(
            text("torus", "Driver 1 for Card", &all),
            "kernels of torus as Driver 1 for Card has compiled them\n\n\
             advance: 32 in lock-step\n    \
             Registers 48, Spills 0\n\n\
             diffuse: 32 in lock-step\n    \
             Registers 20, Spills 0\n\n\
             Registers: the Registers\n\
             Spills: the Spills\n"
        );
        let report: Value = serde_json::from_str(&json("Driver 1 for Card", &all)).unwrap();
        assert_eq!(report["kernels"][0]["constants"]["11"], 1);
        assert_eq!(report["kernels"][1]["statistics"][0]["value"], 20.0);
    }
}
