//! Falls back to X11 where `WAYLAND_DISPLAY` names a socket without a compositor: the variable can outlive the compositor,
//! in terminals and containers that are entered again.

use std::os::unix::net::UnixStream;
use std::path::PathBuf;

use winit::event_loop::EventLoopBuilder;
use winit::platform::x11::EventLoopBuilderExtX11 as _;

/// Asks X11 where `WAYLAND_DISPLAY` names a compositor that does not answer and `DISPLAY` names something.
pub fn choose<T>(builder: &mut EventLoopBuilder<T>) {
    let has = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    // A connection that is open already.
    if has("WAYLAND_SOCKET") || !has("DISPLAY") {
        return;
    }
    let Some(socket) = socket() else { return };
    if let Err(error) = UnixStream::connect(&socket) {
        log::warn!(
            "WAYLAND_DISPLAY names {}, and no compositor answers there ({error}): the window is opened by X11",
            socket.display()
        );
        builder.with_x11();
    }
}

/// Advice if no window opens and the compositor's variable may be the cause.
pub fn hint() -> String {
    match socket().filter(|socket| UnixStream::connect(socket).is_err()) {
        Some(socket) => format!(
            "; WAYLAND_DISPLAY names {}, where no compositor answers",
            socket.display()
        ),
        None => String::new(),
    }
}

/// The compositor's socket, as `wl_display_connect` finds it: a path, or a name in `XDG_RUNTIME_DIR`.
fn socket() -> Option<PathBuf> {
    let name = std::env::var_os("WAYLAND_DISPLAY").filter(|name| !name.is_empty())?;
    let folder = std::env::var_os("XDG_RUNTIME_DIR").unwrap_or_default();
    // Joining an absolute path gives that path.
    Some(PathBuf::from(folder).join(name))
}
