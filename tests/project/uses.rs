//! Which files of a folder use which others, found in `use` items and in paths in code; and the cycles among them.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

/// A name that a `use` item brings into a file.
struct Import {
    /// What it is called there; `*` for all names of a module.
    name: String,
    path: Vec<String>,
    at: usize,
    is_public: bool,
}

/// A file that is no test.
struct File {
    path: PathBuf,
    /// Its module, as seen from the folder: none for the folder's own `mod.rs`.
    module: Vec<String>,
    /// Its text without comments, literals, tests and `use` items: blanks stand in for them, so that lines stay.
    code: Vec<char>,
    imports: Vec<Import>,
}

/// The files of a folder.
struct Folder {
    /// The folder's own module, as seen from the crate.
    module: Vec<String>,
    files: Vec<File>,
    by_module: BTreeMap<Vec<String>, usize>,
}

/// Of two files, the first use of the one by the other: its line, and the path as it is written.
type Uses = BTreeMap<(usize, usize), (usize, String)>;

/// Each cycle as a text: the files on it, and the lines by which each uses the next one. `sources` are the files of `folder` with
/// their paths.
pub fn cycles(folder: &str, sources: &[(PathBuf, String)]) -> Vec<String> {
    let folder = Folder::new(folder, sources);
    let mut uses = folder.uses();
    let mut found = Vec::new();
    while let Some(cycle) = shortest_cycle(&uses) {
        let name = |file: usize| folder.name(file);
        let files: Vec<String> = cycle.iter().chain(&cycle[..1]).map(|&f| name(f)).collect();
        let mut text = files.join(" -> ");
        for (i, &from) in cycle.iter().enumerate() {
            let to = cycle[(i + 1) % cycle.len()];
            let (line, path) = &uses[&(from, to)];
            let file = folder.files[from].path.display();
            text += &format!("\n  {file}:{line}: {path}");
        }
        found.push(text);
        uses.retain(|(from, to), _| !cycle.contains(from) && !cycle.contains(to));
    }
    found
}

impl Folder {
    fn new(folder: &str, sources: &[(PathBuf, String)]) -> Self {
        let parts = |path: &Path| -> Vec<String> {
            let names = path.with_extension("");
            let names = names.iter().map(|part| part.to_str().unwrap().to_owned());
            names.filter(|name| name != "mod").collect()
        };
        let mut files = Vec::new();
        let mut tests = BTreeSet::new();
        for (path, text) in sources {
            let module = parts(path.strip_prefix(folder).unwrap());
            let mut code = without_comments_and_literals(text);
            for name in blank_tests(&mut code) {
                tests.insert([&module[..], &[name]].concat());
            }
            let imports = take_imports(&mut code);
            files.push(File {
                path: path.clone(),
                module,
                code,
                imports,
            });
        }
        files.retain(|file| {
            let is_in_tests = file.module.iter().any(|name| name == "tests");
            !is_in_tests && !tests.iter().any(|test| file.module.starts_with(test))
        });
        let modules = files.iter().map(|file| file.module.clone());
        Self {
            module: parts(Path::new(folder).strip_prefix("src").unwrap()),
            by_module: modules.zip(0..).collect(),
            files,
        }
    }

    fn name(&self, file: usize) -> String {
        match &self.files[file].module[..] {
            [] => "mod".to_owned(),
            module => module.join("/"),
        }
    }

    fn uses(&self) -> Uses {
        let mut uses = Uses::new();
        for (from, file) in self.files.iter().enumerate() {
            let is_mod = file.path.ends_with("mod.rs");
            let mut add = |path: &[String], at: usize| {
                for to in self.files_of(&file.module, path, 0) {
                    if to != from {
                        let line = 1 + file.code[..at].iter().filter(|c| **c == '\n').count();
                        uses.entry((from, to)).or_insert((line, path.join("::")));
                    }
                }
            };
            for import in &file.imports {
                // A module that passes on what its parts define does not use it.
                let is_own = !["crate", "super"].contains(&import.path[0].as_str());
                if !(import.is_public && (is_mod || is_own)) {
                    add(&import.path, import.at);
                }
            }
            for (path, at) in paths(&file.code) {
                add(&path, at);
            }
        }
        uses
    }

