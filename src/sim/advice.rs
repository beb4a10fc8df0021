//! Advice after a failure of the device: which settings take less memory, or make a kernel shorter.

use crate::gpu::GpuError;

/// Advice on an error of the device, to append to its text; empty if the text has it already.
pub(crate) fn on_device(error: &GpuError) -> &'static str {
    match error {
        GpuError::OutOfMemory { .. } => {
            "; use a smaller atlas or fewer particles, or close other programs"
        }
        GpuError::DeviceLost { .. } => {
            ": start again, with a smaller atlas or fewer particles if it happens twice"
        }
        GpuError::Timeout { kernel, .. } => match kernel.as_deref() {
            Some("distance_brute" | "distance_raster" | "distance_merge") => {
                ". Use distance.method = \"bvh\", a smaller atlas (atlas.size), or meshes with fewer triangles"
            }
            Some("distance_tiles" | "distance" | "unfold") => {
                ". Use a smaller atlas (atlas.size) or a shorter distance.reach, or name fewer objects in distance_to"
            }
            _ => {
                ". Use fewer particles (particles.count), a smaller atlas (atlas.size) or a smaller picture"
            }
        },
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::Error;

    /// The advice on a timeout shortens the kernel that took too long.
    #[test]
    fn advice_is_for_the_kernel_that_took_too_long() {
        for (kernel, words, never) in [
            ("advance", "particles.count", "distance"),
            ("diffuse", "a smaller atlas (atlas.size)", "distance"),
            ("distance_brute", "distance.method = \"bvh\"", "particles"),
            ("distance_merge", "distance.method = \"bvh\"", "particles"),
            ("distance_raster", "distance.method = \"bvh\"", "particles"),
            ("distance_tiles", "distance.reach", "distance.method"),
            ("distance", "distance.reach", "distance.method"),
            ("unfold", "distance.reach", "particles"),
        ] {
            let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
            let file = |ending| shaders.join(format!("{kernel}.{ending}"));
            assert!(["comp", "vert"].iter().any(|ending| file(ending).is_file()));
            let text = Error::from(GpuError::Timeout {
                seconds: 60,
                last: format!("the last kernel begun was `{kernel}`"),
                kernel: Some(kernel.to_owned()),
            })
            .to_string();
            let begins = format!(
                "the device did not finish within 60 s; the last kernel begun was `{kernel}`. Use "
            );
            assert!(text.starts_with(&begins), "{text}");
            assert!(
                text.contains(words) && text.contains("atlas.size"),
                "{text}"
            );
            let advice = text.rsplit_once(". ").unwrap().1;
            assert!(!advice.contains(never), "{text}");
            assert!(!advice.contains("limit"), "it cannot be raised: {text}");
        }
    }

    #[test]
    fn a_device_that_is_lost_or_has_no_memory_is_asked_for_less() {
        let lost = Error::from(GpuError::DeviceLost {
            call: "vkQueueSubmit",
            last: "it was busy with a frame".to_owned(),
        });
        assert_eq!(
            lost.to_string(),
            "the device was lost in vkQueueSubmit; it was busy with a frame. Everything on it is gone: start again, with a \
             smaller atlas or fewer particles if it happens twice"
        );
        let error = GpuError::OutOfMemory {
            object: "trail".to_owned(),
            size: 64,
            source: gpu_allocator::AllocationError::OutOfMemory,
        };
        assert_eq!(
            Error::from(error).to_string(),
            "no memory for \"trail\" (64 bytes): Out of memory; use a smaller atlas or fewer particles, or close other programs"
        );
    }

    #[test]
    fn other_errors_say_what_to_do_themselves() {
        let text = GpuError::NoValidation.to_string();
        assert_eq!(Error::from(GpuError::NoValidation).to_string(), text);
    }
}
