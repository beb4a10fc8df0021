//! Messages to a window, as file managers and window managers send them: dropped files, as the source of XDND version 5, and the request to
//! close.

use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    Atom, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::wrapper::ConnectionExt as _;

use crate::lab::PATIENCE;

/// Sends a message of that type with one atom as its data.
pub fn send_to(window: &str, kind: &str, word: &str) {
    let window: Window = window.parse().expect("it is a number");
    let (connection, _) = x11rb::connect(None).expect("there is a display");
    let [kind, word] = [kind, word].map(|name| {
        let cookie = connection.intern_atom(false, name.as_bytes());
        cookie.expect("it is sent").reply().expect("it is one").atom
    });
    let data = [word, x11rb::CURRENT_TIME, 0, 0, 0];
    let event = ClientMessageEvent::new(32, window, kind, data);
    let sent = connection.send_event(false, window, EventMask::NO_EVENT, event);
    let sent = sent.expect("it is sent").check();
    sent.expect("the window is there");
}

/// Drops files in the middle of the window, and waits until the window has taken them.
pub fn drop_all_on(window: &str, files: &[&Path]) {
    let window: Window = window.parse().expect("it is a number");
    let (connection, screen) = x11rb::connect(None).expect("there is a display");
    let root = connection.setup().roots[screen].root;
    let atom = |name: &str| -> Atom {
        let cookie = connection.intern_atom(false, name.as_bytes());
        cookie.expect("it is sent").reply().expect("it is one").atom
    };
    let source = connection.generate_id().expect("there are numbers");
    let (class, aux) = (WindowClass::INPUT_OUTPUT, CreateWindowAux::new());
    let made = connection.create_window(0, source, root, 0, 0, 1, 1, 0, class, 0, &aux);
    made.expect("it is sent");
    let selection = atom("XdndSelection");
    let owner = connection.set_selection_owner(source, selection, x11rb::CURRENT_TIME);
    owner.expect("it is sent");

    let list = atom("text/uri-list");
    let send = |name: &str, data: [u32; 5]| {
        let event = ClientMessageEvent::new(32, window, atom(name), data);
        let sent = connection.send_event(false, window, EventMask::NO_EVENT, event);
        sent.expect("it is sent");
        connection.flush().expect("it is sent");
    };
    send("XdndEnter", [source, 5 << 24, list, 0, 0]);
    let place = 450 << 16 | 380;
    let position = [
        source,
        0,
        place,
        x11rb::CURRENT_TIME,
        atom("XdndActionCopy"),
    ];
    send("XdndPosition", position);

    let (status, finished) = (atom("XdndStatus"), atom("XdndFinished"));
    let (mut is_accepted, mut is_asked, mut is_dropped) = (false, false, false);
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < PATIENCE, "it is taken");
        match connection.poll_for_event().expect("the display is there") {
            Some(Event::ClientMessage(event)) if event.type_ == status => {
                is_accepted = event.data.as_data32()[1] & 1 == 1;
                assert!(is_accepted, "the window takes files");
            }
            Some(Event::ClientMessage(event)) if event.type_ == finished => break,
            Some(Event::SelectionRequest(event)) => {
                let address: String = (files.iter())
                    .map(|file| format!("file://{}\r\n", file.display()))
                    .collect();
                let (to, property) = (event.requestor, event.property);
                let put = connection.change_property8(
                    PropMode::REPLACE,
                    to,
                    property,
                    list,
                    address.as_bytes(),
                );
                put.expect("it is sent");
                let answer = SelectionNotifyEvent {
                    response_type: SELECTION_NOTIFY_EVENT,
                    sequence: 0,
                    time: event.time,
                    requestor: to,
                    selection,
                    target: event.target,
                    property,
                };
                let sent = connection.send_event(false, to, EventMask::NO_EVENT, answer);
                sent.expect("it is sent");
                connection.flush().expect("it is sent");
                is_asked = true;
            }
            Some(_) => {}
            None => std::thread::sleep(Duration::from_millis(10)),
        }
        if is_accepted && is_asked && !is_dropped {
            is_dropped = true;
            send("XdndDrop", [source, 0, x11rb::CURRENT_TIME, 0, 0]);
        }
    }
}
