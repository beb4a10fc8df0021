//! Sources of shader modules: the program contains all of them, and a folder may hold replacements.
//!
//! `MYXO_SPIRV` names that folder. A changed shader runs without building the program again, and the folder's list
//! says which of its modules were recorded at all.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex};

use super::error::{GpuError, GpuResult};

/// The environment variable that names the folder.
const VARIABLE: &str = "MYXO_SPIRV";
/// The list in the folder: a module's file name a line.
const USED: &str = "used";
/// The first word of every module.
const MAGIC: u32 = 0x0723_0203;

/// The module of one stage, as the build left it.
#[derive(Clone, Copy, Debug, Hash)]
pub struct Module {
    /// The name of the file that the build wrote.
    pub file: &'static str,
    /// What it wrote.
    pub spirv: &'static [u8],
    /// The form for graphics cards, if there is one: it uses storage blocks instead of texel buffers, and subgroup ballots.
    pub for_cards: Option<&'static Module>,
    /// The form for tables in pages, if it has such tables: it uses their pages' addresses.
    pub for_pages: Option<&'static Module>,
    /// The form for large tables, if there are some that it only writes: in it these are texel buffers, and elsewhere storage blocks.
    pub for_large: Option<&'static Module>,
}

impl Module {
    /// The words to run, and whether they come from the folder of `MYXO_SPIRV`.
    ///
    /// # Errors
    /// The folder has a file of this name that cannot be read, or that is not SPIR-V.
    pub(crate) fn words(&self) -> GpuResult<(Vec<u32>, bool)> {
        self.words_from(folder())
    }

    fn words_from(&self, folder: Option<&Path>) -> GpuResult<(Vec<u32>, bool)> {
        let replaced = match folder {
            Some(folder) => read(&folder.join(self.file))?,
            None => None,
        };
        let from_folder = replaced.is_some();
        let bytes = replaced.map_or(Cow::Borrowed(self.spirv), Cow::Owned);
        let words = bytemuck::allocation::pod_collect_to_vec(&bytes);
        Ok((words, from_folder))
    }
}

/// The folder whose modules replace built-in ones.
fn folder() -> Option<&'static Path> {
    static FOLDER: LazyLock<Option<PathBuf>> =
        LazyLock::new(|| std::env::var_os(VARIABLE).map(PathBuf::from));
    FOLDER.as_deref()
}

/// A module's bytes; `None` where there is no such file.
fn read(path: &Path) -> GpuResult<Option<Vec<u8>>> {
    let problem = match fs::read(path) {
        Ok(bytes) if bytes.len() % 4 == 0 && bytes.starts_with(&MAGIC.to_ne_bytes()) => {
            return Ok(Some(bytes));
        }
        Ok(_) => "it is not SPIR-V".to_owned(),
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => error.to_string(),
    };
    Err(GpuError::Module {
        path: path.to_owned(),
        problem,
    })
}

/// Adds modules of the folder that a command buffer now runs to the folder's list, each once a process.
pub(crate) fn note_used(files: impl Iterator<Item = &'static str>) {
    static NOTED: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
    let Some(folder) = folder() else {
        return;
    };
    let mut noted = NOTED.lock().unwrap_or_else(|e| e.into_inner());
    for file in files {
        if noted.insert(file)
            && let Err(error) = append(&folder.join(USED), file)
        {
            log::warn!("cannot add {file} to the list {USED} in {VARIABLE}: {error}");
        }
    }
}

/// One write, so that lines of several processes do not mix.
fn append(list: &Path, line: &str) -> std::io::Result<()> {
    let mut file = OpenOptions::new().append(true).create(true).open(list)?;
    file.write_all(format!("{line}\n").as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUILT_IN: Module = Module {
        file: "some.comp.spv",
        spirv: &[1, 0, 0, 0, 2, 0, 0, 0],
        for_cards: None,
        for_pages: None,
        for_large: None,
    };

    #[test]
    fn a_file_of_the_folder_replaces_its_module() {
        let folder = tempfile::tempdir().unwrap();
        let built_in = (vec![1, 2], false);
        assert_eq!(BUILT_IN.words_from(None).unwrap(), built_in);
        assert_eq!(BUILT_IN.words_from(Some(folder.path())).unwrap(), built_in);
        let other: Vec<u8> = [MAGIC, 7].iter().flat_map(|w| w.to_ne_bytes()).collect();
        fs::write(folder.path().join(BUILT_IN.file), other).unwrap();
        assert_eq!(
            BUILT_IN.words_from(Some(folder.path())).unwrap(),
            (vec![MAGIC, 7], true)
        );
    }

    #[test]
    fn what_is_not_spirv_is_refused_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(BUILT_IN.file);
        let magic = MAGIC.to_ne_bytes();
        for bytes in [
            &b""[..],
            b"#version 460\n",
            &[magic[0], magic[1], magic[2], magic[3], 0],
        ] {
            fs::write(&path, bytes).unwrap();
            let error = BUILT_IN.words_from(Some(folder.path())).unwrap_err();
            assert!(
                error.to_string().contains(path.to_str().unwrap()),
                "{error}"
            );
        }
    }

    #[test]
    fn the_list_has_a_line_for_each() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join(USED);
        append(&list, "one.comp.spv").unwrap();
        append(&list, "two.frag.spv").unwrap();
        assert_eq!(
            fs::read_to_string(list).unwrap(),
            "one.comp.spv\ntwo.frag.spv\n"
        );
    }
}
