//! Devices, pipes and folders where a file is read: each is refused with one message, and nothing waits or reads forever.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use crate::program::{Folder, path, program, refusal, text, wait_until};

/// Every way to name a file that is read: arguments in which `FILE` stands for it, with the ending that it must have, and a
/// scene file or model that names it.
const INPUTS: &[(&str, &str, &str)] = &[
    ("a scene", "toml", "render FILE --out OUT"),
    ("a model", "obj", "render FILE --out OUT"),
    ("a GLB model", "glb", "render FILE --out OUT"),
    ("a model to lay out", "stl", "atlas FILE"),
    ("a preset", "toml", "render cube --preset FILE --out OUT"),
    (
        "a checkpoint",
        "state",
        "render cube --resume FILE --out OUT",
    ),
    (
        "a checkpoint with its scene",
        "state",
        "render --resume FILE --out OUT",
    ),
    (
        "a map of areas",
        "png",
        "render cube --set areas.map=\"FILE\" --out OUT",
    ),
    (
        "a mask",
        "png",
        "render cube --set particles.start=\"mask\" --set particles.start_mask=\"FILE\" --out OUT",
    ),
    (
        "a mesh of a query",
        "ply",
        "query geodesic --mesh FILE --in WALKS",
    ),
    (
        "a table of a query",
        "csv",
        "query geodesic --mesh builtin:cube --in FILE",
    ),
    (
        "a scene of a query",
        "json",
        "query sdf --scene FILE --in WALKS",
    ),
    ("a report", "json", "compare FILE FILE"),
    ("the model of a scene", "ply", "render SCENE --out OUT"),
    ("the buffer of a glTF model", "bin", "render GLTF --out OUT"),
];

/// Kinds of special files, and how to create them.
type Kind<'a> = (&'a str, &'a dyn Fn(&Path));

/// A run that is killed at the end of the test.
struct Running(Option<Child>);

impl Running {
    fn has_ended(&mut self) -> bool {
        let run = self.0.as_mut().expect("its output was not taken");
        run.try_wait().expect("it can be asked").is_some()
    }

    fn output(mut self) -> Output {
        let run = self.0.take().expect("its output was not taken");
        run.wait_with_output().expect("it has ended")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(run) = &mut self.0 {
            let _ = run.kill();
            let _ = run.wait();
        }
    }
}

/// Catches every reader that opens its file without checking the kind: it would wait for a pipe without a writer, and read from the device
/// until the memory is full.
#[test]
fn special_files_are_refused_wherever_files_are_read() {
    let folder = Folder::new();
    let walks = folder.with("walks.csv", "id,face,b0,b1,b2,dx,dy,dz,length\n");
    let device = |name: &Path| symlink("/dev/zero", name).expect("it can be made");
    let pipe = |name: &Path| {
        let made = Command::new("mkfifo").arg(name).status();
        assert!(made.expect("it is installed").success());
    };
    let folder_at = |name: &Path| std::fs::create_dir(name).expect("it can be made");
    let kinds: [Kind; 3] = [("zero", &device), ("pipe", &pipe), ("folder", &folder_at)];
    for (kind, make) in kinds {
        for (what, ending, arguments) in INPUTS {
            let file = folder.file(format!("{kind}.{ending}"));
            if file.symlink_metadata().is_err() {
                make(&file);
            }
            let name = path(&file);
            let scene = format!("[[object]]\nmesh = \"{name}\"\n");
            let scene = folder.with("names_it.toml", scene);
            let gltf = format!(
                "{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{{\"byteLength\":36,\"uri\":\"{kind}.{ending}\"}}],\
                 \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\
                 \"count\":3,\"type\":\"VEC3\"}}],\"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
                 \"nodes\":[{{\"mesh\":0}}],\"scenes\":[{{\"nodes\":[0]}}],\"scene\":0}}"
            );
            let gltf = folder.with("names_it.gltf", gltf);
            let out = folder.file("out.png");
            let words = arguments.split(' ').map(|word| {
                word.replace("FILE", name)
                    .replace("OUT", path(&out))
                    .replace("WALKS", path(&walks))
                    .replace("SCENE", path(&scene))
                    .replace("GLTF", path(&gltf))
            });
            let mut run = program();
            run.args(words)
                .stdout(Stdio::piped())
                .stderr(Stdio::piped());
            let mut running = Running(Some(run.spawn().expect("the program starts")));
            wait_until(
                &format!("{what} that is a {kind}"),
                Duration::from_secs(30),
                || running.has_ended(),
            );
            let output = running.output();
            let code = if arguments.starts_with("compare") {
                2
            } else {
                1
            };
            let message = refusal(code, &output);
            let is_named = message.contains(&format!("{kind}.{ending}"));
            assert!(
                is_named && message.lines().count() <= 2,
                "{what}, {kind}: {message}"
            );
            assert!(!out.exists(), "{what}, {kind}");
            assert_eq!(text(&output.stdout), "");
        }
    }
}
