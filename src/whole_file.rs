//! Writing of whole files: pictures, reports, checkpoints, exports, preferences.
//!
//! - A file appears under its name only when it is whole. What is cut short leaves nothing behind that looks like a result,
//!   and a file that had the name before stays as it was.
//! - It is synced to the disk before it gets its name, and the name before success is reported, so that neither is lost when the power
//!   fails.
//! - It replaces a regular file, and keeps that one's owner and permissions. If the name is a link, its target is replaced, and the link
//!   stays. A device or a pipe is written to, and never replaced. So is a file that is a mount point, such as a volume of a container.
//! - A finished file that cannot get its name stays beside it, and the error says where.
//!
//! The temporary file is locked as long as its process lives. The temporary file of a killed process has a free lock, and the next file
//! that begins in the folder removes it.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::fs::{File, Metadata};
use std::io::{self, Read as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::PersistError;

use crate::plain_text::Shown as _;

/// The ending of hidden names.
const ENDING: &str = ".myxo-part";

/// Names of so many bytes are possible everywhere.
const SURE_LENGTH: usize = 100;

/// Random letters and digits before the ending, by which hidden names differ.
const RANDOM_LENGTH: usize = 6;

/// A file that is written under a hidden name in its final folder, and renamed by [`finish`](Self::finish).
///
/// Dropped without `finish`, it is removed, and a file that had the name before stays as it was.
///
/// ```
/// use std::io::Write;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("reports/torus.json");
/// let mut file = myxo::whole_file::WholeFile::create(&path)?;
/// file.write_all(b"{}")?;
/// assert!(!path.exists());
/// file.finish()?;
/// assert_eq!(std::fs::read(&path)?, b"{}");
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct WholeFile {
    file: tempfile::NamedTempFile,
    /// The requested path.
    path: PathBuf,
    place: Place,
    _listed: Unfinished,
}

/// Temporary files of this process.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the hidden files of everything that is being written, for a process that ends at once: from here on no other file can
/// be begun; a thread that tries waits for the end of the process.
pub fn remove_unfinished() {
    if let Ok(files) = UNFINISHED.lock() {
        for file in &*files {
            let _ = std::fs::remove_file(file);
        }
        std::mem::forget(files);
    }
}

/// Lists a hidden file as long as it has its hidden name.
#[derive(Debug)]
struct Unfinished(PathBuf);

impl Unfinished {
    /// Makes a file and lists it, with nothing between the two in which the process could end without removing it.
    fn list(
        make: impl FnOnce() -> io::Result<tempfile::NamedTempFile>,
    ) -> io::Result<(Self, tempfile::NamedTempFile)> {
        let mut files = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        let file = make()?;
        let path = file.path().to_owned();
        files.insert(path.clone());
        Ok((Self(path), file))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Ok(mut files) = UNFINISHED.lock() {
            files.remove(&self.0);
        }
    }
}

/// Devices and pipes that will be written to.
static HELD: Mutex<BTreeMap<PathBuf, File>> = Mutex::new(BTreeMap::new());

/// The destination of the finished file.
#[derive(Debug)]
enum Place {
    /// A file of this name, which is no link.
    Name(PathBuf),
    /// A device or a pipe, to which the content is copied.
    Special(File),
}

/// Writes a file whole or not at all.
///
/// # Errors
/// As [`WholeFile::create`] and [`WholeFile::finish`], but a file that cannot get its name is removed, because the caller has the content;
/// when the disk is full.
pub fn write_whole(path: &Path, content: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(content.as_ref())?;
    file.finish_or_discard()?;
    Ok(())
}

impl WholeFile {
    /// Begins the file; its folder is created if it is missing.
    ///
    /// # Errors
    /// When the folder cannot be made or written, when `path` is a folder itself or a read-only file, or when it
    /// is a pipe without a reader: all that can be checked before the work begins.
    pub fn create(path: &Path) -> io::Result<Self> {
        let before = std::fs::metadata(path).ok();
        if before.as_ref().is_some_and(Metadata::is_dir) {
            return Err(io::Error::new(
                io::ErrorKind::IsADirectory,
                "there is a folder of this name",
            ));
        }
        if before.as_ref().is_some_and(|before| !before.is_file()) {
            let held = HELD.lock().ok().and_then(|mut held| held.remove(path));
            let special = held.map_or_else(|| open_special(path), Ok)?;
            let (listed, file) =
                Unfinished::list(|| tempfile::NamedTempFile::new().map_err(without_path))?;
            return Ok(Self {
                place: Place::Special(special),
                _listed: listed,
                file,
                path: path.to_owned(),
            });
        }
        if before
            .as_ref()
            .is_some_and(|before| before.permissions().readonly())
        {
            return Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "the file is read-only",
            ));
        }
        let target = followed(path)?;
        let name = target
            .file_name()
            .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
        let folder = folder_of(&target);
        make_folder(folder)?;
        remove_abandoned(folder);
        let prefix = hidden_prefix(name);
        let mut builder = tempfile::Builder::new();
        builder
            .prefix(&prefix)
            .rand_bytes(RANDOM_LENGTH)
            .suffix(ENDING);
        // Temporary files are private by default; a result is as readable as any other file.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        loop {
            let (listed, file) =
                Unfinished::list(|| builder.tempfile_in(folder).map_err(without_path))?;
            lock(file.as_file());
            // Between its creation and its locking another process may have removed it as abandoned.
            if file.path().exists() {
                if let Some(before) = &before {
                    keep_permissions(file.as_file(), before)?;
                }
                return Ok(Self {
                    _listed: listed,
                    file,
                    path: path.to_owned(),
                    place: Place::Name(target),
                });
            }
        }
    }

    /// Checks that a file can be written later, and leaves no file. A pipe stays open until then, because closing it would end its reader's
    /// input.
    ///
    /// # Errors
    /// As [`create`](Self::create).
    pub fn check(path: &Path) -> io::Result<()> {
        let file = Self::create(path)?;
        if let Place::Special(special) = file.place
            && let Ok(mut held) = HELD.lock()
        {
            held.insert(path.to_owned(), special);
        }
        Ok(())
    }

    /// The hidden name, for another program that writes the content.
    pub fn hidden_path(&self) -> &Path {
        self.file.path()
    }

    /// The name that the file gets at the end.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Discards the content, to begin again.
    ///
    /// # Errors
    /// When the file cannot be cut.
    pub fn restart(&mut self) -> io::Result<()> {
        self.cut(0)
    }

    /// Discards the content after so many bytes, to continue from there.
    ///
    /// # Errors
    /// When the file cannot be cut.
    pub fn cut(&mut self, size_in_bytes: u64) -> io::Result<()> {
        let file = self.file.as_file_mut();
        file.set_len(size_in_bytes)?;
        file.seek(SeekFrom::Start(size_in_bytes))?;
        Ok(())
    }

    /// Gives the file its name, replacing an earlier file, or copies the content to the device, the pipe or the mount point of that name.
    ///
    /// # Errors
    /// When it cannot be brought to the disk; then it is removed. When it cannot get its name; then it stays, under a name that the error
    /// says. When the folder cannot be synced; then it has its name.
    pub fn finish(self) -> io::Result<File> {
        self.finish_or(kept)
    }

    /// As [`finish`](Self::finish), but a file that cannot get its name is removed: the caller has the content, or makes it again.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub fn finish_or_discard(self) -> io::Result<File> {
        self.finish_or(io::Error::from)
    }

    /// As [`finish`](Self::finish); `refused` makes the error of a file that cannot get its name.
    fn finish_or(self, refused: impl FnOnce(PersistError) -> io::Error) -> io::Result<File> {
        match self.place {
            Place::Name(target) => {
                self.file.as_file().sync_all()?;
                let file = put(self.file, &target).map_err(refused)?;
                sync_folder(folder_of(&target))?;
                Ok(file)
            }
            Place::Special(special) => {
                let (mut file, _hidden) = self.file.into_parts();
                file.seek(SeekFrom::Start(0))?;
                copy_patiently(&mut file, &special)?;
                Ok(file)
            }
        }
    }

    /// Finishes an incomplete file, such as a film that was cut short. It gets its name if there is no file of that name yet. Otherwise the
    /// other file stays, and this one becomes `film.cut.gif` instead of `film.gif`, or `film.cut-2.gif` and so on. Returns the name.
    ///
    /// # Errors
    /// As [`finish`](Self::finish), but what cannot get a name is removed.
    pub fn finish_beside(self) -> io::Result<PathBuf> {
        let Place::Name(target) = &self.place else {
            let path = self.path.clone();
            self.finish()?;
            return Ok(path);
        };
        let target = target.clone();
        self.file.as_file().sync_all()?;
        let mut file = self.file;
        let mut path = self.path;
        let mut name = target.clone();
        for number in 1.. {
            match file.persist_noclobber(&name) {
                Ok(_) => break,
                Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {
                    file = error.file;
                    name = cut_name(&target, number);
                    path.clone_from(&name);
                }
                Err(error) => return Err(error.error),
            }
        }
        sync_folder(folder_of(&name))?;
        Ok(path)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}

