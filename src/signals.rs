//! Signals that the standard library does not cover, by `unsafe` calls of the system.

/// Lets a write that would pass the limit of file sizes (`ulimit -f`) fail with an error, as on a full disk. By default the signal
/// `SIGXFSZ` ends the process without a message. Child processes inherit this, and report the error.
pub fn ignore_file_size_limit() {
    // SAFETY: no handler is installed, so no code of ours runs within a signal.
    #[cfg(unix)]
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Kills a child process that leads its own process group and was not waited for yet, with its whole group.
pub(crate) fn kill_group(child: &mut std::process::Child) {
    kill_group_of(child.id());
    // This fails only if it has ended already.
    let _ = child.kill();
}

/// Kills a process group, by the id of its leader, a child process that was not waited for yet.
pub(crate) fn kill_group_of(first: u32) {
    #[cfg(unix)]
    if let Ok(group) = libc::pid_t::try_from(first) {
        // SAFETY: it touches no memory of this process.
        unsafe {
            libc::killpg(group, libc::SIGKILL);
        }
    }
    #[cfg(not(unix))]
    let _ = first;
}

/// Has a child process ended? It is not reaped by this, so its id is not reused.
pub(crate) fn has_ended(child: &mut std::process::Child) -> bool {
    #[cfg(unix)]
    {
        // SAFETY: the structure is plain numbers, for which zeros are values.
        let mut found: libc::siginfo_t = unsafe { std::mem::zeroed() };
        let options = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
        // SAFETY: it writes the structure and nothing else.
        let answer = unsafe { libc::waitid(libc::P_PID, child.id(), &raw mut found, options) };
        // SAFETY: for a child that has ended the number is set; otherwise it stays zero.
        let ended = unsafe { found.si_pid() };
        // There is no such child if it was waited for.
        answer != 0 || ended != 0
    }
    #[cfg(not(unix))]
    child.try_wait().is_ok_and(|status| status.is_some())
}
