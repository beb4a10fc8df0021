//! Thinning: covered texels are taken away from the outside until lines are left, without a change of what is connected or enclosed.
//!
//! Texels that touch are the complex of all sets of texels that touch each other (a flag complex). A texel may go if those beside it are
//! contractible: then the rest is homotopy equivalent to the whole (Attali, Lieutier and Salinas, "Vietoris-Rips complexes also provide
//! topologically correct reconstructions of sampled shapes", 2013). No grid is needed, so seams and contacts are as any other place.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::links::Links;

/// More neighbours than this are not looked at: the texel stays.
const MOST: usize = 64;

/// Which texels are left. Outer ones go first, and of these the ones with less trail; ends of lines stay.
pub fn thinned(links: &Links, depths: &[f64], trail: &[f32]) -> Vec<bool> {
    let count = links.texels.len();
    let mut stays = vec![true; count];
    let mut is_queued = vec![true; count];
    let key = |i: u32| {
        let value = trail[links.texels[i as usize] as usize];
        // Positive numbers are in the order of their bits.
        Reverse((depths[i as usize].to_bits(), value.max(0.0).to_bits(), i))
    };
    let mut queue: BinaryHeap<_> = (0..count as u32).map(key).collect();
    let mut beside = Vec::new();
    let may_go = |i: u32, stays: &[bool], beside: &mut Vec<u32>, least: usize| {
        beside.clear();
        let all = links.beside[i as usize].iter().copied();
        beside.extend(all.filter(|&other| stays[other as usize]));
        (least..=MOST).contains(&beside.len()) && is_contractible(links, beside)
    };
    while let Some(Reverse((_, _, i))) = queue.pop() {
        is_queued[i as usize] = false;
        // With two neighbours it is the tip of a line of two texels' width, which would be eaten up from its end.
        if !may_go(i, &stays, &mut beside, 3) {
            continue;
        }
        stays[i as usize] = false;
        for &other in &beside {
            if !is_queued[other as usize] {
                is_queued[other as usize] = true;
                queue.push(key(other));
            }
        }
    }
    // What is left is thin but for steps and tips, each of which loses a texel at most.
    for i in 0..count as u32 {
        if stays[i as usize] && may_go(i, &stays, &mut beside, 2) {
            stays[i as usize] = false;
        }
    }
    stays
}

/// Are these texels, with all sets of them that touch each other, contractible? One that touches all that another touches dominates that
/// one, which can go (Barmak and Minian, "Strong homotopy types, nerves and collapses", 2012); if one is left, they are.
fn is_contractible(links: &Links, texels: &[u32]) -> bool {
    let mut beside = [0_u64; MOST];
    for (i, &texel) in texels.iter().enumerate() {
        let all = &links.beside[texel as usize];
        for (k, other) in texels.iter().enumerate() {
            if i == k || all.binary_search(other).is_ok() {
                beside[i] |= 1 << k;
            }
        }
    }
    let mut left = if texels.len() == MOST {
        u64::MAX
    } else {
        (1 << texels.len()) - 1
    };
    loop {
        if left.count_ones() == 1 {
            return true;
        }
        let numbers = || (0..texels.len()).filter(|&i| left >> i & 1 == 1);
        let is_dominated = |&i: &usize| {
            let own = beside[i] & left;
            numbers().any(|k| k != i && own & !beside[k] == 0)
        };
        let Some(gone) = numbers().find(is_dominated) else {
            return false;
        };
        left &= !(1 << gone);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use glam::DVec3;

    use super::*;

    /// Texels of a drawing, linked by sides and corners.
    fn drawn(rows: &[&str]) -> Links {
        let places: Vec<(i64, i64)> = (0..)
            .zip(rows)
            .flat_map(|(y, row)| {
                let marks = (0..).zip(row.bytes());
                marks
                    .filter(|(_, mark)| *mark == b'#')
                    .map(move |(x, _)| (x, y))
            })
            .collect();
        let touch = |a: &(i64, i64), b: &(i64, i64)| {
            a != b && (a.0 - b.0).abs() < 2 && (a.1 - b.1).abs() < 2
        };
        let beside = |a: &(i64, i64)| {
            let others = (0..).zip(&places).filter(|(_, b)| touch(a, b));
            others.map(|(i, _)| i).collect()
        };
        let sides = |(x, y): &(i64, i64)| [(x + 1, *y), (x - 1, *y), (*x, y + 1), (*x, y - 1)];
        Links {
            texels: (0..places.len() as u32).collect(),
            beside: places.iter().map(beside).collect(),
            is_border: places
                .iter()
                .map(|a| sides(a).iter().any(|b| !places.contains(b)))
                .collect(),
            places: places
                .iter()
                .map(|&(x, y)| DVec3::new(x as f64, y as f64, 0.0))
                .collect(),
            sides: vec![1.0; places.len()],
            objects: vec![0; places.len()],
            glued: HashMap::new(),
        }
    }

    /// How many are left, how many ends they have, and links less texels (which for lines is cycles less parts).
    fn left(rows: &[&str]) -> (usize, usize, i64) {
        let links = drawn(rows);
        let stays = thinned(&links, &links.depths(), &vec![1.0; links.texels.len()]);
        let degrees = (0..links.texels.len()).filter(|&i| stays[i]).map(|i| {
            let beside = links.beside[i].iter();
            beside.filter(|&&other| stays[other as usize]).count()
        });
        let degrees: Vec<_> = degrees.collect();
        let ends = degrees.iter().filter(|&&degree| degree == 1).count();
        let links = degrees.iter().sum::<usize>() as i64 / 2;
        (degrees.len(), ends, links - degrees.len() as i64)
    }

    /// Catches holes that are filled, lines that are cut or shortened, and blobs that leave more than a texel.
    #[test]
    fn lines_and_holes_stay_and_blobs_become_thin() {
        let (count, ends, cycles) = left(&["##########", "##########", "##########"]);
        assert!(
            (7..=14).contains(&count) && (2..=4).contains(&ends) && cycles == -1,
            "a bar: {count}, {ends}"
        );
        let (count, ends, cycles) = left(&["#####", "#####", "#####", "#####", "#####"]);
        assert!(
            count <= 9 && cycles == -1 && ends <= 4,
            "a blob: {count}, {ends}"
        );
        let ring = ["######", "######", "##..##", "##..##", "######", "######"];
        let (count, ends, cycles) = left(&ring);
        // Corners may leave spurs, which are removed later.
        assert!(
            (8..=16).contains(&count) && ends <= 4 && cycles == 0,
            "a ring: {count}, {ends}, {cycles}"
        );
        let arm = ["......##......"; 6];
        let beam = ["##############"; 2];
        let cross = [&arm[..], &beam, &arm].concat();
        let (_, ends, cycles) = left(&cross);
        assert!(ends >= 4 && cycles >= -1, "a cross: {ends}, {cycles}");
        assert_eq!(left(&["#"]), (1, 0, -1));
        // A hole of one texel is one.
        let (_, ends, cycles) = left(&["###", "#.#", "###"]);
        assert!(ends == 0 && cycles == 0);
    }
}
