//! Tests of the conversion between rows and texels.

use super::*;

fn atlas(mesh: &Mesh, size: u32) -> Atlas {
    let options = options_of(AtlasMethod::Grid, size, GUTTER, 0);
    Atlas::build(&Surface::build(&[(mesh, 1.0)]), &options).expect("there is room")
}

fn read(mesh: &Mesh, rows: &str) -> Result<Vec<Spot>> {
    let text = format!("id,face,b0,b1,b2,amount\n{rows}");
    let table = Table::parse("in.csv", text.as_bytes(), COLUMNS).expect("it is right");
    table.rows().map(|row| Spot::read(row, mesh)).collect()
}

#[test]
fn deposits_come_out_where_they_were_put() {
    let mesh = Mesh::builtin("cube").expect("it is built in");
    let atlas = atlas(&mesh, 64);
    // Amounts far beyond what a float32 holds.
    let spots = read(
        &mesh,
        "a,0,0.25,0.5,0.25,3e50\nb,7,0.3,0.3,0.4,1e50\nc,0,0.25,0.5,0.25,0\n",
    )
    .expect("they are right");
    let trail = Trail::new(&atlas, &spots).expect("they can be held");
    let text = answer(&mesh, &atlas, &trail.values, trail.unit);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("face,b0,b1,b2,area,value,chart"));
    let rows: Vec<Vec<f64>> = lines
        .map(|line| {
            line.split(',')
                .map(|f| f.parse().expect("a number"))
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), atlas.owned_count as usize);
    let area: f64 = rows.iter().map(|row| row[4]).sum();
    assert!((area / 24.0 - 1.0).abs() < 1e-6, "{area}");
    let filled: Vec<&Vec<f64>> = rows.iter().filter(|row| row[5] > 0.0).collect();
    assert_eq!(filled.len(), 2);
    for row in filled {
        let (amount, place) = match row[0] {
            0.0 => (3e50, [0.25, 0.5, 0.25]),
            _ => (1e50, [0.3, 0.3, 0.4]),
        };
        assert!((row[5] * row[4] / amount - 1.0).abs() < 1e-6, "{row:?}");
        for (weight, there) in row[1..4].iter().zip(place) {
            assert!((weight - there).abs() < 0.1, "{row:?}");
        }
    }
}

#[test]
fn rows_that_cannot_be_deposited_are_named() {
    let mesh = Mesh::builtin("cube").expect("it is built in");
    for (row, problem) in [
        ("a,99,1,0,0,1", "the mesh has no face 99 to deposit on"),
        ("a,-1,1,0,0,1", "the mesh has no face -1 to deposit on"),
        (
            "a,0,0.5,0.6,0,1",
            "b0, b1, b2 are not weights that sum to 1",
        ),
        ("a,0,1,0,0,-1", "the amount is negative"),
        (
            "a,0,1,0,0,inf",
            "amount is `inf`, and a finite number is expected",
        ),
    ] {
        let error = read(&mesh, row).expect_err("it is wrong").to_string();
        assert_eq!(error, format!("in.csv: line 2: {problem}"));
    }
    let spots = read(&mesh, "a,0,1,0,0,1e308\nb,0,1,0,0,1e308\n").expect("each is right");
    let error = Trail::new(&atlas(&mesh, 64), &spots).expect_err("it overflows");
    assert!(error.to_string().contains("more than a number can hold"));
    // No deposits give no trail.
    let trail = Trail::new(&atlas(&mesh, 64), &[]).expect("it is right");
    assert!(trail.values.iter().all(|&value| value == 0.0) && trail.unit == 1.0);
}

#[test]
fn amounts_have_few_digits() {
    for (number, text) in [
        (deposited(&[]), "0"),
        (-0.0, "0"),
        (2.5, "2.5"),
        (1_200_000.0, "1200000"),
        (0.001, "0.001"),
        (1e300, "1e300"),
        (2.5e-9, "2.5e-9"),
    ] {
        assert_eq!(amount(number), text);
    }
}