    /// The path as seen from the folder, if it leads into it.
    fn absolute(&self, from: &[String], path: &[String]) -> Option<Vec<String>> {
        let (first, mut rest) = path.split_first()?;
        match first.as_str() {
            "crate" => rest.strip_prefix(&self.module[..]).map(<[_]>::to_vec),
            "self" => Some([from, rest].concat()),
            "super" => {
                let (_, mut from) = from.split_last()?;
                while rest.first().is_some_and(|name| name == "super") {
                    (_, from) = from.split_last()?;
                    rest = &rest[1..];
                }
                Some([from, rest].concat())
            }
            _ => {
                let own = [from, std::slice::from_ref(first)].concat();
                (self.by_module.contains_key(&own)).then(|| [from, path].concat())
            }
        }
    }

    /// The files that define what a path in the module `from` names.
    fn files_of(&self, from: &[String], path: &[String], depth: usize) -> Vec<usize> {
        let Some(absolute) = self.absolute(from, path) else {
            return Vec::new();
        };
        let lengths = (0..=absolute.len()).rev();
        let mut modules = lengths.map(|n| absolute.split_at(n));
        let Some((module, rest, file)) = modules.find_map(|(module, rest)| {
            let file = self.by_module.get(module)?;
            Some((module, rest, *file))
        }) else {
            return Vec::new();
        };
        let is_seen = |import: &&Import| import.is_public || from.starts_with(module);
        let imports = self.files[file].imports.iter().filter(is_seen);
        let follow = |import: &Import, rest: &[String]| {
            let path = [&import.path[..], rest].concat();
            self.files_of(module, &path, depth + 1)
        };
        match rest.first().map(String::as_str) {
            None | Some("self") => vec![file],
            _ if depth > 8 => vec![file],
            Some("*") => {
                let others = imports.flat_map(|import| follow(import, &[]));
                std::iter::once(file).chain(others).collect()
            }
            Some(name) => {
                let mut globs = Vec::new();
                for import in imports {
                    if import.name == name {
                        return follow(import, &rest[1..]);
                    }
                    if import.name == "*" {
                        globs.extend(follow(import, &[]));
                    }
                }
                let is_there = |file: &usize| defines(&self.files[*file].code, name);
                match globs.into_iter().find(is_there) {
                    Some(other) if !is_there(&file) => vec![other],
                    _ => vec![file],
                }
            }
        }
    }
}

/// The shortest one, beginning with its first file.
fn shortest_cycle(uses: &Uses) -> Option<Vec<usize>> {
    let mut next: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (from, to) in uses.keys() {
        next.entry(*from).or_default().push(*to);
    }
    let mut best: Option<Vec<usize>> = None;
    for &start in next.keys() {
        let mut before = BTreeMap::new();
        let mut queue = VecDeque::from([start]);
        while let Some(file) = queue.pop_front() {
            for &to in next.get(&file).into_iter().flatten() {
                before.entry(to).or_insert_with(|| {
                    queue.push_back(to);
                    file
                });
            }
        }
        let Some(&last) = before.get(&start) else {
            continue;
        };
        let mut cycle = vec![last];
        while cycle[0] != start {
            cycle.insert(0, before[&cycle[0]]);
        }
        if best.as_ref().is_none_or(|best| cycle.len() < best.len()) {
            best = Some(cycle);
        }
    }
    best
}

fn is_part_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn blank(text: &mut [char]) {
    for c in text.iter_mut().filter(|c| **c != '\n') {
        *c = ' ';
    }
}

/// Does the text have these characters there?
fn has(text: &[char], at: usize, what: &str) -> bool {
    what.chars()
        .enumerate()
        .all(|(i, c)| text.get(at + i) == Some(&c))
}