impl Seek for WholeFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.file.as_file_mut().seek(position)
    }
}

/// Gives a hidden file its name. A mount point cannot be replaced; its file takes the content.
fn put(file: tempfile::NamedTempFile, target: &Path) -> Result<File, PersistError> {
    let mut refused = match file.persist(target) {
        Ok(file) => return Ok(file),
        Err(refused) => refused,
    };
    if !matches!(
        refused.error.kind(),
        io::ErrorKind::ResourceBusy | io::ErrorKind::CrossesDevices
    ) {
        return Err(refused);
    }
    match copy_into(refused.file.as_file_mut(), target) {
        Ok(()) => Ok(refused.file.into_file()),
        Err(error) => {
            refused.error = error;
            Err(refused)
        }
    }
}

/// Copies a file's content into another file, in place of what that one had.
fn copy_into(from: &mut File, target: &Path) -> io::Result<()> {
    let to = File::options().write(true).truncate(true).open(target)?;
    from.seek(SeekFrom::Start(0))?;
    copy_patiently(from, &to)?;
    to.sync_all()
}

/// Keeps a file that cannot get its name, and says so. It loses its ending, because the next file in the folder would remove it as
/// abandoned.
fn kept(refused: PersistError) -> io::Error {
    let PersistError { error, file } = refused;
    let name = file.path().with_extension("");
    let place = match file.persist_noclobber(&name) {
        Ok(_) => Ok(name),
        Err(refused) => refused.file.keep().map(|(_, hidden)| hidden),
    };
    match place {
        Ok(place) => io::Error::new(
            error.kind(),
            format!("{error}; what was written is in {}", place.shown()),
        ),
        Err(_) => error,
    }
}

