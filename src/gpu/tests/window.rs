//! A window's images. Runs with X11 (`xvfb-run cargo test` is enough); without it the skip is printed.

use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::platform::x11::EventLoopBuilderExtX11;
use winit::window::{Window, WindowId};

use super::*;

/// Draws, changes size, hides and comes back.
#[derive(Default)]
struct Show {
    /// The number of pictures; none if there is no device.
    shown: Option<u32>,
}

impl ApplicationHandler for Show {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let attributes = Window::default_attributes().with_inner_size(PhysicalSize::new(320, 200));
        let window = events.create_window(attributes).unwrap();
        let display = window.display_handle().unwrap().as_raw();
        let options = ContextOptions {
            validation: true,
            window: Some(display),
            ..ContextOptions::default()
        };
        let Some(ctx) = context_with(options) else {
            return events.exit();
        };
        let handle = window.window_handle().unwrap().as_raw();
        // SAFETY: the handles are of the window, which is dropped after the context, and its display after that.
        let swapchain = unsafe { Swapchain::new(&ctx, display, handle, [320, 200], true) };
        let mut swapchain = swapchain.unwrap();
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let picture = Image::new(&ctx, "picture", [64, 48], Format::Bgra8Srgb, 1).unwrap();
        let mut shown = 0;
        for frame in 0..12 {
            match frame {
                3 => {
                    let _ = window.request_inner_size(PhysicalSize::new(200, 150));
                    swapchain.resize([200, 150]);
                }
                5 => swapchain.resize([0, 0]),
                7 => swapchain.resize([200, 150]),
                9 => swapchain.set_vsync(false),
                _ => {}
            }
            let mut rec = frames.begin().unwrap();
            let Some(image) = swapchain.acquire().unwrap() else {
                continue;
            };
            let target = swapchain.image(&image);
            let clear = |image| Targets {
                color: image,
                resolve: None,
                depth: None,
                depth_test: DepthTest::Greatest,
                clear: Some([0.2, 0.4, 0.6, 1.0]),
            };
            rec.pass("clear", &clear(target), |_| ());
            if target.format().matches(picture.format()) {
                rec.pass("picture", &clear(&picture), |_| ());
                rec.copy_image_to(&picture, target, [300, 10]);
                rec.copy_image_to(&picture, target, [10, 10]);
                rec.pass(
                    "interface",
                    &Targets {
                        clear: None,
                        ..clear(target)
                    },
                    |_| (),
                );
            }
            swapchain.present(&mut frames, rec, image).unwrap();
            shown += 1;
        }
        frames.wait_idle().unwrap();
        assert_silent(&ctx);
        // The semaphores of an image of before are gone.
        if let Some(old) = swapchain.acquire().unwrap() {
            swapchain.resize([180, 120]);
            let _new = swapchain.acquire().unwrap();
            let text = panic_text(|| {
                let _ = swapchain.image(&old);
            });
            assert!(text.contains("made again"), "{text}");
        }
        self.shown = Some(shown);
        events.exit();
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
}

#[test]
fn a_window_shows_pictures_while_it_changes() {
    if std::env::var_os("DISPLAY").is_none() {
        return eprintln!("skipped: no X11 display");
    }
    let events = EventLoop::builder()
        .with_x11()
        .with_any_thread(true)
        .build()
        .unwrap();
    let mut show = Show::default();
    events.run_app(&mut show).unwrap();
    // Two frames had no size.
    assert!([None, Some(10)].contains(&show.shown));
}
