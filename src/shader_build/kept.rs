//! Cache of compiled shaders: a shader is compiled again only if the text of it, of a file that it includes, or the
//! compiler itself has changed.
//!
//! Each shader has a file in the output folder's `compiled/`: a hash of everything that its modules depend on, and the
//! modules. A damaged file is ignored.

use std::collections::BTreeSet;
use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

/// The compiled modules of one shader.
pub struct Modules {
    /// Words of the unoptimised module that is reflected.
    pub reflected: Vec<u32>,
    /// Words of the optimised module.
    pub optimized: Vec<u32>,
    /// Words of the module for graphics cards; empty if the shader has no such form.
    pub for_cards: Vec<u32>,
    /// Words of the module for tables in pages; empty if the shader has none.
    pub for_pages: Vec<u32>,
    /// Words of the module for large tables; empty if the shader has none.
    pub for_large: Vec<u32>,
    /// The compiler's warnings, one per line.
    pub warnings: Vec<String>,
}

/// The folder of compiled modules.
pub struct Kept {
    folder: PathBuf,
    /// A hash of the running program and of shaderc, if that is a shared library.
    compiler: u64,
}

impl Kept {
    /// Opens the folder in `out`, or makes it.
    pub fn open(out: &Path) -> Result<Self, String> {
        let folder = out.join("compiled");
        fs::create_dir_all(&folder)
            .map_err(|e| format!("cannot make the folder {}: {e}", folder.display()))?;
        let program = std::env::current_exe().and_then(fs::read);
        let program = program.map_err(|e| format!("the build script cannot read itself: {e}"))?;
        let mut hash = DefaultHasher::new();
        hash.write(&program);
        if let Some(folder) = std::env::var_os("SHADERC_LIB_DIR") {
            let library = Path::new(&folder).join("libshaderc.so");
            hash.write(&fs::read(library).unwrap_or_default());
        }
        Ok(Self {
            folder,
            compiler: hash.finish(),
        })
    }

    /// The modules of the shader `name`, from the cache or new.
    pub fn get_or_make(
        &self,
        name: &str,
        source: &str,
        include: &Path,
        make: impl FnOnce() -> Result<Modules, String>,
    ) -> Result<Modules, String> {
        let file = self.folder.join(name.replace(['/', '\\'], "+"));
        let key = self.key(name, source, include);
        let kept = fs::read(&file).ok().and_then(|bytes| unpack(&bytes, key));
        if let Some(modules) = kept {
            return Ok(modules);
        }
        let modules = make()?;
        fs::write(&file, pack(&modules, key))
            .map_err(|e| format!("cannot write {}: {e}", file.display()))?;
        Ok(modules)
    }

    /// A hash of the compiler, the shader's name and text, and all files that it includes.
    fn key(&self, name: &str, source: &str, include: &Path) -> u64 {
        let mut hash = DefaultHasher::new();
        hash.write_u64(self.compiler);
        let mut add = |text: &str| {
            hash.write_usize(text.len());
            hash.write(text.as_bytes());
        };
        add(name);
        add(source);
        let mut known = BTreeSet::new();
        let mut open: Vec<String> = includes(source);
        while let Some(name) = open.pop() {
            if !known.insert(name.clone()) {
                continue;
            }
            // The compiler reports files that are missing.
            let text = fs::read_to_string(include.join(&name)).unwrap_or_default();
            add(&name);
            add(&text);
            open.extend(includes(&text));
        }
        hash.finish()
    }
}

/// The files that a text names in its `#include` lines.
fn includes(text: &str) -> Vec<String> {
    let lines = text.lines().filter_map(|line| {
        let rest = line.trim_start().strip_prefix('#')?.trim_start();
        let rest = rest.strip_prefix("include")?.trim_start();
        let name = rest.get(1..)?.split(['"', '>']).next()?;
        Some(name.to_owned())
    });
    lines.collect()
}

/// Words in the byte order of files.
pub fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// The key and the number of words of each module, the modules, the warnings.
fn pack(modules: &Modules, key: u64) -> Vec<u8> {
    let mut packed = key.to_le_bytes().to_vec();
    for words in [
        &modules.reflected,
        &modules.optimized,
        &modules.for_cards,
        &modules.for_pages,
        &modules.for_large,
    ] {
        packed.extend((words.len() as u64).to_le_bytes());
        packed.extend(bytes(words));
    }
    packed.extend(modules.warnings.join("\n").into_bytes());
    packed
}

fn unpack(packed: &[u8], key: u64) -> Option<Modules> {
    let (found, mut rest) = packed.split_first_chunk::<8>()?;
    if u64::from_le_bytes(*found) != key {
        return None;
    }
    let mut take = || {
        let (count, after) = rest.split_first_chunk::<8>()?;
        let len = usize::try_from(u64::from_le_bytes(*count)).ok()?;
        let (words, after) = after.split_at_checked(len.checked_mul(4)?)?;
        rest = after;
        let words = words.chunks_exact(4);
        Some(words.map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])))
    };
    let reflected = take()?.collect();
    let optimized = take()?.collect();
    let for_cards = take()?.collect();
    let for_pages = take()?.collect();
    let for_large = take()?.collect();
    let warnings = std::str::from_utf8(rest).ok()?;
    Some(Modules {
        reflected,
        optimized,
        for_cards,
        for_pages,
        for_large,
        warnings: warnings.lines().map(str::to_owned).collect(),
    })
}
