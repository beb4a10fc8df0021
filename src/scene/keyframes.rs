//! The list of keyframes in a scene file: `keyframes = [{ time = 0 }, { time = 2, position = [0, 1, 0] }]`.

use toml::de::{DeTable, DeValue};

use super::file::{describe, number, three};
use super::motion::Keyframe;
use super::parameters::{OutOfRange, inside};
use super::suggest::nearest;

/// Keyframes that one object may have.
const MOST: usize = 10_000;

/// Seconds.
const TIMES: (f64, f64) = (0.0, 1e6);
/// World units, to either side.
const FARTHEST: f64 = 1e9;
/// Degrees, to either side.
const MOST_TURNED: f64 = 36_000.0;

/// Reads the value of `key`, or returns its problem.
pub(super) fn read(key: &str, value: &DeValue<'_>) -> Result<Vec<Keyframe>, String> {
    let DeValue::Array(array) = value else {
        return Err(format!(
            "{key}: a list of keyframes such as {{ time = 1, position = [0, 1, 0] }} is expected, not {}",
            describe(value)
        ));
    };
    if array.len() > MOST {
        return Err(format!(
            "{key}: {} keyframes, and {MOST} are allowed",
            array.len()
        ));
    }
    let mut frames: Vec<Keyframe> = Vec::with_capacity(array.len());
    for (i, item) in array.iter().enumerate() {
        let key = format!("{key}.{i}");
        let DeValue::Table(table) = item.get_ref() else {
            return Err(format!(
                "{key}: a keyframe such as {{ time = 1, position = [0, 1, 0] }} is expected, not {}",
                describe(item.get_ref())
            ));
        };
        let frame = keyframe(&key, table)?;
        if let Some(before) = frames.last()
            && frame.time <= before.time
        {
            return Err(format!(
                "{key} is at {} s and the keyframe before it at {} s: their times must ascend",
                frame.time, before.time
            ));
        }
        frames.push(frame);
    }
    Ok(frames)
}

/// The problem of keyframes that were not read from a file, if any.
pub(super) fn check(key: &str, frames: &[Keyframe], problems: &mut Vec<OutOfRange>) {
    if frames.len() > MOST {
        problems.push(OutOfRange {
            key: key.to_owned(),
            value: format!("{} keyframes", frames.len()),
            allowed: format!("at most {MOST}"),
        });
    }
    let mut before = None;
    for (i, frame) in frames.iter().enumerate() {
        let Keyframe {
            time,
            position,
            rotation,
        } = *frame;
        let mut refuse = |name: &str, value: String, allowed: String| {
            problems.push(OutOfRange {
                key: format!("{key}.{i}.{name}"),
                value,
                allowed,
            });
        };
        match before {
            Some(before) if time <= before => {
                let allowed = format!("more than {before}, the time of the keyframe before it");
                refuse("time", time.to_string(), allowed);
            }
            _ if !inside(time.into(), TIMES) => {
                refuse(
                    "time",
                    time.to_string(),
                    "0 to 1,000,000 seconds".to_owned(),
                );
            }
            _ => (),
        }
        for (name, vector, most) in [
            ("position", position, FARTHEST),
            ("rotation", rotation, MOST_TURNED),
        ] {
            if !vector.iter().all(|&c| inside(c.into(), (-most, most))) {
                let allowed = format!("three numbers from -{most} to {most}");
                refuse(name, format!("{vector:?}"), allowed);
            }
        }
        before = Some(time);
    }
}

fn keyframe(key: &str, table: &DeTable<'_>) -> Result<Keyframe, String> {
    let mut frame = Keyframe {
        time: f32::NAN,
        position: [0.0; 3],
        rotation: [0.0; 3],
    };
    for (name, value) in table {
        let (name, value) = (name.get_ref().as_ref(), value.get_ref());
        let key = format!("{key}.{name}");
        match name {
            "time" => frame.time = seconds(&key, value)?,
            "position" => frame.position = vector(&key, value, FARTHEST)?,
            "rotation" => frame.rotation = vector(&key, value, MOST_TURNED)?,
            "scale" => {
                return Err(format!(
                    "{key}: an object cannot change its size while it runs, because walks are measured in world \
                     lengths: only position and rotation have keyframes"
                ));
            }
            _ => {
                let hint = nearest(name, ["time", "position", "rotation"].into_iter())
                    .map_or(String::new(), |near| format!("; did you mean {near}?"));
                return Err(format!(
                    "{key}: a keyframe has time, position and rotation{hint}"
                ));
            }
        }
    }
    if frame.time.is_nan() {
        return Err(format!("{key}: a keyframe needs a time, in seconds"));
    }
    Ok(frame)
}

fn seconds(key: &str, value: &DeValue<'_>) -> Result<f32, String> {
    match number(value) {
        Some(time) if inside(time, TIMES) => Ok(time as f32),
        Some(time) => Err(format!(
            "{key} = {time} is out of range: 0 to 1,000,000 seconds"
        )),
        None => Err(format!(
            "{key}: a number is expected, not {}",
            describe(value)
        )),
    }
}

fn vector(key: &str, value: &DeValue<'_>, most: f64) -> Result<[f32; 3], String> {
    let components = match value {
        DeValue::Array(array) => three(array),
        _ => None,
    };
    match components {
        Some(components) if components.iter().all(|&c| inside(c, (-most, most))) => {
            Ok(components.map(|c| c as f32))
        }
        Some(_) => Err(format!(
            "{key} is out of range: three numbers from -{most} to {most}"
        )),
        None => Err(format!(
            "{key}: a list of three numbers is expected, not {}",
            describe(value)
        )),
    }
}
