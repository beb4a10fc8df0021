//! Checks that there is memory for scenes before it is taken, for the commands and the window: on the device, and if the device is the
//! processor, in the host's memory. There, setting up and reading back take as much again.

use myxo::gpu::{Context, DeviceInfo, DeviceKind, Free};
use myxo::mesh::atlas::{AtlasError, AtlasMethod, AtlasOptions};
use myxo::plain_text::escaped;
use myxo::scene::Scene;
use myxo::scene::parameters::grouped;
use myxo::sim::atlas_options;
use myxo::sim::memory::{self, human};
use myxo::{Error, Result};

use crate::console;

/// Scenes that take more memory than this say so.
pub const LARGE: u64 = 1 << 30;

/// Refuses scenes for which the host has no memory, and prints how much large ones take. `on_device` is what all of them take there
/// together.
pub fn prepare(ctx: &Context, what: &str, scenes: &[&Scene], on_device: u64) -> Result<()> {
    for scene in scenes {
        check_scene_atlas(scene)?;
    }
    let info = ctx.info();
    let message = verdict(
        what,
        on_device,
        &Device::of(info),
        Free::on_host(),
        &advice(scenes),
    )?;
    message.iter().for_each(|text| console::message(text));
    Ok(())
}

/// Refuses a scene for which the host has no memory.
pub fn check(info: &DeviceInfo, scene: &Scene) -> Result<()> {
    check_scene_atlas(scene)?;
    let (free, advice) = (Free::on_host(), advice(&[scene]));
    let on_device = memory::needed(scene);
    verdict(
        &escaped(&scene.name),
        on_device,
        &Device::of(info),
        free,
        &advice,
    )
    .map(drop)
}

fn check_scene_atlas(scene: &Scene) -> Result<()> {
    let options = atlas_options(&scene.settings);
    check_atlas(&options, scene.surface.corners.len(), "atlas.size")
}

/// Refuses a copy of so many bytes on the host, if it has no memory for them.
pub fn check_copy(bytes: u64) -> Result<()> {
    within(bytes, Free::on_host())
}

/// About how many bytes making an atlas takes. For each texel: its owner, area and density, and the bitmaps for packing charts. For
/// texels in gutters and beside them: seams and exchange rows, of which only a grid has many. The numbers were measured with gutters of 1
/// and 4 texels.
fn atlas_bytes(options: &AtlasOptions, triangles: usize) -> u64 {
    let texels = u64::from(options.size).pow(2);
    let beside_seams = if options.method == AtlasMethod::Grid {
        let gutter = f64::from(options.gutter);
        let cells = (triangles as f64 / 2.0).max(1.0);
        let cell = f64::from(options.size) / cells.sqrt();
        let share = (8.0 * (gutter + 1.0) / cell).min(1.0);
        (share * (250.0 + 50.0 * gutter) * texels as f64) as u64
    } else {
        0
    };
    20 * texels + beside_seams
}

/// Refuses an atlas of so many triangles if the host has no memory to make it; `option` is the option that sets its side.
pub fn check_atlas(options: &AtlasOptions, triangles: usize, option: &str) -> Result<()> {
    atlas_within(options, triangles, option, Free::on_host())
}

/// The error of an atlas whose size and method are set by these options or keys: its advice names them.
pub fn atlas_error(error: impl Into<Error>, size: &str, method: &str) -> Error {
    match error.into() {
        // The exit code says so.
        cancelled @ Error::Atlas(AtlasError::Cancelled) => cancelled,
        error => {
            let message = error.to_string().replace("atlas.size", size);
            Error::Invalid(message.replace("atlas.method", method))
        }
    }
}

fn atlas_within(
    options: &AtlasOptions,
    triangles: usize,
    option: &str,
    free: Option<Free>,
) -> Result<()> {
    let bytes = atlas_bytes(options, triangles);
    let Some(free) = free.filter(|free| bytes > free.at_ease()) else {
        return Ok(());
    };
    let fits = |size: u32| {
        let options = AtlasOptions {
            size,
            ..options.clone()
        };
        atlas_bytes(&options, triangles) <= free.at_ease()
    };
    let (mut fitting, mut too_large) = (1, options.size);
    while fitting + 1 < too_large {
        let middle = fitting.midpoint(too_large);
        if fits(middle) {
            fitting = middle;
        } else {
            too_large = middle;
        }
    }
    Err(Error::Invalid(format!(
        "{option} {}: making an atlas of {side} x {side} texels takes about {}, and {} are free, of which a tenth is reserved for \
         other programs: use {option} {fitting} at most, or end other programs",
        options.size,
        human(bytes),
        human(free.memory),
        side = grouped(options.size.into()),
    )))
}

