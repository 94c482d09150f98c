//! A joint with current and encoder, beside a loop of yours.

use core::fmt;

use crate::refused::{done, text, Refused};
pub use tribo_sys::JointConfig;

/// Why the guard has taken the friction term out, until `restore`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It has not.
    Sound,
    /// The joint moved away from its reference, with its friction term.
    Astray,
    /// It went to and fro about a resting reference.
    Hunting,
    /// Moving it gave energy: the sign of effort or encoder is wrong.
    Reversed,
}

/// Learned friction with the interval in which it is, in the unit of effort.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    pub friction: f32,
    pub low: f32,
    pub high: f32,
    /// That does not reverse; the loop holds it.
    pub load: f32,
    /// Of the term that the guard lets through, 0 to 1.
    pub share: f32,
    /// False: `friction` is as configured.
    pub is_learned: bool,
    pub cause: Cause,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
}

/// What the joint does to its surroundings, less what holds it.
#[derive(Clone, Copy, Debug)]
pub struct Force {
    pub force: f32,
    pub low: f32,
    pub high: f32,
}

/// Takes friction out of a joint. `step` is the same C as in a drive; a joint may be moved, and sent to another thread.
pub struct Joint(tribo_sys::Joint);

impl Joint {
    /// At rest, nothing learned.
    pub fn new(config: &JointConfig) -> Result<Self, Refused> {
        let mut joint = tribo_sys::Joint([0; 320]);
        done(unsafe { tribo_sys::tribo_sys_joint_init(&mut joint, config) })?;
        Ok(Joint(joint))
    }

    /// u for the drive: `effort` of your loop, and friction. Within its limit whatever comes in; a bad input counts as none, or as no motion.
    pub fn step(&mut self, effort: f32, q_ref: f32, q: f32) -> f32 {
        unsafe { tribo_sys::tribo_joint_f32_step(&mut self.0, effort, q_ref, q) }
    }

    /// The load by a model of the arm, e.g. gravity, as effort: added to u from the next tick on, and not learned.
    pub fn load(&mut self, load: f32) {
        unsafe { tribo_sys::tribo_joint_f32_load(&mut self.0, load) }
    }

    /// Another gain, 0 to 1; the term follows in a third of a second.
    pub fn gain(&mut self, gain: f32) -> Result<(), Refused> {
        done(unsafe { tribo_sys::tribo_sys_joint_gain(&mut self.0, gain) })
    }

    /// The term comes back, once the cause is found.
    pub fn restore(&mut self) {
        unsafe { tribo_sys::tribo_joint_f32_restore(&mut self.0) }
    }

    /// The end-point force from current, with its interval.
    pub fn force(&self) -> Force {
        let mut x = [0.0; 3];
        unsafe { tribo_sys::tribo_sys_joint_force(&self.0, x.as_mut_ptr()) };
        Force { force: x[0], low: x[1], high: x[2] }
    }

    pub fn report(&self) -> Report {
        let mut x = tribo_sys::JointReport::default();
        unsafe { tribo_sys::tribo_sys_joint_report(&self.0, &mut x) };
        let cause = match x.cause {
            0 => Cause::Sound,
            1 => Cause::Astray,
            2 => Cause::Hunting,
            _ => Cause::Reversed,
        };
        Report {
            friction: x.friction,
            low: x.low,
            high: x.high,
            load: x.load,
            share: x.share,
            is_learned: x.is_learned != 0,
            cause,
            bad_inputs: x.bad_inputs,
            limited_ticks: x.limited_ticks,
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(text(unsafe { tribo_sys::tribo_sys_joint_cause_text(*self as i32) }))
    }
}
