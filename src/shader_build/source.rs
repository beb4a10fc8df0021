//! Facts that reflection does not provide: some are read from the words of the module, and remarks from the source.

use std::collections::{BTreeMap, BTreeSet};

/// Facts that spirq does not provide: defaults of specialization constants, the literal group size, and one built-in.
pub struct RawModule {
    /// Invocations along the three axes.
    pub group_size: [u32; 3],
    /// Bits of each specialization constant's default, by its number.
    pub defaults: BTreeMap<u32, u32>,
    /// `gl_GlobalInvocationID` is read.
    pub uses_global_invocation_id: bool,
}

impl RawModule {
    /// Reads the module's instructions up to its functions and beyond; unknown ones are skipped.
    pub fn scan(words: &[u32]) -> Self {
        const EXECUTION_MODE: u32 = 16;
        const SPEC_CONSTANT_TRUE: u32 = 48;
        const SPEC_CONSTANT_FALSE: u32 = 49;
        const SPEC_CONSTANT: u32 = 50;
        const DECORATE: u32 = 71;
        const DECORATION_SPEC_ID: u32 = 1;
        const DECORATION_BUILT_IN: u32 = 11;
        const BUILT_IN_GLOBAL_INVOCATION_ID: u32 = 28;
        const MODE_LOCAL_SIZE: u32 = 17;
        let mut module = Self {
            group_size: [1; 3],
            defaults: BTreeMap::new(),
            uses_global_invocation_id: false,
        };
        let mut spec_ids = BTreeMap::new();
        let mut at = 5;
        while at < words.len() {
            let (count, op) = ((words[at] >> 16) as usize, words[at] & 0xffff);
            if count == 0 || at + count > words.len() {
                break;
            }
            match (op, &words[at + 1..at + count]) {
                (EXECUTION_MODE, [_, MODE_LOCAL_SIZE, x, y, z]) => module.group_size = [*x, *y, *z],
                (DECORATE, [target, DECORATION_SPEC_ID, id]) => {
                    spec_ids.insert(*target, *id);
                }
                (DECORATE, [_, DECORATION_BUILT_IN, BUILT_IN_GLOBAL_INVOCATION_ID]) => {
                    module.uses_global_invocation_id = true;
                }
                (SPEC_CONSTANT_TRUE | SPEC_CONSTANT_FALSE, [_, target]) => {
                    if let Some(id) = spec_ids.get(target) {
                        module
                            .defaults
                            .insert(*id, u32::from(op == SPEC_CONSTANT_TRUE));
                    }
                }
                (SPEC_CONSTANT, [_, target, value]) => {
                    if let Some(id) = spec_ids.get(target) {
                        module.defaults.insert(*id, *value);
                    }
                }
                _ => {}
            }
            at += count;
        }
        module
    }
}

/// The comment lines that a file begins with.
pub fn header(source: &str) -> Vec<String> {
    source
        .lines()
        .skip_while(|line| line.trim().is_empty() || line.starts_with("#version"))
        .take_while(|line| line.starts_with("//"))
        .map(|line| line.trim_start_matches('/').trim().to_owned())
        .collect()
}

/// The numbers of blocks called `Pages` and a number: of bindings that a module accesses by the addresses of their pages.
pub fn paged_bindings(words: &[u32]) -> BTreeSet<u32> {
    const NAME: u32 = 5;
    let mut found = BTreeSet::new();
    let mut at = 5;
    while at < words.len() {
        let (count, op) = ((words[at] >> 16) as usize, words[at] & 0xffff);
        if count == 0 || at + count > words.len() {
            break;
        }
        if op == NAME && count > 2 {
            let bytes = words[at + 2..at + count]
                .iter()
                .flat_map(|word| word.to_le_bytes());
            let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
            let name = String::from_utf8_lossy(&bytes);
            found.extend(
                name.strip_prefix("Pages")
                    .and_then(|number| number.parse::<u32>().ok()),
            );
        }
        at += count;
    }
    found
}

/// Is this table declared as one that may lie in pages: `PAGED_READS(uvec4, 0) particles;`?
pub fn is_paged(source: &str, name: &str) -> bool {
    let lines = source.lines().map(str::trim_start);
    let lines = lines.filter(|line| line.starts_with("PAGED_"));
    let declared = lines.filter_map(|line| line.split_once(')')?.1.split(';').next());
    declared.map(str::trim).any(|declared| declared == name)
}

/// `uint count; // how many` gives `count` its remark.
pub fn remarks(source: &str) -> BTreeMap<String, String> {
    source
        .lines()
        .filter_map(|line| {
            let (code, remark) = line.split_once("//")?;
            let declared = code.trim_end().strip_suffix(';')?;
            let declared = if code.trim_start().starts_with("layout") {
                declared.split_once(')')?.1
            } else {
                declared
            };
            // `const uint N = 5`, `{ vec4 values[]; }`, `float table[3]`: the name is what precedes.
            let declared = declared.trim_end().trim_end_matches(['}', ';', ' ']);
            let declared = declared.split('=').next()?.trim_end();
            let declared = declared.rfind('[').map_or(declared, |at| &declared[..at]);
            let name: String = declared
                .chars()
                .rev()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect();
            let name: String = name.chars().rev().collect();
            let remark = remark.trim();
            (!name.is_empty() && !remark.is_empty()).then(|| (name, remark.to_owned()))
        })
        .collect()
}