/// Refuses so many bytes if they are not free, with some to spare.
pub fn within(bytes: u64, free: Option<Free>) -> Result<()> {
    match free {
        Some(free) if bytes > free.at_ease() => Err(Error::Invalid(format!(
            "it takes about {}, and {} are free, of which a tenth is reserved for other programs",
            human(bytes),
            human(free.memory)
        ))),
        _ => Ok(()),
    }
}

/// Which settings to lower.
fn advice(scenes: &[&Scene]) -> String {
    let keys = |count: &str, particles: &str, size: &str| {
        format!("lower {count}{particles} or atlas.size{size}")
    };
    match scenes {
        [scene] => {
            let is = |value: u32| format!(" (it is {})", grouped(value.into()));
            let settings = &scene.settings;
            // Where their number changes, there may be room for more particles than there are at the start.
            let count = match settings.slots() > settings.particles.count {
                true => "population.capacity",
                false => "particles.count",
            };
            keys(count, &is(settings.slots()), &is(settings.atlas.size))
        }
        _ => keys("particles.count", "", ""),
    }
}

struct Device<'a> {
    name: &'a str,
    kind: DeviceKind,
    /// The size of the memory that it reports.
    size: u64,
}

impl<'a> Device<'a> {
    fn of(info: &'a DeviceInfo) -> Self {
        let heaps = info.heaps.iter().filter(|heap| heap.device_local);
        Self {
            name: &info.name,
            kind: info.kind,
            size: heaps.map(|heap| heap.size).sum(),
        }
    }
}

