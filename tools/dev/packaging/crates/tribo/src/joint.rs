//! A joint with current and encoder, beside a loop of yours.

use core::{fmt, mem::size_of};

use crate::refused::{done, text, Refused};
pub use tribo_sys::JointConfig;

/// Why the guard has taken the friction term out, until `restore`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It has not.
    Sound,
    /// The joint moved away from its reference, with its friction term: pass its load.
    Astray,
    /// It went to and fro about a resting reference.
    Hunting,
    /// Moving it gave energy: the sign of effort or encoder is wrong, or the loop rattles.
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

impl From<tribo_sys::JointReport> for Report {
    fn from(now: tribo_sys::JointReport) -> Self {
        let cause = match now.cause {
            0 => Cause::Sound,
            1 => Cause::Astray,
            2 => Cause::Hunting,
            _ => Cause::Reversed,
        };
        Report {
            friction: now.friction,
            low: now.low,
            high: now.high,
            load: now.load,
            share: now.share,
            is_learned: now.is_learned != 0,
            cause,
            bad_inputs: now.bad_inputs,
            limited_ticks: now.limited_ticks,
        }
    }
}

macro_rules! joint {
    ($(#[$doc:meta])* $name:ident, $sys:ident, $memory:ident, $number:ty) => {
        $(#[$doc])*
        pub struct $name(tribo_sys::$memory);

        impl $name {
            /// At rest, nothing learned.
            pub fn new(config: &JointConfig) -> Result<Self, Refused> {
                let mut joint = tribo_sys::$memory([0; size_of::<tribo_sys::$memory>()]);
                done(unsafe { tribo_sys::$sys::joint_init(&mut joint, config) })?;
                Ok($name(joint))
            }

            /// u for the drive: `effort` of your loop, and friction. Within its limit whatever comes in; a bad input counts as none, or as no motion.
            pub fn step(&mut self, effort: $number, q_ref: $number, q: $number) -> $number {
                unsafe { tribo_sys::$sys::joint_step(&mut self.0, effort, q_ref, q) }
            }

            /// The load by a model of the arm, e.g. gravity, as effort: added to u from the next tick on, and not learned.
            pub fn load(&mut self, load: $number) {
                unsafe { tribo_sys::$sys::joint_load(&mut self.0, load) }
            }

            /// Another gain, 0 to 1; the term follows with a time constant of 0.1 s, upwards with the actuator's lag if that is longer.
            pub fn gain(&mut self, gain: f32) -> Result<(), Refused> {
                done(unsafe { tribo_sys::$sys::joint_gain(&mut self.0, gain) })
            }

            /// At rest: the next tick is the first one, with what is learned. For the tick after the drive was off.
            pub fn rest(&mut self) {
                unsafe { tribo_sys::$sys::joint_rest(&mut self.0) }
            }

            /// The term comes back, once the cause is found.
            pub fn restore(&mut self) {
                unsafe { tribo_sys::$sys::joint_restore(&mut self.0) }
            }

            /// The end-point force from current, with its interval, in the unit of the config.
            pub fn force(&self) -> Force {
                let mut x = [0.0; 3];
                unsafe { tribo_sys::$sys::joint_force(&self.0, x.as_mut_ptr()) };
                Force { force: x[0], low: x[1], high: x[2] }
            }

            /// Not for the tick.
            pub fn report(&self) -> Report {
                let mut now = tribo_sys::JointReport::default();
                unsafe { tribo_sys::$sys::joint_report(&self.0, &mut now) };
                now.into()
            }
        }
    };
}

joint!(
    /// Takes friction out of a joint, in float32. `step` is the same C as in a drive; a joint may be moved, and sent to another thread.
    Joint,
    f32,
    JointF32,
    f32
);

joint!(
    /// Takes friction out of a joint, in fixed point: effort, load and u are Q31 of the config's `effort_max`, positions are counts of the encoder,
    /// which may wrap. The config's `travel` is 1 to 1e4 counts.
    ///
    /// ```
    /// use tribo::{JointConfig, JointQ31};
    /// let config = JointConfig { sample_time_s: 1e-3, effort_max: 3.0, travel: 4.0, breakaway: 0.3, actuator_pole_rad_per_s: 0.0, gain: 0.97, wrap: 0.0 };
    /// let mut joint = JointQ31::new(&config)?; // N m and counts
    /// let u = joint.step(1 << 29, 1200, 1196); // i32::MAX is 3 N m
    /// # assert!(u > 0);
    /// # Ok::<(), tribo::Refused>(())
    /// ```
    JointQ31,
    q31,
    JointQ31,
    i32
);

impl fmt::Display for Cause {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(text(unsafe { tribo_sys::tribo_sys_joint_cause_text(*self as i32) }))
    }
}