/// The target of a path, with links resolved.
pub(crate) fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    // The number of links that Linux follows.
    for _ in 0..40 {
        match std::fs::read_link(&path) {
            Ok(to) => path = folder_of(&path).join(to),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many links lead to one another"))
}

/// Gives a new file the owner and the permissions of the one that it will replace. Only processes with
/// the right to give files away can set another owner.
fn keep_permissions(file: &File, before: &Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt as _, fchown};
        let own = file.metadata()?;
        if (own.uid(), own.gid()) != (before.uid(), before.gid()) {
            let _ = fchown(file, Some(before.uid()), Some(before.gid()));
        }
    }
    file.set_permissions(before.permissions())
}

/// Opens a device or a pipe to write to. Opening a pipe would block until it has a reader, so it is opened without blocking.
fn open_special(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.write(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    options
        .open(path)
        .map_err(|error| match error.raw_os_error() {
            #[cfg(unix)]
            Some(libc::ENXIO) => {
                io::Error::other("it is a pipe that no program reads: begin to read it first")
            }
            _ => error,
        })
}

/// Copies everything, however slowly the other side reads.
fn copy_patiently(from: &mut File, mut to: &File) -> io::Result<()> {
    let mut bytes = vec![0; 1 << 16];
    loop {
        let count = from.read(&mut bytes)?;
        if count == 0 {
            return Ok(());
        }
        let mut rest = &bytes[..count];
        while !rest.is_empty() {
            match to.write(rest) {
                Ok(written) => rest = &rest[written..],
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    std::thread::sleep(std::time::Duration::from_millis(1));
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// Creates a folder and its parents, and syncs their names to the disk: without them the files in it would be lost.
fn make_folder(folder: &Path) -> io::Result<()> {
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = folder.ancestors().take_while(is_missing).collect();
    std::fs::create_dir_all(folder)?;
    let mut made = missing.iter();
    made.try_for_each(|made| sync_folder(folder_of(made)))
}

/// Syncs the names in a folder to the disk. Where that is not possible, as on some network file systems, they are written later.
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error) if is_never_synced(&error) => {
            log::debug!("{} is not synced: {error}", folder.display());
            Ok(())
        }
        synced => synced,
    }
}

/// Is it the error of a folder that cannot be synced at all?
fn is_never_synced(error: &io::Error) -> bool {
    #[cfg(unix)]
    const NUMBERS: &[i32] = &[
        libc::EBADF,
        libc::EINVAL,
        libc::ENOSYS,
        libc::ENOTSUP,
        libc::EOPNOTSUPP,
    ];
    #[cfg(not(unix))]
    const NUMBERS: &[i32] = &[];
    // A folder may be written but not read; on Windows none can be opened.
    error.kind() == io::ErrorKind::PermissionDenied
        || (error.raw_os_error()).is_some_and(|number| NUMBERS.contains(&number))
}

/// `film.cut.gif` of `film.gif`, and `film.cut-2.gif` for the second.
fn cut_name(path: &Path, number: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(".cut");
    if number > 1 {
        name.push(format!("-{number}"));
    }
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

/// The prefix of a hidden name: a dot and the final name, cut if the hidden name would be longer than all file systems
/// accept, and longer than the final name.
fn hidden_prefix(name: &OsStr) -> OsString {
    let two_dots = 2;
    let others = two_dots + RANDOM_LENGTH + ENDING.len();
    // Space for the name itself, in which a byte that is not UTF-8 becomes three.
    let room = name.len().max(SURE_LENGTH) - others;
    let name = name.to_string_lossy();
    OsString::from(format!(".{}.", &name[..name.floor_char_boundary(room)]))
}

/// Does this name have a prefix from [`hidden_prefix`]?
fn is_hidden(name: &OsStr) -> bool {
    let Some(begins) = name.to_str().and_then(|name| name.strip_suffix(ENDING)) else {
        return false;
    };
    let random = begins.rsplit_once('.').map_or("", |(_, random)| random);
    begins.starts_with('.')
        && random.len() == RANDOM_LENGTH
        && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

/// On file systems without locks, no file ever counts as abandoned.
fn lock(file: &File) {
    if let Err(error) = file.lock() {
        log::debug!("hidden files are not locked here: {error}");
    }
}

/// Removes the hidden files of processes that were killed, once for each folder. Failures are ignored.
fn remove_abandoned(folder: &Path) {
    static TIDY: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let is_first = |folders: &mut BTreeSet<_>| folders.insert(folder.to_owned());
    if !TIDY.lock().is_ok_and(|mut folders| is_first(&mut folders)) {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !is_hidden(&entry.file_name()) {
            continue;
        }
        let path = entry.path();
        let is_left = |file: &File| file.try_lock().is_ok();
        if let Ok(file) = File::options().write(true).open(&path)
            && is_left(&file)
        {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// The system's error message without the name of the hidden temporary file.
fn without_path(error: io::Error) -> io::Error {
    let text = error.to_string();
    match text.rsplit_once(" at path ") {
        Some((said, _)) => io::Error::new(error.kind(), said),
        None => error,
    }
}

/// The folder in which `path` lies: the current one for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn dropped_file_leaves_the_old_one_and_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        std::fs::write(&path, "old").unwrap();

        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"half of the new").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names_in(folder.path()).len(), 2, "a hidden file beside it");
        drop(file);

        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names_in(folder.path()), ["report.json"]);
    }

    #[test]
    fn finished_file_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        std::fs::write(&path, "old and longer").unwrap();

        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"first thought, longer").unwrap();
        file.restart().unwrap();
        file.write_all(b"new").unwrap();
        file.finish().unwrap();

        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names_in(folder.path()), ["report.json"]);
    }

    #[test]
    fn what_cannot_be_written_is_known_at_the_start() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();

        assert!(WholeFile::create(&file.join("below/x.png")).is_err());
        assert_eq!(
            WholeFile::create(folder.path()).unwrap_err().kind(),
            io::ErrorKind::IsADirectory
        );
        assert!(WholeFile::create(Path::new("/")).is_err());
        #[cfg(target_os = "linux")]
        {
            let error = WholeFile::create(Path::new("/proc/x.png")).unwrap_err();
            assert!(!error.to_string().contains(ENDING), "{error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn result_is_as_readable_as_any_other_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let plain = folder.path().join("plain");
        std::fs::write(&plain, "").unwrap();
        let whole = folder.path().join("whole");
        WholeFile::create(&whole).unwrap().finish().unwrap();

        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&whole), mode(&plain));
    }

    /// Would catch: a film that was cut short and replaces an older whole one.
    #[test]
    fn what_is_not_whole_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film.gif");
        let cut = |content: &str| {
            let mut file = WholeFile::create(&path).unwrap();
            file.write_all(content.as_bytes()).unwrap();
            let name = file.finish_beside().unwrap();
            let name = name.file_name().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(&path).unwrap())
        };
        assert_eq!(cut("1"), ("film.gif".to_owned(), "1".to_owned()));
        assert_eq!(cut("2"), ("film.cut.gif".to_owned(), "1".to_owned()));
        assert_eq!(cut("3"), ("film.cut-2.gif".to_owned(), "1".to_owned()));
        assert_eq!(
            names_in(folder.path()),
            ["film.cut-2.gif", "film.cut.gif", "film.gif"]
        );
    }

    /// Would catch: a result that is removed because it cannot get its name, and one that the next file in the folder removes.
    #[test]
    fn what_cannot_get_its_name_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"long work").unwrap();
        std::fs::create_dir(&path).unwrap();
        let error = file.finish().unwrap_err().to_string();
        let names = names_in(folder.path());
        assert_eq!(names.len(), 2, "{names:?}");
        let kept = &names[0];
        assert!(error.contains(kept), "{error}");
        assert!(!is_hidden(OsStr::new(kept)), "{kept}");
        let content = std::fs::read(folder.path().join(kept)).unwrap();
        assert_eq!(content, b"long work");

        // Here the caller has the content.
        let path = folder.path().join("other.json");
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"short").unwrap();
        std::fs::create_dir(&path).unwrap();
        file.finish_or(io::Error::from).unwrap_err();
        assert_eq!(names_in(folder.path()).len(), 3);
    }

    #[test]
    fn file_that_stays_takes_the_content() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        std::fs::write(&path, "old and longer").unwrap();
        let mut from = tempfile::tempfile().unwrap();
        from.write_all(b"new").unwrap();
        copy_into(&mut from, &path).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "new");
        copy_into(&mut from, &folder.path().join("none")).unwrap_err();
        assert_eq!(names_in(folder.path()), ["report.json"]);
    }

    /// Would catch: a name that may be lost and counts as written.
    #[cfg(unix)]
    #[test]
    fn folder_that_is_not_synced_is_an_error_unless_it_cannot_be() {
        let folder = tempfile::tempdir().unwrap();
        sync_folder(folder.path()).unwrap();
        sync_folder(&folder.path().join("none")).unwrap_err();
        for (number, cannot) in [
            (libc::EINVAL, true),
            (libc::EACCES, true),
            (libc::EIO, false),
            (libc::ENOSPC, false),
        ] {
            let error = io::Error::from_raw_os_error(number);
            assert_eq!(is_never_synced(&error), cannot, "{error}");
        }
    }

    /// The longest name that the file system allows must work.
    #[test]
    fn hidden_names_of_long_ones_are_no_longer() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            "x".repeat(251) + ".png",
            "粘菌".repeat(41) + ".json",
            "a.png".to_owned(),
        ] {
            let file = WholeFile::create(&folder.path().join(&name)).unwrap();
            let hidden = names_in(folder.path()).remove(0);
            assert!(is_hidden(OsStr::new(&hidden)), "{hidden}");
            assert!(hidden.len() <= name.len().max(SURE_LENGTH), "{hidden}");
            file.finish().unwrap();
            assert_eq!(names_in(folder.path()), [name.as_str()]);
            std::fs::remove_file(folder.path().join(&name)).unwrap();
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn names_that_are_no_text_are_no_longer_either() {
        use std::os::unix::ffi::OsStrExt as _;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(OsStr::from_bytes(&[0xff; 255]));
        WholeFile::create(&path).unwrap().finish().unwrap();
        assert!(path.exists());
    }

    /// A killed process cannot clean up; without this, folders would fill with temporary files.
    #[test]
    fn what_a_killed_process_left_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let [left, held] = ["aB3xYz", "000000"]
            .map(|random| folder.path().join(format!(".frame.png.{random}{ENDING}")));
        let foreign = folder.path().join(".notes.part");
        for path in [&left, &held, &foreign] {
            std::fs::write(path, "half").unwrap();
        }
        let holder = File::open(&held).unwrap();
        holder.lock().unwrap();
        WholeFile::create(&folder.path().join("report.json")).unwrap();
        assert!(!left.exists() && held.exists() && foreign.exists());
    }
}
