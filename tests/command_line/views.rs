//! `myxo render --view` and `--split`: what they show, and what they refuse.

use crate::program::{Folder, done, myxo, path, refused, text};

#[test]
fn views_are_listed_and_impossible_ones_are_refused_in_a_line() {
    let help = text(&myxo(&["render", "--help"]).stdout);
    for (word, words) in [
        ("relief", "raised by light"),
        ("nearest", "nearest other object"),
    ] {
        assert!(
            help.contains(&format!("{word}:")) && help.contains(words),
            "{help}"
        );
    }
    let folder = Folder::new();
    let file = folder.file("x.png");
    let render = |arguments: &[&str]| -> Vec<String> {
        let all = [
            &["render", "--size=64x48", "--out", path(&file)][..],
            arguments,
        ]
        .concat();
        all.into_iter().map(str::to_owned).collect()
    };
    for show in [
        &["--view", "distance"][..],
        &["--set", "picture.show=distance"],
    ] {
        let message = refused(1, &render(&[&["cube"], show].concat()));
        let says =
            "the view distance cannot be shown: it needs a second object, and there is only one";
        assert!(message.contains(says), "{message}");
    }
    let message = refused(1, &render(&["pair", "--view=nearest", "--steps=0"]));
    assert!(message.contains("use --steps 1 or more"), "{message}");
    let message = refused(1, &render(&["cube", "--view=atlas", "--split"]));
    assert!(message.contains("choose another --view"), "{message}");
    for (option, name) in [
        ("--aperture=0.1", "--aperture"),
        ("--passes=4", "--passes"),
        ("--network", "--network"),
    ] {
        let message = refused(1, &render(&["cube", "--view=atlas", option]));
        let says = format!("{name} has no effect on the view atlas, which is flat");
        assert!(message.contains(&says), "{message}");
    }
    refused(2, &render(&["cube", "--network", "--transparent"]));
    for option in [
        "--aperture=1.5",
        "--aperture=nan",
        "--passes=0",
        "--passes=5000",
    ] {
        refused(2, &render(&["cube", option]));
    }
    let message = refused(2, &render(&["cube", "--view=shiny"]));
    assert!(message.contains("wireframe"), "{message}");
    assert!(!file.exists());
}

#[test]
fn the_texture_stands_beside_the_chosen_view() {
    let folder = Folder::new();
    let of = |name: &str, more: &[&str]| {
        let file = folder.file(name);
        let set = [
            "--set=particles.count=2000",
            "--set=atlas.size=64",
            "--steps=5",
        ];
        let fixed = ["--set=picture.brightest=5", "--out", path(&file)];
        let arguments = [&["render", "cube"][..], &set, &fixed, more].concat();
        done(&arguments);
        image::open(&file).expect("it is a picture").into_rgba8()
    };
    let split = of("split.png", &["--split", "--view=relief", "--size=121x60"]);
    let relief = of("relief.png", &["--view=relief", "--size=61x60"]);
    let atlas = of("atlas.png", &["--view=atlas", "--size=60x60"]);
    assert_eq!(split.dimensions(), (121, 60));
    for (x, y, pixel) in split.enumerate_pixels() {
        let expected = match x {
            0..61 => relief.get_pixel(x, y),
            _ => atlas.get_pixel(x - 61, y),
        };
        assert_eq!(pixel, expected, "({x}, {y})");
    }
}

/// Would catch: a lens that leaves the outline as sharp as it was, and more passes that change the picture or leave it as it is.
#[test]
fn pictures_are_means_of_many_through_a_lens_or_from_one_place() {
    let folder = Folder::new();
    let of = |name: &str, more: &[&str]| {
        let file = folder.file(name);
        let set = [
            "--set=particles.count=2000",
            "--set=atlas.size=64",
            "--steps=5",
            "--size=96x80",
            "--transparent",
        ];
        let fixed = ["--set=picture.brightest=5", "--out", path(&file)];
        done(&[&["render", "cube"][..], &set, &fixed, more].concat());
        image::open(&file).expect("it is a picture").into_rgba8()
    };
    let partly_covered = |picture: &image::RgbaImage| {
        let partly = |pixel: &&image::Rgba<u8>| (30..225).contains(&pixel.0[3]);
        picture.pixels().filter(partly).count()
    };
    let difference = |a: &image::RgbaImage, b: &image::RgbaImage| {
        let pairs = a.as_raw().iter().zip(b.as_raw());
        let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        sum as f64 / a.as_raw().len() as f64
    };
    let plain = of("plain.png", &[]);
    let smooth = of("smooth.png", &["--passes=8"]);
    let wide = of("wide.png", &["--aperture=0.3"]);
    let again = of("again.png", &["--aperture=0.3", "--passes=32"]);
    assert!(wide == again);
    let change = difference(&plain, &smooth);
    assert!((0.01..2.0).contains(&change), "{change}");
    let [plain, smooth, wide] = [&plain, &smooth, &wide].map(partly_covered);
    assert!(
        2 * smooth < 3 * plain && wide > 2 * plain,
        "{plain}, {smooth}, {wide}"
    );
}
