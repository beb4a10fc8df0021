//! Short forms for the rows of the parameter tables.

macro_rules! real {
    // The slider covers the whole range.
    ($($field:ident).+, $range:expr, $scale:ident) => {
        real!($($field).+, $range, $range, $scale)
    };
    ($($field:ident).+, $range:expr, $slider:expr, $scale:ident) => {
        Kind::Number(Number {
            range: $range,
            slider: $slider,
            scale: Scale::$scale,
            integer: false,
            is_double: false,
            get: |s| s.$($field).+ as f64,
            set: |s, value| s.$($field).+ = value as f32,
        })
    };
}

/// A time, which may be late.
macro_rules! time {
    ($($field:ident).+, $range:expr, $slider:expr) => {
        Kind::Number(Number {
            range: $range,
            slider: $slider,
            scale: Scale::Linear,
            integer: false,
            is_double: true,
            get: |s| s.$($field).+,
            set: |s, value| s.$($field).+ = value,
        })
    };
}

macro_rules! whole {
    ($($field:ident).+: $type:ty, $range:expr, $slider:expr, $scale:ident) => {
        Kind::Number(Number {
            range: $range,
            slider: $slider,
            scale: Scale::$scale,
            integer: true,
            is_double: false,
            get: |s| s.$($field).+ as f64,
            set: |s, value| s.$($field).+ = value.round() as $type,
        })
    };
}

macro_rules! word {
    ($($field:ident).+: $type:ty) => {
        Kind::Choice {
            words: <$type>::WORDS,
            get: |s| s.$($field).+ as usize,
            set: |s, i| s.$($field).+ = <$type>::ALL[i],
        }
    };
}

macro_rules! text {
    ($($field:ident).+, $what:literal, $is_path:literal) => {
        Kind::Text {
            what: $what,
            is_path: $is_path,
            get: |s| s.$($field).+.as_str(),
            set: |s, value| s.$($field).+ = value,
        }
    };
}

macro_rules! vector {
    ($($field:ident).+, $range:expr) => {
        Kind::Vector {
            range: $range,
            is_double: false,
            get: |s| s.$($field).+.map(f64::from),
            set: |s, value| s.$($field).+ = value.map(|value| value as f32),
        }
    };
}

/// A place, which may be far from the origin.
macro_rules! place {
    ($($field:ident).+) => {
        Kind::Vector {
            range: (-1e12, 1e12),
            is_double: true,
            get: |s| s.$($field).+,
            set: |s, value| s.$($field).+ = value,
        }
    };
}

/// A number that an object may have of its own.
macro_rules! own {
    (real $part:ident.$field:ident: $type:ident, $range:expr, $slider:expr, $scale:ident) => {
        own!(
            false,
            |value| value as $type,
            $part.$field,
            $range,
            $slider,
            $scale
        )
    };
    (whole $part:ident.$field:ident: $type:ident, $range:expr, $slider:expr, $scale:ident) => {
        own!(
            true,
            |value| value.round() as $type,
            $part.$field,
            $range,
            $slider,
            $scale
        )
    };
    ($integer:literal, $typed:expr, $part:ident.$field:ident, $range:expr, $slider:expr, $scale:ident) => {
        Kind::Own(Own {
            range: $range,
            slider: $slider,
            scale: Scale::$scale,
            integer: $integer,
            get: |s| s.$part.$field.map(f64::from),
            shared: |settings| f64::from(settings.$part.$field),
            set: |s, value| s.$part.$field = value.map($typed),
        })
    };
}