fn without_comments_and_literals(text: &str) -> Vec<char> {
    let mut text: Vec<char> = text.chars().collect();
    let mut at = 0;
    while at < text.len() {
        let end = end_of_comment_or_literal(&text, at);
        if end > at {
            blank(&mut text[at..end]);
            at = end;
        } else if is_part_of_word(text[at]) {
            while at < text.len() && is_part_of_word(text[at]) {
                at += 1;
            }
        } else {
            at += 1;
        }
    }
    text
}

/// The end of the comment or the literal that begins here; `at` itself if none does.
fn end_of_comment_or_literal(text: &[char], at: usize) -> usize {
    let find = |from: usize, what: &str| {
        let found = (from..text.len()).find(|&i| has(text, i, what));
        found.unwrap_or(text.len())
    };
    let quoted = |from: usize, quote: char| {
        let mut i = from + 1;
        while i < text.len() && text[i] != quote {
            i += if text[i] == '\\' { 2 } else { 1 };
        }
        (i + 1).min(text.len())
    };
    if has(text, at, "//") {
        return find(at, "\n");
    }
    if has(text, at, "/*") {
        let (mut depth, mut i) = (0, at);
        while i < text.len() {
            if has(text, i, "/*") {
                (depth, i) = (depth + 1, i + 2);
            } else if has(text, i, "*/") {
                (depth, i) = (depth - 1, i + 2);
                if depth == 0 {
                    return i;
                }
            } else {
                i += 1;
            }
        }
        return text.len();
    }
    let prefix = ["br", "cr", "r", "b", "c", ""]
        .into_iter()
        .find(|prefix| has(text, at, prefix))
        .unwrap();
    let begin = at + prefix.len();
    if prefix.ends_with('r') {
        let hashes = text[begin..].iter().take_while(|c| **c == '#').count();
        if has(text, begin + hashes, "\"") {
            let end = format!("\"{}", "#".repeat(hashes));
            return (find(begin + hashes + 1, &end) + end.len()).min(text.len());
        }
        return at;
    }
    match text.get(begin) {
        Some('"') => quoted(begin, '"'),
        // A lifetime has no second quote.
        Some('\'') if has(text, begin + 1, "\\") || text.get(begin + 2) == Some(&'\'') => {
            quoted(begin, '\'')
        }
        _ => at,
    }
}

/// Blanks what is built for tests only. Returns the names of modules in files of their own that are among it.
fn blank_tests(code: &mut [char]) -> Vec<String> {
    let mut modules = Vec::new();
    let mut at = 0;
    while at < code.len() {
        if !has(code, at, "#[cfg(") {
            at += 1;
            continue;
        }
        let mut end = past_group(code, at + 1);
        let condition: String = code[at..end].iter().collect();
        let mut words = condition.split(|c| !is_part_of_word(c));
        if !words.any(|word| word == "test") || condition.contains("not(test") {
            at = end;
            continue;
        }
        while end < code.len() && (code[end].is_whitespace() || code[end] == '#') {
            end = if code[end] == '#' {
                past_group(code, end + 1)
            } else {
                end + 1
            };
        }
        let begin = end;
        while end < code.len() && !";,{}".contains(code[end]) {
            end = if "([".contains(code[end]) {
                past_group(code, end)
            } else {
                end + 1
            };
        }
        let item: String = code[begin..end].iter().collect();
        match code.get(end) {
            Some('{') => end = past_group(code, end),
            Some(';') => {
                let mut words = item.split_whitespace().skip_while(|word| *word != "mod");
                modules.extend(words.nth(1).map(str::to_owned));
            }
            _ => {}
        }
        blank(&mut code[at..end]);
        at = end;
    }
    modules
}

/// The place after the bracket that closes the one here.
fn past_group(code: &[char], at: usize) -> usize {
    let mut depth = 0;
    for (i, c) in code.iter().enumerate().skip(at) {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return i + 1;
        }
    }
    code.len()
}

/// The word that begins here, if one does.
fn word(code: &[char], at: usize) -> Option<String> {
    let is_begin = at == 0 || !is_part_of_word(code[at - 1]);
    let word: String = code[at..]
        .iter()
        .take_while(|c| is_part_of_word(**c))
        .collect();
    (is_begin && !word.is_empty()).then_some(word)
}

