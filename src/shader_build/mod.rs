//! From GLSL to SPIR-V and typed Rust handles; runs inside `build.rs`, so nothing here uses Vulkan.
//!
//! Every shader is compiled twice: an unoptimised module is reflected, because optimising strips the names, and the
//! optimised one is shipped. A kernel that includes `tables.glsl` also has a form for graphics cards, which not every device can run, and a
//! shader with tables that may outgrow a binding has a form for tables in pages, and if it only writes some of them, a form for large ones.
//! Shaders are compiled in parallel, and only if one of their files has changed (`kept`). `reflect` reads SPIR-V into a small `model` and
//! `generate` writes the model as Rust.

pub mod arguments;
pub mod generate;
pub mod interface;
pub mod kept;
pub mod model;
pub mod reflect;
pub mod source;
pub mod strict;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fs, thread};

use kept::{Kept, Modules};
use model::{Shader, Stage};
use shaderc::{
    CompileOptions, Compiler, EnvVersion, IncludeType, OptimizationLevel, ResolvedInclude,
    ShaderKind, TargetEnv,
};

/// The include by which a kernel has a form for graphics cards.
const TABLES: &str = "#include \"tables.glsl\"";

/// The declaration of a table that may outgrow a binding.
const PAGED: &str = "PAGED_";

/// The declaration of such a table that is only written. Kernels with one have a form for large tables.
const PAGED_WRITES: &str = "PAGED_WRITES";

/// The most pages of such a table; `src/gpu/pages.rs` reads it from the same file.
const MOST_PAGES: &str = include_str!("most_pages.txt");

/// The form of a shader: for which devices, or which tables, it is compiled.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    /// Every device.
    Plain,
    /// Every device, for tables that are larger than a storage block: those that are only written are texel buffers, too.
    Large,
    /// Graphics cards: tables are storage blocks, and subgroups append together.
    Card,
    /// Graphics cards; and some tables lie in pages, which shaders reach by address.
    Pages,
}

/// Compiles everything in `shaders` and writes into `out`: `kernels.rs` (compute), `draws.rs` (pairs of vertex and
/// fragment shaders), `choices.rs` (`shaders/choices`: other ways to do what kernels do, for the example of
/// this name) and `selftest.rs` (kernels of
/// `shaders/selftest`, for the tests of `gpu`), each with its draws, and the SPIR-V files.
///
/// Returns the compiler's warnings; the error has one line per problem, each with file and line.
pub fn build(shaders: &Path, out: &Path) -> Result<Vec<String>, String> {
    let include = shaders.join("include");
    let kept = Kept::open(out)?;
    let folders = [
        (shaders.to_path_buf(), "kernels.rs", "draws.rs"),
        (shaders.join("choices"), "choices.rs", "choices_draws.rs"),
        (shaders.join("selftest"), "selftest.rs", "selftest_draws.rs"),
    ];
    let mut paths = Vec::new();
    for (folder, _, _) in &folders {
        paths.extend(sources(folder)?);
    }
    let mut compiled = Vec::new();
    let mut problems = Vec::new();
    for result in side_by_side(&paths, |path| compile(path, &include, &kept)) {
        match result {
            Ok(shader) => compiled.push(shader),
            Err(message) => problems.push(message),
        }
    }
    if !problems.is_empty() {
        return Err(problems.join("\n"));
    }
    let mut warnings = Vec::new();
    for (folder, compute_file, draw_file) in folders {
        let (own, others) = (compiled.into_iter().zip(paths))
            .partition::<Vec<_>, _>(|(_, path)| path.parent() == Some(&folder));
        (compiled, paths) = others.into_iter().unzip();
        let own: Vec<Shader> = own.into_iter().map(|(shader, _)| shader).collect();
        for shader in &own {
            warnings.extend(shader.warnings.iter().cloned());
            write(
                &out.join(shader.spirv_file()),
                &kept::bytes(&shader.optimized),
            )?;
            if let Some(words) = &shader.for_cards {
                write(&out.join(shader.card_file()), &kept::bytes(words))?;
            }
            if let Some(words) = &shader.for_pages {
                write(&out.join(shader.pages_file()), &kept::bytes(words))?;
            }
            if let Some(words) = &shader.for_large {
                write(&out.join(shader.large_file()), &kept::bytes(words))?;
            }
        }
        // The self-test's handles belong to `gpu`, which does not use the simulation's structs.
        let shared = if compute_file == "kernels.rs" {
            shared_structs(&include)?
        } else {
            Vec::new()
        };
        write(
            &out.join(compute_file),
            generate::kernels(&own, &shared)?.as_bytes(),
        )?;
        write(&out.join(draw_file), generate::draws(&own)?.as_bytes())?;
    }
    Ok(warnings)
}

