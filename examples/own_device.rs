//! A simulation on a Vulkan device that a host program has created with `ash` and also uses itself.
//!
//! `cargo run --release --example own_device` prints the hash that `headless` prints.
//!
//! The host owns instance, device and queue; `myxo` computes on them as a guest. Both may submit work to the queue, while they hold the
//! lock `ctx.queue()`.

use myxo::gpu::ash::{self, khr, vk};
use myxo::gpu::{BorrowedDevice, Context, ContextOptions, Frames};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let host = Host::new()?;
    // SAFETY: the handles belong together, the device outlives the context, and no other code uses its queue.
    let ctx = unsafe { Context::borrow(host.borrowed(), &ContextOptions::default()) }?;
    let scene = Scene::load("cube".as_ref(), &Overrides::default())?;
    {
        let mut simulation = Simulation::new(&ctx, &scene)?;
        let mut frames = Frames::new(&ctx, 2)?;
        for _ in 0..100 {
            let mut rec = frames.begin()?;
            simulation.record_step(&mut rec);
            frames.submit(rec)?;
        }
        frames.wait_idle()?;
        println!("{:016x}", simulation.snapshot()?.hash());
    }
    drop(ctx);
    host.is_still_good()?;
    host.destroy();
    Ok(())
}

/// What the host program has anyway.
struct Host {
    entry: ash::Entry,
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    family: u32,
    queue: vk::Queue,
}

impl Host {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        // SAFETY: plain Vulkan: every pointer outlives its call, every handle is of the one before it.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default()
                .application_name(c"host")
                .api_version(vk::API_VERSION_1_2);
            let create = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&create, None)?;
            let all = instance.enumerate_physical_devices()?;
            let physical = *all.first().ok_or("no driver offers a device")?;
            let families = instance.get_physical_device_queue_family_properties(physical);
            let computes = |family: &vk::QueueFamilyProperties| {
                family.queue_flags.contains(vk::QueueFlags::COMPUTE)
            };
            let family = families
                .iter()
                .position(computes)
                .ok_or("nothing computes")? as u32;

            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            let extensions = [khr::push_descriptor::NAME.as_ptr()];
            let create = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions);
            let device = instance.create_device(physical, &create, None)?;
            let queue = device.get_device_queue(family, 0);
            Ok(Self {
                entry,
                instance,
                physical,
                device,
                family,
                queue,
            })
        }
    }

    fn borrowed(&self) -> BorrowedDevice {
        BorrowedDevice {
            entry: self.entry.clone(),
            instance: self.instance.clone(),
            physical_device: self.physical,
            device: self.device.clone(),
            queue_family: self.family,
            queue: self.queue,
            extensions: vec![khr::push_descriptor::NAME],
            features: vk::PhysicalDeviceFeatures::default(),
        }
    }

    /// The guest has left everything as it was.
    fn is_still_good(&self) -> Result<(), vk::Result> {
        // SAFETY: the queue is the device's, and no other code uses it.
        unsafe { self.device.queue_wait_idle(self.queue) }
    }

    fn destroy(self) {
        // SAFETY: nothing of the device or the instance is left.
        unsafe {
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}