/// A message about a scene that takes so much, if it is large; an error if the host has too little free memory.
fn verdict(
    what: &str,
    on_device: u64,
    device: &Device<'_>,
    free: Option<Free>,
    advice: &str,
) -> Result<Option<String>> {
    let is_processor = device.kind == DeviceKind::Cpu;
    let needed = memory::in_all(on_device, device.kind);
    let takes = if is_processor {
        format!(
            "{what} needs {} on the device, which is the processor, and with what setting up and reading back take about {} of \
             memory",
            human(on_device),
            human(needed)
        )
    } else {
        format!("{what} needs {} on the device", human(on_device))
    };
    if let Some(free) = free.filter(|_| is_processor) {
        if needed > free.memory.saturating_add(free.swap) {
            let swap = match free.swap {
                0 => String::new(),
                swap => format!(", and {} to swap to", human(swap)),
            };
            return Err(Error::Invalid(format!(
                "{takes}, but only {} are free{swap}: {advice}, or end other programs",
                human(free.memory)
            )));
        }
        if needed > free.at_ease() {
            let memory = human(free.memory);
            return Ok(Some(format!(
                "{takes}, and {memory} are free: it may become slow, or be ended by the system; if it does, {advice}"
            )));
        }
    }
    // Setting up and reading back take as much of the host's memory.
    let is_more = |free: &Free| on_device > free.memory.saturating_add(free.swap);
    if let Some(free) = free.filter(|free| !is_processor && is_more(free)) {
        return Err(Error::Invalid(format!(
            "{takes}, and while it is set up and read back about {} of the host's memory, of which {} are free: {advice}, or end \
             other programs",
            human(on_device),
            human(free.memory)
        )));
    }
    let more = if on_device > device.size {
        format!(
            ", and {} says that it has {}",
            device.name,
            human(device.size)
        )
    } else {
        String::new()
    };
    Ok((on_device > LARGE).then(|| takes + &more))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GIB: u64 = 1 << 30;
    /// Catches `myxo atlas --size 32768` that takes more than the machine has, and advice that would be refused as well.
    #[test]
    fn an_atlas_is_refused_before_its_memory_is_taken() {
        let free = |gibibytes: u64| {
            let memory = gibibytes * GIB;
            Some(Free { memory, swap: GIB })
        };
        let within = |size, method, free| {
            let options = AtlasOptions {
                size,
                method,
                gutter: 1,
                ..AtlasOptions::default()
            };
            atlas_within(&options, 27_648, "--size", free)
        };
        let charts = |size, free| within(size, AtlasMethod::Charts, free);
        for (size, gibibytes) in [(32_768, 24), (8192, 2), (1024, 1)] {
            charts(size, free(gibibytes)).expect("there is room");
        }
        charts(32_768, None).expect("unknown memory is no reason to refuse");
        // 2.6 GB were measured.
        let grid = |gibibytes| within(4096, AtlasMethod::Grid, free(gibibytes));
        grid(2).expect_err("it takes more");
        grid(3).expect("there is room");
        let refused = charts(32_768, free(16));
        let message = refused.expect_err("it takes 20 GiB").to_string();
        let says = "--size 32768: making an atlas of 32,768 x 32,768 texels takes about 20.0 GiB, and 16.0 GiB are free, ";
        assert!(message.starts_with(says), "{message}");
        let (_, advice) = message
            .split_once(": use --size ")
            .expect("there is advice");
        let fits = advice.split(' ').next().and_then(|n| n.parse().ok());
        let fits: u32 = fits.expect("it is a size");
        assert!(fits > 25_000, "{message}");
        charts(fits, free(16)).expect("as advised");
        charts(fits + 1, free(16)).expect_err("it is the most");
    }

    fn verdict_of(
        on_device: u64,
        kind: DeviceKind,
        memory: u64,
        swap: u64,
    ) -> Result<Option<String>> {
        let device = Device {
            name: "abacus",
            kind,
            size: 6 * GIB,
        };
        let free = Some(Free { memory, swap });
        verdict("torus", on_device, &device, free, "lower particles.count")
    }

    #[test]
    fn the_processor_takes_twice_as_much_and_no_more_than_there_is() {
        let cpu = |on_device, memory, swap| verdict_of(on_device, DeviceKind::Cpu, memory, swap);
        assert_eq!(cpu(GIB / 2, 16 * GIB, 0).expect("it fits"), None);
        let message = cpu(4 * GIB, 16 * GIB, 0)
            .expect("it fits")
            .expect("it is large");
        assert!(
            message.starts_with("torus needs 4.0 GiB on the device"),
            "{message}"
        );
        assert!(message.ends_with("about 8.0 GiB of memory"), "{message}");
        let tight = cpu(4 * GIB, 8 * GIB, 0)
            .expect("it just fits")
            .expect("it has a message");
        assert!(
            tight.contains("8.0 GiB are free: it may become slow"),
            "{tight}"
        );
        let slow = cpu(4 * GIB, 7 * GIB, GIB).expect("it can be swapped");
        assert!(slow.is_some_and(|text| text.contains("may become slow")));
        let error = cpu(5 * GIB, 8 * GIB, GIB)
            .expect_err("it does not fit")
            .to_string();
        assert!(
            error.contains(
                "about 10.0 GiB of memory, but only 8.0 GiB are free, and 1.0 GiB to swap to: lower"
            ),
            "{error}"
        );
    }

    #[test]
    fn a_tenth_of_what_is_free_is_left_to_others() {
        let free = Some(Free {
            memory: 10 * GIB,
            swap: 5 * GIB,
        });
        assert!(within(9 * GIB, free).is_ok() && within(99 * GIB, None).is_ok());
        let error = within(9 * GIB + 1, free)
            .expect_err("it is more")
            .to_string();
        assert!(
            error.contains("about 9.0 GiB, and 10.0 GiB are free"),
            "{error}"
        );
    }

    #[test]
    fn cards_are_checked_by_their_reported_memory() {
        let card = |on_device| verdict_of(on_device, DeviceKind::Discrete, 16 * GIB, 0);
        assert_eq!(card(GIB / 2).expect("it fits"), None);
        let message = card(4 * GIB).expect("it fits");
        assert_eq!(
            message.as_deref(),
            Some("torus needs 4.0 GiB on the device")
        );
        // Drivers may have more memory than they report.
        let message = card(7 * GIB)
            .expect("the driver decides")
            .expect("it has a message");
        assert!(
            message.ends_with("on the device, and abacus says that it has 6.0 GiB"),
            "{message}"
        );
        // The host sets the scene up.
        let error = verdict_of(4 * GIB, DeviceKind::Discrete, GIB, 0)
            .expect_err("it does not fit")
            .to_string();
        assert!(
            error.contains("about 4.0 GiB of the host's memory, of which 1.0 GiB are free: lower"),
            "{error}"
        );
    }

    #[test]
    fn memory_is_known_before_it_is_taken() {
        use myxo::scene::Settings;
        use myxo::sim::memory;
        let mut settings = Settings::default();
        let mut of = |particles, size| {
            settings.particles.count = particles;
            settings.atlas.size = size;
            let scene = Scene::from_settings("test".to_owned(), settings.clone(), ".".into());
            memory::in_all(memory::needed(&scene.expect("it loads")), DeviceKind::Cpu)
        };
        let small = of(1000, 256);
        assert!(of(1_001_000, 256) - small == 1_000_000 * 136);
        assert!(of(1000, 512) > small + 3 * 256 * 256 * 21);
    }
}
