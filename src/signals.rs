//! Signals, as far as the standard library leaves them to the system: the only calls of it here that are `unsafe`.

/// Lets a write that would pass the limit of file sizes (`ulimit -f`) fail with an error, as on a full disk. By default the signal
/// `SIGXFSZ` ends the process without a word. Programs that it starts ignore the signal, too, and say what failed.
pub fn ignore_file_size_limit() {
    // SAFETY: no handler is installed, so no code of ours runs within a signal.
    #[cfg(unix)]
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Ends a process that this one has started as the first of its own group and has not yet waited for, and everything in the group.
pub(crate) fn kill_group(child: &mut std::process::Child) {
    kill_group_of(child.id());
    // Fails only when it has ended already.
    let _ = child.kill();
}

/// Ends a group of processes, by the number of its first one, which this process has started and not yet waited for.
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

/// Has a process that this one has started ended? It is not waited for by that, so that its number stays its own.
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
        // There is no such child where it was waited for.
        answer != 0 || ended != 0
    }
    #[cfg(not(unix))]
    child.try_wait().is_ok_and(|status| status.is_some())
}
