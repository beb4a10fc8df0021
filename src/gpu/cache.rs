//! The pipeline cache on disk: pipelines that were compiled once need no compilation the next time.
//!
//! One file a device and driver build. A file that is damaged, or of another driver, is ignored and replaced; nothing
//! here can make the program fail.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use ash::vk;

use super::info::DeviceInfo;

const MAGIC: &[u8; 8] = b"MYXOPC01";

/// The user's folder for pipeline caches, if the system names one.
#[must_use]
pub fn default_cache_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "myxo").map(|dirs| dirs.cache_dir().to_owned())
}

/// The driver's cache and the file that it came from.
#[derive(Default)]
pub(crate) struct PipelineCache {
    raw: vk::PipelineCache,
    file: Option<PathBuf>,
    /// Size of the file's data: it is written only if the cache has grown.
    size_on_disk: usize,
}

impl PipelineCache {
    /// Reads the device's file in `folder`; without a folder nothing is cached.
    pub(crate) fn open(device: &ash::Device, info: &DeviceInfo, folder: Option<&Path>) -> Self {
        let Some(folder) = folder else {
            return Self::default();
        };
        let file = folder.join(format!("pipelines-{}.bin", info.cache_key));
        let data = fs::read(&file)
            .ok()
            .and_then(|bytes| unpack(&bytes).map(<[u8]>::to_vec))
            .unwrap_or_default();
        let create = |data: &[u8]| {
            let info = vk::PipelineCacheCreateInfo::default().initial_data(data);
            // SAFETY: the driver checks the data's header, and `unpack` has checked that it is whole.
            unsafe { device.create_pipeline_cache(&info, None) }
        };
        // Without a cache pipelines only take longer.
        let raw = create(&data).or_else(|_| create(&[])).unwrap_or_default();
        Self {
            raw,
            file: Some(file),
            size_on_disk: data.len(),
        }
    }

    pub(crate) fn raw(&self) -> vk::PipelineCache {
        self.raw
    }

    /// Writes what is new and frees the cache.
    pub(crate) fn close(self, device: &ash::Device) {
        if self.raw == vk::PipelineCache::null() {
            return;
        }
        // SAFETY: the cache is this device's, and no pipeline is being made.
        let data = unsafe { device.get_pipeline_cache_data(self.raw) }.unwrap_or_default();
        if let Some(file) = &self.file
            && !data.is_empty()
            && data.len() != self.size_on_disk
            && let Err(error) = save(file, &data)
        {
            log::warn!(
                "cannot write the pipeline cache {}: {error}; the next start takes longer",
                file.display()
            );
        }
        // SAFETY: nothing uses it any more.
        unsafe { device.destroy_pipeline_cache(self.raw, None) };
    }
}

/// Magic, length and checksum, then the driver's data. The file is complete or absent at every moment.
fn save(file: &Path, data: &[u8]) -> std::io::Result<()> {
    let folder = file.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let mut temporary = tempfile::NamedTempFile::new_in(folder)?;
    temporary.write_all(MAGIC)?;
    temporary.write_all(&(data.len() as u64).to_le_bytes())?;
    temporary.write_all(&crc32fast::hash(data).to_le_bytes())?;
    temporary.write_all(data)?;
    temporary.persist(file).map_err(|e| e.error)?;
    Ok(())
}

fn unpack(bytes: &[u8]) -> Option<&[u8]> {
    let (magic, rest) = bytes.split_first_chunk::<8>()?;
    let (len, rest) = rest.split_first_chunk::<8>()?;
    let (sum, data) = rest.split_first_chunk::<4>()?;
    let whole = magic == MAGIC
        && u64::from_le_bytes(*len) == data.len() as u64
        && u32::from_le_bytes(*sum) == crc32fast::hash(data);
    whole.then_some(data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damaged_file_is_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep").join("pipelines.bin");
        save(&file, b"compiled").unwrap();
        let good = fs::read(&file).unwrap();
        assert_eq!(unpack(&good), Some(&b"compiled"[..]));
        for cut in 0..good.len() {
            assert_eq!(unpack(&good[..cut]), None, "cut at {cut}");
        }
        for i in 0..good.len() {
            let mut bad = good.clone();
            bad[i] ^= 1;
            assert_eq!(unpack(&bad), None, "byte {i}");
        }
    }
}