fn past_blanks(code: &[char], mut at: usize) -> usize {
    while code.get(at).is_some_and(|c| c.is_whitespace()) {
        at += 1;
    }
    at
}

/// The names that `use` items bring in; the items are blanked.
fn take_imports(code: &mut [char]) -> Vec<Import> {
    let mut imports = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let Some(found) = word(code, at) else {
            at += 1;
            continue;
        };
        // `use<'a>` says what a type captures.
        let next = past_blanks(code, at + found.len());
        if found != "use" || code.get(next).is_none_or(|c| *c == '<') {
            at += found.len();
            continue;
        }
        let before: String = code[..at].iter().rev().take(80).collect();
        let before = before.trim_start();
        let is_public = before.starts_with("bup")
            || before.starts_with(')')
                && before
                    .split('(')
                    .nth(1)
                    .is_some_and(|b| b.starts_with("bup"));
        let mut leaves = Vec::new();
        let end = read_tree(code, next, Vec::new(), &mut leaves);
        imports.extend(leaves.into_iter().map(|(name, path, at)| Import {
            name,
            path,
            at,
            is_public,
        }));
        blank(&mut code[at..end]);
        at = end;
    }
    imports
}

/// Reads what `use` names from here on: of each name what it is called, its path and its place. Returns the place after it.
fn read_tree(
    code: &[char],
    mut at: usize,
    mut path: Vec<String>,
    leaves: &mut Vec<(String, Vec<String>, usize)>,
) -> usize {
    if has(code, at, "::") {
        // Another crate.
        path.push("::".to_owned());
        at += 2;
    }
    loop {
        at = past_blanks(code, at);
        if has(code, at, "{") {
            at += 1;
            loop {
                at = past_blanks(code, at);
                match code.get(at) {
                    None => return at,
                    Some('}') => return at + 1,
                    Some(',') => at += 1,
                    Some(_) => at = read_tree(code, at, path.clone(), leaves).max(at + 1),
                }
            }
        }
        let begin = at;
        let name = match word(code, at) {
            Some(name) => name,
            None if has(code, at, "*") => "*".to_owned(),
            None => return at,
        };
        path.push(name.clone());
        at = past_blanks(code, at + name.len());
        if has(code, at, "::") {
            at += 2;
            continue;
        }
        let mut called = match &path[..] {
            [.., module, last] if last == "self" => module.clone(),
            _ => name,
        };
        if word(code, at).is_some_and(|word| word == "as") {
            at = past_blanks(code, at + 2);
            called = word(code, at).unwrap_or_default();
            at += called.len();
        }
        leaves.push((called, path, begin));
        return at;
    }
}

/// Paths of several words in code, and where they begin.
fn paths(code: &[char]) -> Vec<(Vec<String>, usize)> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let Some(first) = word(code, at) else {
            at += 1;
            continue;
        };
        let begin = at;
        let is_first = !has(code, begin.saturating_sub(2), "::");
        at += first.len();
        let mut path = vec![first];
        while has(code, past_blanks(code, at), "::") {
            let next = past_blanks(code, past_blanks(code, at) + 2);
            let Some(name) = code.get(next).and_then(|_| word(code, next)) else {
                break;
            };
            at = next + name.len();
            path.push(name);
        }
        if is_first && path.len() > 1 {
            found.push((path, begin));
        }
    }
    found
}

