//! What other threads have done for the window. One that panics ends nothing but its own work, and the window says so.

use std::any::Any;
use std::thread::JoinHandle;

use myxo::{Error, Result};

/// What a thread has made; where it has panicked, an error that names the work.
pub fn joined<T, E>(work: &str, worker: JoinHandle<Result<T, E>>) -> Result<T>
where
    Error: From<E>,
{
    match worker.join() {
        Ok(made) => Ok(made?),
        Err(panic) => Err(Error::Invalid(format!(
            "{work} has failed: {}; this is a bug in myxo, please report it; nothing else is affected",
            words(&*panic)
        ))),
    }
}

/// What a panic says.
fn words(panic: &(dyn Any + Send)) -> &str {
    match (panic.downcast_ref::<&str>(), panic.downcast_ref::<String>()) {
        (Some(text), _) => text,
        (_, Some(text)) => text,
        _ => "it does not say why",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    #[test]
    fn a_panic_is_an_error_that_names_the_work() {
        let join = |work: fn() -> Result<u32>| joined("the work", thread::spawn(work));
        assert_eq!(join(|| Ok(7)).unwrap(), 7);
        let refused = join(|| Err(Error::Invalid("no".to_owned())));
        assert_eq!(refused.unwrap_err().to_string(), "no");
        for work in [(|| panic!("no room")) as fn() -> _, || {
            panic!("{} room", "no")
        }] {
            let said = join(work).unwrap_err().to_string();
            assert!(said.contains("the work has failed: no room;"), "{said}");
        }
        let said = join(|| std::panic::panic_any(7)).unwrap_err().to_string();
        assert!(said.contains("does not say why"), "{said}");
    }
}
