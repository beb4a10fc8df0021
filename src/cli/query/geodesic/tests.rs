//! Tests of the conversion, and of the device's walks against double precision.

use super::*;
use glam::DVec2;
use myxo::mesh::walk::{WalkEnd, WalkStatus, walk};

fn reference(surface: &Surface, queries: &[WalkQuery]) -> Result<Vec<WalkEnd>> {
    let end = |q: &WalkQuery| {
        walk(
            surface,
            q.start,
            q.heading,
            q.length,
            None,
            BorderRule::Stop,
        )
    };
    Ok(queries.iter().map(end).collect())
}

fn ask(mesh: &Mesh, rows: &str) -> Answers {
    let text = format!("id,face,b0,b1,b2,dx,dy,dz,length\n{rows}");
    let table = Table::parse("in.csv", text.as_bytes(), COLUMNS).expect("it is right");
    answer(mesh, &table, &reference).expect("it can be answered")
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(',')
        .map(|field| field.parse().expect("a number"))
        .collect()
}

#[test]
fn rows_that_cannot_be_walked_come_back_with_status_2() {
    let mesh = Mesh::builtin("cube").expect("it is built in");
    let answers = ask(
        &mesh,
        "a,99,1,0,0,1,0,0,1\nb,0,2,0,0,1,0,0,1\nc,0,1,0,0,0,0,0,1\nd,0,1,0,0,0,0,1,-1\n\
         e,-1,1,0,0,1,0,0,1\nf,99999999999,1,0,0,1,0,0,1\ng,0,1,0,0,1,0,0,1e300\n",
    );
    let lines: Vec<_> = answers.text.lines().skip(1).collect();
    assert_eq!(lines[0], "a,99,1,0,0,0,0,0,1,0,0,0,2");
    assert!(
        lines.len() == 7 && lines.iter().all(|line| line.ends_with(",2")),
        "{lines:#?}"
    );
    assert_eq!(answers.refused.len(), 7);
    assert_eq!(
        answers.refused[0],
        "in.csv: line 2: the mesh has no face 99 to walk on; the row gets status 2"
    );
    assert!(!answers.text.contains("NaN"), "{}", answers.text);
}

/// Would catch: an id that needs quotes and is written without them, so that its row has other columns or becomes a comment.
#[test]
fn ids_are_read_back_as_they_were() {
    let mesh = Mesh::builtin("cube").expect("it is built in");
    let ids = ["\"a,\"\"b\"\"\"", "\"two\nlines\"", "\"#1\"", "c d"];
    let rows = ids.map(|id| format!("{id},0,1,0,0,0,1,1,0\n"));
    let answers = ask(&mesh, &rows.concat()).text;
    let table = Table::parse("out.csv", answers.as_bytes(), &["id", "status"]);
    let table = table.expect("it has a column for each number");
    let ids: Vec<_> = table.rows().map(|row| row.text(0)).collect();
    assert_eq!(ids, ["a,\"b\"", "two\nlines", "#1", "c d"], "{answers}");
}

fn from_obj(text: &str) -> Mesh {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mesh.obj");
    std::fs::write(&path, text).expect("it can be written");
    Mesh::load_raw(&path).expect("it is right")
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The worked example of the format, and the same with one face wound the other way.
#[test]
fn the_worked_example_comes_out_as_written() {
    let rows =
        "a,0,0.25,0.5,0.25,0,1,0,0.45\nb,0,0.25,0.5,0.25,0,1,0,0.6\nc,0,0.25,0.5,0.25,0,1,0,2\n";
    let alike = from_obj(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
    let opposed = from_obj(&format!("{SQUARE}f 1 2 3\nf 1 4 3\n"));
    let flips = |mesh: &Mesh| (0..2).filter(|&triangle| mesh.is_flipped(triangle)).count();
    assert_eq!((flips(&alike), flips(&opposed)), (0, 1));
    let expected = [
        [
            0.0, 0.25, 0.05, 0.7, 0.75, 0.7, 0.0, 0.0, 1.0, 0.0, 0.45, 0.0,
        ],
        [
            1.0, 0.15, 0.75, 0.1, 0.75, 0.85, 0.0, 0.0, 1.0, 0.0, 0.6, 0.0,
        ],
        [
            1.0, 0.0, 0.75, 0.25, 0.75, 1.0, 0.0, 0.0, 1.0, 0.0, 0.75, 1.0,
        ],
    ];
    for (mesh, swapped) in [(&alike, false), (&opposed, true)] {
        let answers = ask(mesh, rows);
        let lines: Vec<_> = answers.text.lines().collect();
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[0], HEADER);
        for ((line, id), mut expected) in lines[1..].iter().zip(["a", "b", "c"]).zip(expected) {
            if swapped && expected[0] == 1.0 {
                expected.swap(2, 3);
            }
            let (found_id, found) = line.split_once(',').expect("there are columns");
            assert_eq!(found_id, id);
            for (found, expected) in numbers(found).iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-6,
                    "{line}, and {expected} is expected"
                );
            }
        }
    }
}

/// A start's weights, direction and length reach the engine in double precision, and its answer the text.
#[test]
fn no_digit_is_lost_on_the_way() {
    let mesh = from_obj(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
    let text = "id,face,b0,b1,b2,dx,dy,dz,length\nx,0,0.2499999999999999,0.5,0.2500000000000001,0,3e-200,0,0.12345678901234566\n";
    let table = Table::parse("in.csv", text.as_bytes(), COLUMNS).expect("it is right");
    let echo = |_: &Surface, queries: &[WalkQuery]| {
        let [query] = queries else {
            panic!("one query is asked")
        };
        assert_eq!((query.start.u, query.start.v), (0.5, 0.2500000000000001));
        assert_eq!(query.heading, DVec2::Y);
        Ok(vec![WalkEnd {
            point: query.start,
            heading: query.heading,
            travelled: query.length,
            status: WalkStatus::Done,
        }])
    };
    let answers = answer(&mesh, &table, &echo).expect("it can be answered");
    let line = answers.text.lines().nth(1).expect("one row");
    assert!(line.starts_with("x,0,0.2499999999999999,0.5,0.2500000000000001,0.7500000000000001,0.2500000000000001,0,0,1,0,"), "{line}");
    assert!(line.ends_with(",0.12345678901234566,0"), "{line}");
}

#[test]
fn weights_off_by_rounding_are_taken() {
    let mesh = Mesh::builtin("cube").expect("it is built in");
    let answers = ask(&mesh, "a,0,0.5000000001,-1e-9,0.5,1,1,1,0\n");
    assert!(answers.refused.is_empty(), "{:?}", answers.refused);
    let weights = &numbers(
        answers
            .text
            .lines()
            .nth(1)
            .expect("one row")
            .trim_start_matches("a,"),
    )[1..4];
    assert!(
        weights.iter().all(|&w| w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-12,
        "{weights:?}"
    );
}