/// Does a file define something of this name?
fn defines(code: &[char], name: &str) -> bool {
    const KINDS: [&str; 9] = [
        "fn", "struct", "enum", "trait", "type", "const", "static", "mod", "union",
    ];
    let code: String = code.iter().collect();
    let words: Vec<&str> = code
        .split(|c| !is_part_of_word(c))
        .filter(|w| !w.is_empty())
        .collect();
    (words.windows(2)).any(|pair| KINDS.contains(&pair[0]) && pair[1] == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources(files: &[(&str, &str)]) -> Vec<(PathBuf, String)> {
        let file = |(name, text): &(&str, &str)| {
            (
                PathBuf::from(format!("src/gpu/{name}.rs")),
                (*text).to_owned(),
            )
        };
        files.iter().map(file).collect()
    }

    /// Each use as `from to line`.
    fn uses(files: &[(&str, &str)]) -> Vec<String> {
        let folder = Folder::new("src/gpu", &sources(files));
        let uses = folder.uses().into_iter();
        let mut uses: Vec<String> = uses
            .map(|((from, to), (line, _))| {
                format!("{} {} {line}", folder.name(from), folder.name(to))
            })
            .collect();
        uses.sort();
        uses
    }

    #[test]
    fn use_items_are_read_with_braces_and_aliases() {
        let a = "use std::fmt;\nuse super::{\n    b::{self, deep::{X, Y as Z}},\n    c::C as D, d::*,\n};\n\
            pub(crate) use crate::gpu::e::E;\nuse crate::mesh::f;\nuse ::g::G;\nuse super::super::f;\n";
        let others = ["b", "c", "d", "e", "f", "g"].map(|name| (name, ""));
        let all = [&[("mod", ""), ("a", a)][..], &others].concat();
        assert_eq!(uses(&all), ["a b 3", "a c 4", "a d 4", "a e 6"]);
    }

    #[test]
    fn paths_in_code_count_and_comments_texts_and_tests_do_not() {
        let a = "//! super::c::C\nfn f<'a>(x: &'a str) -> impl Iterator<Item = char> + use<'a> {\n\
            /* super::c /* super::c */ super::c */\n    let text = (\"super::c::C\", r#\"\" super::c::C\"#, '\"', '\\'', b'\"');\n\
            super::b::<u8>::of(text);\n    crate::gpu::d :: D::new(self::f, super::f())\n}\npub(super) fn g() {}\n\
            #[cfg(test)]\nmod tests {\n    use super::super::c::C;\n}\n#[cfg(test)]\nuse super::c::{C, D};\n\
            #[cfg(all(test, unix))]\nmod only_tests;\n#[cfg(not(test))]\nuse super::e;\n";
        let user = "use super::b::B;\n";
        let all = [
            ("a", a),
            ("a/only_tests", user),
            ("tests/x", user),
            ("b", ""),
            ("c", ""),
            ("d", ""),
            ("e", ""),
        ];
        assert_eq!(uses(&all), ["a b 5", "a d 6", "a e 18"]);
    }

    #[test]
    fn what_mod_passes_on_is_of_the_file_that_defines_it() {
        let top = "mod a;\nmod b;\npub use ash;\npub use a::A;\npub use b::{B, inner::C as D};\npub use c::*;\nuse d::own;\n\
            fn here() {}\n";
        let all = [
            ("mod", top),
            ("a", "use super::{B, D, ash};\nuse super::here;\n"),
            ("b", "use super::Thing;\n"),
            ("b/inner", "use super::X;\n"),
            ("c", "pub struct Thing;\nuse super::own;\n"),
            ("d", ""),
        ];
        let found = [
            "a b 1",
            "a b/inner 1",
            "a mod 2",
            "b c 1",
            "b/inner b 1",
            "c d 2",
            "mod d 7",
        ];
        assert_eq!(uses(&all), found);
    }

    #[test]
    fn cycles_are_named_with_the_lines_that_close_them() {
        let all = sources(&[
            ("mod", "pub use a::A;\npub use b::B;\n"),
            ("a", "\nuse super::b::B;\n"),
            ("b", "use super::d;\nfn f() { super::c::g() }\n"),
            ("c", "use super::{d, A};\n"),
            ("d", ""),
            ("e", "use super::f::F;\n"),
            ("f", "use super::e::E;\n"),
        ]);
        assert_eq!(
            cycles("src/gpu", &all),
            [
                "e -> f -> e\n  src/gpu/e.rs:1: super::f::F\n  src/gpu/f.rs:1: super::e::E",
                "a -> b -> c -> a\n  src/gpu/a.rs:2: super::b::B\n  src/gpu/b.rs:2: super::c::g\n  src/gpu/c.rs:1: super::A",
            ]
        );
        assert!(cycles("src/gpu", &all[..3]).is_empty());
    }
}