/// The results of `work` on each item, in order, by as many threads as there are processors.
fn side_by_side<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let take = || {
        let mut done = Vec::new();
        while let Some((i, item)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            items.get(i).map(|item| (i, item))
        } {
            done.push((i, work(item)));
        }
        done
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let mut all: Vec<(usize, R)> = thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(take)).collect();
        let results = running.into_iter().map(|thread| thread.join());
        results
            .flat_map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    all.sort_by_key(|(i, _)| *i);
    all.into_iter().map(|(_, result)| result).collect()
}

/// Compiles and reflects one file, or uses its cached modules.
fn compile(path: &Path, include: &Path, kept: &Kept) -> Result<Shader, String> {
    let source =
        fs::read_to_string(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    let stage = match path.extension().and_then(|e| e.to_str()) {
        Some("comp") => Stage::Compute,
        Some("vert") => Stage::Vertex,
        Some("frag") => Stage::Fragment,
        _ => {
            return Err(format!(
                "{}: a shader's name ends in .comp, .vert or .frag",
                path.display()
            ));
        }
    };
    let stem = path
        .file_stem()
        .and_then(|s| s.to_str())
        .unwrap_or_default();
    let name = path.display().to_string();
    let modules = kept.get_or_make(&name, &source, include, || {
        let spirv = |level, form| to_spirv(&source, &name, stage, include, (level, form, false));
        let has_large = stage == Stage::Compute && source.contains(PAGED_WRITES);
        // In the form for large tables every table has the type that the host's arguments have.
        let (reflected, warnings) = match has_large {
            true => spirv(OptimizationLevel::Zero, Form::Large)?,
            false => spirv(OptimizationLevel::Zero, Form::Plain)?,
        };
        let (optimized, _) = spirv(OptimizationLevel::Performance, Form::Plain)?;
        let for_cards = if stage == Stage::Compute && source.contains(TABLES) {
            let (words, _) = spirv(OptimizationLevel::Zero, Form::Card)?;
            check_card_form(stem, &words, &source).map_err(|e| format!("{name}: {e}"))?;
            spirv(OptimizationLevel::Performance, Form::Card)?.0
        } else {
            Vec::new()
        };
        let for_pages = if source.contains(PAGED) {
            let (words, _) = spirv(OptimizationLevel::Zero, Form::Pages)?;
            check_pages_form(stem, stage, &reflected, &words, &source)
                .map_err(|e| format!("{name}: {e}"))?;
            spirv(OptimizationLevel::Performance, Form::Pages)?.0
        } else {
            Vec::new()
        };
        let for_large = match has_large {
            true => spirv(OptimizationLevel::Performance, Form::Large)?.0,
            false => Vec::new(),
        };
        if stage == Stage::Compute && strict::must_be(path, stem) {
            for (form, words) in [
                (Form::Plain, &optimized),
                (Form::Card, &for_cards),
                (Form::Pages, &for_pages),
                (Form::Large, &for_large),
            ] {
                let found = strict::violations(words);
                if !found.is_empty() {
                    let level = OptimizationLevel::Zero;
                    let lines = to_spirv(&source, &name, stage, include, (level, form, true))?;
                    return Err(strict::report(&name, &found, &strict::violations(&lines.0)));
                }
            }
        }
        Ok(Modules {
            reflected,
            optimized,
            for_cards,
            for_pages,
            for_large,
            warnings,
        })
    })?;
    let mut shader = reflect::reflect(stem, stage, &modules.reflected, &source)
        .map_err(|e| format!("{name}: {e}"))?;
    shader.optimized = modules.optimized;
    shader.for_cards = (!modules.for_cards.is_empty()).then_some(modules.for_cards);
    shader.for_pages = (!modules.for_pages.is_empty()).then_some(modules.for_pages);
    shader.for_large = (!modules.for_large.is_empty()).then_some(modules.for_large);
    shader.warnings = modules.warnings;
    Ok(shader)
}

/// Checks that the form for graphics cards has no texel buffer: the host binds each as a storage block.
fn check_card_form(stem: &str, words: &[u32], source: &str) -> Result<(), String> {
    let shader = reflect::reflect(stem, Stage::Compute, words, source)?;
    let texels = shader.bindings.iter().find(|binding| {
        use model::Resource::{StorageTexels, Texels};
        matches!(binding.resource, Texels(_) | StorageTexels(..))
    });
    texels.map_or(Ok(()), |binding| {
        Err(format!(
            "{}: a kernel that includes tables.glsl declares every texel buffer by READS, WRITES or CHANGES",
            binding.name
        ))
    })
}

/// Checks that the form for pages accesses exactly those bindings by addresses that are marked as paged for the host.
fn check_pages_form(
    stem: &str,
    stage: Stage,
    reflected: &[u32],
    words: &[u32],
    source: &str,
) -> Result<(), String> {
    let shader = reflect::reflect(stem, stage, reflected, source)?;
    let paged = shader.bindings.iter().filter(|binding| binding.is_paged);
    if paged
        .map(|binding| binding.number)
        .eq(source::paged_bindings(words))
    {
        return Ok(());
    }
    Err("a table that may lie in pages is declared in the shader itself, on a line of its own: PAGED_READS(uvec4, 0) name;".to_owned())
}

/// The structs of `include/types.glsl` as the compiler lays them out, by way of a shader that binds one of each.
fn shared_structs(include: &Path) -> Result<Vec<model::Struct>, String> {
    let file = include.join("types.glsl");
    let Ok(text) = fs::read_to_string(&file) else {
        return Ok(Vec::new());
    };
    let mut source =
        "#version 460\n#include \"types.glsl\"\nlayout(local_size_x = 1) in;\n".to_owned();
    for (binding, name) in struct_names(&text).iter().enumerate() {
        source += &format!(
            "layout(std430, binding = {binding}) buffer B{binding} {{ {name} of_{name}[]; }};\n"
        );
    }
    source += "void main() {}\n";
    let (words, _) = to_spirv(
        &source,
        "types.glsl",
        Stage::Compute,
        include,
        (OptimizationLevel::Zero, Form::Plain, false),
    )?;
    let shader = reflect::reflect("types", Stage::Compute, &words, &source)
        .map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(shader.structs)
}

fn struct_names(text: &str) -> Vec<String> {
    text.lines()
        .filter_map(|line| line.trim_start().strip_prefix("struct "))
        .map(|rest| {
            rest.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
        .collect()
}

fn to_spirv(
    source: &str,
    name: &str,
    stage: Stage,
    include: &Path,
    (level, form, with_lines): (OptimizationLevel, Form, bool),
) -> Result<(Vec<u32>, Vec<String>), String> {
    let compiler = Compiler::new().map_err(|e| format!("shaderc does not start: {e}"))?;
    let mut options = CompileOptions::new().map_err(|e| format!("shaderc does not start: {e}"))?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(level);
    if with_lines {
        options.set_generate_debug_info();
    }
    options.set_include_callback(|file, kind, from, _depth| {
        let path = match kind {
            IncludeType::Relative | IncludeType::Standard => include.join(file),
        };
        let content = fs::read_to_string(&path)
            .map_err(|e| format!("cannot read {} (included by {from}): {e}", path.display()))?;
        Ok(ResolvedInclude {
            resolved_name: path.display().to_string(),
            content,
        })
    });
    let (kind, macro_name) = match stage {
        Stage::Compute => (ShaderKind::Compute, "MYXO_COMPUTE"),
        Stage::Vertex => (ShaderKind::Vertex, "MYXO_VERTEX"),
        Stage::Fragment => (ShaderKind::Fragment, "MYXO_FRAGMENT"),
    };
    options.add_macro_definition(macro_name, None);
    // Shaders of draws have no form for cards.
    if form == Form::Card || (form == Form::Pages && stage == Stage::Compute) {
        options.add_macro_definition("MYXO_CARD", None);
    }
    if form == Form::Large {
        options.add_macro_definition("MYXO_LARGE", None);
    }
    if form == Form::Pages {
        options.add_macro_definition("MYXO_PAGES", Some(MOST_PAGES.trim()));
    }
    let artifact = compiler
        .compile_into_spirv(source, kind, name, "main", Some(&options))
        .map_err(|e| match e {
            shaderc::Error::CompilationError(_, text) => text.trim_end().to_owned(),
            other => format!("{name}: {other}"),
        })?;
    let warnings = artifact
        .get_warning_messages()
        .lines()
        .map(str::to_owned)
        .collect();
    Ok((artifact.as_binary().to_vec(), warnings))
}

fn sources(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(Vec::new());
    };
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry
            .map_err(|e| format!("cannot list {}: {e}", folder.display()))?
            .path();
        if path.is_file()
            && !path
                .file_name()
                .is_some_and(|n| n.to_string_lossy().starts_with('.'))
        {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Writes a file, unless it holds these bytes already.
fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if fs::read(path).is_ok_and(|present| present == bytes) {
        return Ok(());
    }
    fs::write(path, bytes).map_err(|e| format!("cannot write {}: {e}", path.display()))
}
