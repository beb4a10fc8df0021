//! The commit of the checkout that the program was built in, for reports and exports.
//!
//! It is read when needed, so that a new commit causes no build: in a checkout from Git's own files, as the checkout is now; in an unpacked
//! archive from `commit.txt`, which `git archive` fills in. Without either, it is the value of the environment variable `MYXO_COMMIT`, as
//! in the archive of `make bundle`.

use std::fs;
use std::path::{Path, PathBuf};

/// Digits of a commit that are shown.
const DIGITS: usize = 12;

/// The first 12 digits of the commit, if the source is a checkout that is still there or came from `git archive`, or the environment
/// variable `MYXO_COMMIT` has it.
///
/// Of a checkout it is the commit that is checked out now: build again after a pull, before results are cited. Changes on top
/// of the commit do not show.
#[must_use]
pub fn commit() -> Option<String> {
    of_archive(include_str!("commit.txt"))
        .or_else(|| of_checkout(Path::new(env!("CARGO_MANIFEST_DIR"))))
        .or_else(|| short(&std::env::var("MYXO_COMMIT").ok()?))
}

/// The commit that `git archive` has written in place of its mark.
fn of_archive(text: &str) -> Option<String> {
    short(text)
}

/// The commit that a checkout's HEAD names. A source inside of another project's checkout has none.
fn of_checkout(folder: &Path) -> Option<String> {
    let git = git_folder(folder)?;
    let head = fs::read_to_string(git.join("HEAD")).ok()?;
    let Some(branch) = head.trim().strip_prefix("ref: ") else {
        return short(&head);
    };
    // Worktrees have a HEAD each, and share their branches.
    let shared = match fs::read_to_string(git.join("commondir")) {
        Ok(path) => git.join(path.trim()),
        Err(_) => git,
    };
    let loose = fs::read_to_string(shared.join(branch)).ok();
    loose.as_deref().and_then(short).or_else(|| {
        let packed = fs::read_to_string(shared.join("packed-refs")).ok()?;
        let mut pairs = packed.lines().filter_map(|line| line.split_once(' '));
        pairs.find_map(|(commit, name)| (name == branch).then(|| short(commit))?)
    })
}

/// Git's folder: the folder `.git`, or the one that a file `.git` names.
fn git_folder(folder: &Path) -> Option<PathBuf> {
    let git = folder.join(".git");
    if git.is_dir() {
        return Some(git);
    }
    let text = fs::read_to_string(&git).ok()?;
    Some(folder.join(text.strip_prefix("gitdir: ")?.trim()))
}

/// The first digits, if it is a commit.
fn short(text: &str) -> Option<String> {
    let text = text.trim();
    let is_commit = text.len() >= 40 && text.bytes().all(|b| b.is_ascii_hexdigit());
    is_commit.then(|| text[..DIGITS].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: &str = "0123456789abcdef0123456789abcdef01234567";
    const OTHER: &str = "fedcba9876543210fedcba9876543210fedcba98";

    /// A folder with these files.
    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        }
        folder
    }

    #[test]
    fn a_checkout_names_its_commit_in_each_way_that_git_has() {
        let branch = ("checkout/.git/HEAD", "ref: refs/heads/main\n");
        let loose = ("checkout/.git/refs/heads/main", ONE);
        let list =
            format!("# pack-refs\n{OTHER} refs/heads/else\n{ONE} refs/heads/main\n^{OTHER}\n");
        let packed = ("checkout/.git/packed-refs", list.as_str());
        let linked = "gitdir: ../first/.git/worktrees/two\n";
        let worktree = [
            ("checkout/.git", linked),
            ("first/.git/worktrees/two/HEAD", "ref: refs/heads/main\n"),
            ("first/.git/worktrees/two/commondir", "../..\n"),
            ("first/.git/refs/heads/main", ONE),
        ];
        let ways: [&[_]; 5] = [
            &[("checkout/.git/HEAD", ONE)],
            &[branch, loose],
            &[branch, packed],
            &[branch, loose, ("checkout/.git/packed-refs", "")],
            &worktree,
        ];
        for files in ways {
            let folder = folder(files);
            let commit = of_checkout(&folder.path().join("checkout"));
            assert_eq!(commit.as_deref(), Some(&ONE[..12]), "{files:?}");
        }
    }

    #[test]
    fn git_says_the_same() {
        let root = env!("CARGO_MANIFEST_DIR");
        let git = std::process::Command::new("git")
            .args(["-C", root, "rev-parse", "--short=12", "HEAD"])
            .output();
        if let (true, Ok(output)) = (Path::new(root).join(".git").exists(), git)
            && output.status.success()
        {
            let said = String::from_utf8(output.stdout).unwrap();
            assert_eq!(of_checkout(Path::new(root)).as_deref(), Some(said.trim()));
        }
    }

    #[test]
    fn what_is_no_checkout_has_no_commit() {
        let ways: [&[_]; 4] = [
            &[("checkout/README.md", "")],
            // Inside of another project's checkout.
            &[(".git/HEAD", ONE), ("checkout/README.md", "")],
            &[("checkout/.git/HEAD", "ref: refs/heads/main\n")],
            &[("checkout/.git/HEAD", "é".repeat(40).leak() as &str)],
        ];
        for files in ways {
            let folder = folder(files);
            let commit = of_checkout(&folder.path().join("checkout"));
            assert_eq!(commit, None, "{files:?}");
        }
    }

    #[test]
    fn an_archive_carries_its_commit() {
        assert_eq!(of_archive("$Format:%H$\n"), None);
        assert_eq!(of_archive(&format!("{ONE}\n")).as_deref(), Some(&ONE[..12]));
    }
}
