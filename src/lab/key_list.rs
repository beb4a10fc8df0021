//! The list of keys in `README.md` and `docs/guide.md`, made from the table of [`actions`]. Only a test uses it: it compares the files
//! with the table, and `make keys` lets it write them.

use std::path::Path;

use crate::lab::actions::{self, Group, MOUSE};

/// Files that have the list, between the two markers.
const FILES: [&str; 2] = ["README.md", "docs/guide.md"];
const BEGIN: &str = "<!-- keys: from src/lab/actions.rs, written by `make keys` -->\n";
const END: &str = "<!-- end of keys -->\n";

/// The table as Markdown: a row for the mouse and one for each group of actions.
fn markdown() -> String {
    let mut text = "| | mouse and keys |\n| --- | --- |\n".to_owned();
    let mut row = |title: &str, entries: Vec<String>| {
        text += &format!("| {title} | {} |\n", entries.join("<br>"));
    };
    let entry = |keys: &str, what: &str| format!("`{}` {what}", keys.replace("  ", ", "));
    let mouse = MOUSE.iter().map(|(keys, what)| entry(keys, what));
    row("Mouse", mouse.collect());
    for group in Group::ALL {
        let own = actions::all().filter(|(.., own)| *own == group);
        row(
            group.title(),
            own.map(|(_, keys, what, _)| entry(keys, &what)).collect(),
        );
    }
    text
}

/// `text` with `list` between its markers; none where a marker is missing.
fn with_list(text: &str, list: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{list}\n{END}{after}"))
}

/// Writes the files instead of failing where the environment variable `MYXO_WRITE_KEYS` is set.
#[test]
fn documents_list_the_keys_of_the_window() {
    for name in FILES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        let text = std::fs::read_to_string(&path).expect(name);
        let wanted = with_list(&text, &markdown());
        let wanted = wanted.unwrap_or_else(|| panic!("{name} lacks {BEGIN}or {END}"));
        if std::env::var_os("MYXO_WRITE_KEYS").is_some() {
            std::fs::write(&path, wanted).expect(name);
        } else {
            assert!(
                text == wanted,
                "the list of keys in {name} differs from src/lab/actions.rs: run `make keys`"
            );
        }
    }
}

#[test]
fn a_list_replaces_what_is_between_the_markers_and_nothing_else() {
    let text = format!("before\n{BEGIN}old\n{END}after\n");
    let new = with_list(&text, "new\n").expect("it has both markers");
    assert_eq!(new, format!("before\n{BEGIN}\nnew\n\n{END}after\n"));
    assert_eq!(with_list(&new, "new\n"), Some(new.clone()));
    assert_eq!(with_list(END, ""), None);
}

#[test]
fn every_key_is_in_the_list_once() {
    let list = markdown();
    for (_, keys, what, _) in actions::all() {
        let entry = format!("`{}` {what}", keys.replace("  ", ", "));
        assert_eq!(list.matches(&entry).count(), 1, "{entry}");
    }
}
