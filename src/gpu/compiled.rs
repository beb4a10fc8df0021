//! The driver's report on compiled kernels, if it gives one (`VK_KHR_pipeline_executable_properties`):
//! registers, spills, occupancy. Each driver has its own names and numbers.

use ash::{khr, vk};

use super::info::text;

/// A kernel as a driver has compiled it.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    /// The pipeline's name.
    pub kernel: &'static str,
    /// Its specialization constants, by number.
    pub constants: Vec<(u32, u32)>,
    /// Invocations that run in lock-step.
    pub subgroup_size: u32,
    /// The statistics, in the driver's order.
    pub statistics: Vec<Statistic>,
}

/// One number.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistic {
    /// The driver's name of the statistic.
    pub name: String,
    /// The driver's description of it.
    pub description: String,
    /// The number; 0 or 1 for what is false or true.
    pub value: f64,
}

/// The driver's report on a pipeline that was created for this; empty if the driver fails to give one.
pub(crate) fn ask(
    device: &khr::pipeline_executable_properties::Device,
    pipeline: vk::Pipeline,
    kernel: &'static str,
    constants: &[(u32, [u8; 4])],
) -> Vec<Compiled> {
    let constants = constants
        .iter()
        .map(|(id, bits)| (*id, u32::from_ne_bytes(*bits)));
    let constants: Vec<(u32, u32)> = constants.collect();
    let programs = programs(device, pipeline).unwrap_or_default();
    let compiled = programs
        .into_iter()
        .map(|(subgroup_size, statistics)| Compiled {
            kernel,
            constants: constants.clone(),
            subgroup_size,
            statistics,
        });
    compiled.collect()
}

/// Subgroup size and statistics of each program that the pipeline was compiled to.
fn programs(
    device: &khr::pipeline_executable_properties::Device,
    pipeline: vk::Pipeline,
) -> ash::prelude::VkResult<Vec<(u32, Vec<Statistic>)>> {
    let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
    // SAFETY: the pipeline is alive and was made to be asked.
    let programs = unsafe { device.get_pipeline_executable_properties(&info) }?;
    (0..)
        .zip(&programs)
        .map(|(index, program)| {
            let info = vk::PipelineExecutableInfoKHR::default()
                .pipeline(pipeline)
                .executable_index(index);
            // SAFETY: as above; there is a program of this index.
            let found = unsafe { device.get_pipeline_executable_statistics(&info) }?;
            let statistics = found.iter().map(|one| Statistic {
                name: text(one.name_as_c_str()),
                description: text(one.description_as_c_str()),
                value: value(one),
            });
            Ok((program.subgroup_size, statistics.collect()))
        })
        .collect()
}

fn value(statistic: &vk::PipelineExecutableStatisticKHR<'_>) -> f64 {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    let value = &statistic.value;
    // SAFETY: the format says which field the driver has written.
    unsafe {
        match statistic.format {
            Format::BOOL32 => f64::from(value.b32),
            Format::INT64 => value.i64 as f64,
            Format::UINT64 => value.u64 as f64,
            _ => value.f64,
        }
    }
}
