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

/// Ctrl-C, and what a closed terminal and a shutdown send.
#[cfg(unix)]
const ENDING: [libc::c_int; 3] = [libc::SIGINT, libc::SIGHUP, libc::SIGTERM];

/// Does `work`, which handles the signals that end a program, and then ignores those again that were ignored before: `nohup`, and shells
/// that start a program in the background of a script, want it so.
pub fn keeping_ignored<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(unix)]
    let ignored = ENDING.map(is_ignored);
    let done = work();
    #[cfg(unix)]
    for (signal, was_ignored) in ENDING.into_iter().zip(ignored) {
        if was_ignored {
            // SAFETY: no handler is installed, so no code of ours runs within a signal.
            unsafe {
                libc::signal(signal, libc::SIG_IGN);
            }
        }
    }
    done
}

#[cfg(unix)]
fn is_ignored(signal: libc::c_int) -> bool {
    // SAFETY: the structure is plain numbers and an optional pointer, for which zeros are values.
    let mut found: libc::sigaction = unsafe { std::mem::zeroed() };
    // SAFETY: without a new action it only writes the structure.
    let answer = unsafe { libc::sigaction(signal, std::ptr::null(), &raw mut found) };
    answer == 0 && found.sa_sigaction == libc::SIG_IGN
}

/// Lets the signals that end a program end a child, too, that ignores them only because this process does: for tests of Ctrl-C, which
/// may run in the background of a script.
pub fn end_by_signals(command: &mut std::process::Command) {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt as _;
        let by_default = || {
            for signal in ENDING {
                // SAFETY: no handler is installed, so no code of ours runs within a signal.
                unsafe {
                    libc::signal(signal, libc::SIG_DFL);
                }
            }
            Ok(())
        };
        // SAFETY: between fork and exec only `signal` is called, which may be called there.
        unsafe {
            command.pre_exec(by_default);
        }
    }
    #[cfg(not(unix))]
    let _ = command;
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
