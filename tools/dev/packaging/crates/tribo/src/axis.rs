//! A force axis: the force loop with the feed-forward and its guard, in one struct.

use crate::refused::{done, text, Refused};
pub use tribo_sys::{AxisConfig, Breakaway, Controller, LEARNED_BYTES};

/// v = kp e + ki times the integral of e: kp 1e-6 to 1e5, ki_per_s 0 to 1e5 and times the sample time at most 2 kp. Tune it for the arm
/// without friction.
pub const fn pi(kp: f32, ki_per_s: f32) -> Controller {
    Controller { kind: 1, kp, ki_per_s }
}

/// A controller of yours between `error` and `command`.
pub const fn own() -> Controller {
    Controller { kind: 3, kp: 0.0, ki_per_s: 0.0 }
}

/// What is learned of breakaway at the usual force, in the positive and the negative direction, and what the guard says.
#[derive(Clone, Copy, Debug)]
pub struct AxisReport {
    pub breakaway_n: [f32; 2],
    /// Between low and high it is, at 95 %.
    pub low_n: [f32; 2],
    pub high_n: [f32; 2],
    /// Learned from.
    pub travel_n: f32,
    /// Work of the controller at a reversal: so many times less than without compensation; 0: not known yet.
    pub times_less: f32,
    /// Of friction that the guard lets through, 0 to 1.
    pub share: f32,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
    pub forgotten: u32,
    warnings: u32,
}

impl AxisReport {
    /// Sentences, each with its cause.
    pub fn warnings(&self) -> impl Iterator<Item = &'static str> {
        let mut left = self.warnings;
        core::iter::from_fn(move || {
            let sentence = unsafe { tribo_sys::tribo_sys_axis_warning(&mut left) };
            (!sentence.is_null()).then(|| text(sentence))
        })
    }
}

/// A force axis. `step` is the same C as in a drive; an axis may be moved, and sent to another thread.
pub struct Axis(tribo_sys::Axis);

impl Axis {
    /// At rest, nothing learned.
    pub fn new(config: &AxisConfig) -> Result<Self, Refused> {
        let mut axis = tribo_sys::Axis([0; 1664]);
        done(unsafe { tribo_sys::tribo_sys_axis_init(&mut axis, config) })?;
        Ok(Axis(axis))
    }

    /// u in N for the reference and the reading, within its limits whatever they are; NaN: there was no reading.
    pub fn step(&mut self, r: f32, y: f32) -> f32 {
        unsafe { tribo_sys::tribo_sys_axis_step(&mut self.0, r, y) }
    }

    /// The first half of a tick, with `own()`: the error for your controller.
    pub fn error(&mut self, r: f32, y: f32) -> f32 {
        unsafe { tribo_sys::tribo_sys_axis_error(&mut self.0, r, y) }
    }

    /// The second half: u in N for the output of your controller.
    pub fn command(&mut self, v: f32) -> f32 {
        unsafe { tribo_sys::tribo_sys_axis_command(&mut self.0, v) }
    }

    /// What the limit took from the last command: add it, times a gain, to your integral.
    pub fn excess(&self) -> f32 {
        unsafe { tribo_sys::tribo_sys_axis_excess(&self.0) }
    }

    /// Another config with the same sample time, between two ticks: u does not jump, and what is learned stays.
    pub fn change(&mut self, config: &AxisConfig) -> Result<(), Refused> {
        done(unsafe { tribo_sys::tribo_sys_axis_change(&mut self.0, config) })
    }

    /// Friction comes back in full, once the cause is found.
    pub fn restore(&mut self) {
        unsafe { tribo_sys::tribo_sys_axis_restore(&mut self.0) }
    }

    pub fn report(&mut self) -> AxisReport {
        let mut x = tribo_sys::AxisReport::default();
        unsafe { tribo_sys::tribo_sys_axis_report(&mut self.0, &mut x) };
        AxisReport {
            breakaway_n: x.breakaway_n,
            low_n: x.low_n,
            high_n: x.high_n,
            travel_n: x.travel_n,
            times_less: x.times_less,
            share: x.share,
            bad_inputs: x.bad_inputs,
            limited_ticks: x.limited_ticks,
            forgotten: x.forgotten,
            warnings: x.warnings,
        }
    }

    /// What is learned, to be kept over a loss of power.
    pub fn export(&mut self) -> [u8; LEARNED_BYTES] {
        let mut bytes = [0; LEARNED_BYTES];
        unsafe { tribo_sys::tribo_sys_axis_export(&mut self.0, bytes.as_mut_ptr()) };
        bytes
    }

    /// Takes over what an axis of the same rig has learned, at any time; u does not jump. A refusal changes nothing.
    pub fn import(&mut self, learned: &[u8]) -> Result<(), Refused> {
        done(unsafe { tribo_sys::tribo_sys_axis_import(&mut self.0, learned.as_ptr(), learned.len()) })
    }
}
