//! `myxo network`: the graph of a state as files.

use std::fs;

use serde_json::Value;

use crate::program::{Folder, done, failed, no_device, path};

/// Catches formats that say different things, nodes that no file names, a graph that is not of the state, and a picture without it.
#[test]
fn a_network_is_the_same_graph_in_every_format() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let files = ["a.json", "a.graphml", "a.csv", "series.csv", "a.png"];
    let files = files.map(|name| folder.file(name));
    let [json, graphml, csv, series, picture] = files.each_ref().map(|file| path(file));
    let scene = [
        "network",
        "cube",
        "--steps",
        "60",
        "--set",
        "particles.count=20000",
        "--set",
        "atlas.size=192",
    ];
    let out = [
        "--out",
        json,
        "--out",
        graphml,
        "--out",
        csv,
        "--out",
        picture,
        "--size",
        "320x180",
        "--series",
        series,
        "--network-every",
        "20",
    ];
    let said = done(&[&scene[..], &out].concat());
    assert!(
        said.contains("cube at step 60: state hash ") && said.contains("the network has "),
        "{said}"
    );
    let read = |file: &str| fs::read_to_string(file).expect("it was written");
    let graph: Value = serde_json::from_str(&read(json)).expect("it is JSON");
    let [nodes, edges] = ["nodes", "edges"].map(|key| graph[key].as_array().expect("it is a list"));
    assert!(
        nodes.len() > 5 && edges.len() > 5,
        "{} nodes, {} edges",
        nodes.len(),
        edges.len()
    );
    let measures = &graph["measures"];
    assert_eq!(
        (measures["nodes"].as_u64(), measures["edges"].as_u64()),
        (Some(nodes.len() as u64), Some(edges.len() as u64))
    );
    let lengths = edges
        .iter()
        .map(|edge| edge["length"].as_f64().expect("it has one"));
    assert!((lengths.sum::<f64>() - measures["length"].as_f64().expect("it has one")).abs() < 1e-9);
    let degrees = nodes
        .iter()
        .map(|node| node["degree"].as_u64().expect("it has one"));
    assert_eq!(degrees.sum::<u64>(), 2 * edges.len() as u64);
    assert_eq!(graph["objects"][0], "cube");
    let drawn = image::open(picture).expect("it is a picture").to_rgb8();
    let is_line = |pixel: &&image::Rgb<u8>| pixel.0[2] > 200 && pixel.0[0] < 150;
    assert_eq!(drawn.dimensions(), (320, 180));
    assert!(drawn.pixels().filter(is_line).count() > 50);
    let text = read(graphml);
    let count = |of: &str| text.matches(of).count();
    assert_eq!(
        (count("<node id="), count("<edge id=")),
        (nodes.len(), edges.len())
    );
    let rows: Vec<csv::StringRecord> = csv::Reader::from_path(csv)
        .expect("it was written")
        .records()
        .map(Result::unwrap)
        .collect();
    assert_eq!(rows.len(), edges.len());
    for (row, edge) in rows.iter().zip(edges) {
        let number = |column: usize| row[column].parse::<f64>().expect("it is a number");
        assert_eq!(
            [number(1), number(2), number(3)],
            ["from", "to", "length"].map(|key| edge[key].as_f64().unwrap())
        );
    }
    let rows: Vec<csv::StringRecord> = csv::Reader::from_path(series)
        .expect("it was written")
        .records()
        .map(Result::unwrap)
        .collect();
    let steps: Vec<&str> = rows.iter().map(|row| &row[0]).collect();
    assert_eq!(steps, ["20", "40", "60"]);
    assert_eq!(rows[2][1], nodes.len().to_string());
}

/// Catches a picture of `render --network` without the graph, and one that draws another graph than `network` does.
#[test]
fn pictures_with_the_network_are_those_of_the_graph() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let files = ["plain.png", "lines.png", "graph.png"].map(|name| folder.file(name));
    let [plain, lines, graph] = files.each_ref().map(|file| path(file));
    let scene = [
        "cube",
        "--steps=40",
        "--set=particles.count=20000",
        "--set=atlas.size=192",
        "--size=320x180",
        "--out",
    ];
    done(&[&["render"][..], &scene[..], &[plain]].concat());
    done(&[&["render"][..], &scene[..], &[lines, "--network"]].concat());
    done(&[&["network"][..], &scene[..], &[graph]].concat());
    let read = |file: &str| image::open(file).expect("it was written").into_rgba8();
    assert!(read(lines) == read(graph), "another graph is drawn");
    assert!(read(lines) != read(plain), "no graph is drawn");
}

#[test]
fn what_cannot_be_written_is_said_at_once() {
    let folder = Folder::new();
    let other = folder.file("a.txt");
    let said = failed(&["network", "cube", "--out", path(&other)]);
    assert!(
        said.contains("a.txt: a network is written as .json, .graphml or .csv, or drawn as .png"),
        "{said}"
    );
    let flat = folder.file("a.png");
    let said = failed(&[
        "network",
        "cube",
        "--set",
        "picture.show=atlas",
        "--out",
        path(&flat),
    ]);
    assert!(said.contains("the view atlas, which is flat"), "{said}");
    let (_, advice) = said.split_once("use --set ").expect("there is advice");
    let advised = [
        "network",
        "cube",
        "--steps",
        "2",
        "--size",
        "32x32",
        "--set",
        advice.trim(),
        "--out",
        path(&flat),
    ];
    done(&advised);
    let same = folder.file("a.csv");
    let said = failed(&[
        "network",
        "cube",
        "--out",
        path(&same),
        "--series",
        path(&same),
    ]);
    assert!(said.contains("a.csv"), "{said}");
}
