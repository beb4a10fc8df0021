//! What a step records, as text.

use std::fmt::Write as _;

use myxo::gpu::{Listed, Reason};

use myxo::plain_text::counted;

/// One line a kernel or copy; one for each barrier and each pair that it separates, with the buffers; and one where an unordered
/// group begins or ends.
pub fn text(scene: &str, step: u64, listed: &[Listed]) -> String {
    let count = |is_one: fn(&Listed) -> bool| listed.iter().filter(|l| is_one(l)).count();
    let barriers = count(|l| matches!(l, Listed::Barrier(_)));
    let works = count(|l| matches!(l, Listed::Work(_)));
    let mut text = format!(
        "step {step} of {scene}: {works} kernels and copies, {}\n",
        counted(barriers, "barrier", "barriers")
    );
    for listed in listed {
        match listed {
            Listed::Work(name) => {
                let _ = writeln!(text, "{name}");
            }
            Listed::Unordered(reason) => {
                let _ = writeln!(text, "    in no order: {reason}");
            }
            Listed::Ordered => {
                let _ = writeln!(text, "    in order");
            }
            Listed::Barrier(reasons) => {
                let _ = writeln!(text, "    barrier");
                for (pair, buffers) in by_pair(reasons) {
                    let _ = writeln!(text, "        {}: {}", pair, buffers.join(", "));
                }
            }
        }
    }
    text
}

/// The two works of each wait, in the order in which they come first, and the buffers.
fn by_pair(reasons: &[Reason]) -> Vec<(String, Vec<&str>)> {
    let mut pairs: Vec<(String, Vec<&str>)> = Vec::new();
    for reason in reasons {
        let Reason { earlier, later, .. } = reason;
        // For the groups of an indirect dispatch, the way of reading needs no words.
        let by = match later.1 {
            "indirect" => ", for its groups",
            _ => "",
        };
        let pair = format!(
            "{} {} what {} {}{by}",
            later.0,
            if reason.later_writes {
                "writes"
            } else {
                "reads"
            },
            earlier.0,
            if reason.earlier_wrote {
                "wrote"
            } else {
                "read"
            },
        );
        match pairs.iter_mut().find(|(known, _)| *known == pair) {
            Some((_, buffers)) => buffers.push(&reason.buffer),
            None => pairs.push((pair, vec![&reason.buffer])),
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a list in which a barrier has no reason.
    #[test]
    fn every_barrier_has_its_reasons() {
        let reason = |buffer: &str, later_writes, access| Reason {
            buffer: buffer.to_owned(),
            earlier: ("advance", "kernel"),
            earlier_wrote: true,
            later: ("diffuse", access),
            later_writes,
        };
        let listed = [
            Listed::Work("advance".to_owned()),
            Listed::Barrier(vec![
                reason("deposits", false, "kernel"),
                reason("particles", true, "kernel"),
                reason("flow", false, "kernel"),
                reason("groups", false, "indirect"),
            ]),
            Listed::Work("diffuse".to_owned()),
        ];
        assert_eq!(
            text("torus", 7, &listed),
            "step 7 of torus: 2 kernels and copies, 1 barrier\n\
             advance\n    \
             barrier\n        \
             diffuse reads what advance wrote: deposits, flow\n        \
             diffuse writes what advance wrote: particles\n        \
             diffuse reads what advance wrote, for its groups: groups\n\
             diffuse\n"
        );
    }
}
