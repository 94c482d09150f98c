//! What the library refuses, and its sentences.

use core::{fmt, slice, str};

/// Why the library has refused: the field and its range, in words.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Refused(i32);

impl fmt::Display for Refused {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(text(unsafe { tribo_sys::tribo_sys_status_text(self.0) }))
    }
}

impl fmt::Debug for Refused {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Refused({self})")
    }
}

pub(crate) fn done(status: i32) -> Result<(), Refused> {
    if status == 0 {
        Ok(())
    } else {
        Err(Refused(status))
    }
}

/// Of the library's own sentences, which are constants.
pub(crate) fn text(sentence: *const u8) -> &'static str {
    let mut size = 0;
    unsafe {
        while *sentence.add(size) != 0 {
            size += 1;
        }
        str::from_utf8(slice::from_raw_parts(sentence, size)).unwrap_or("")
    }
}
