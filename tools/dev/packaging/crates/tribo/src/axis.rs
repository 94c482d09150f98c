//! A force axis: the force loop with the feed-forward and its guard, in one struct.

use core::mem::size_of;

use crate::refused::{done, text, Refused};
pub use tribo_sys::{AxisConfig, Breakaway, Controller, Section, LEARNED_BYTES, SECTIONS_MAX};

const NONE: Controller = Controller {
    kind: 0,
    kp: 0.0,
    ki_per_s: 0.0,
    section_count: 0,
    sections: [Section { b0: 0.0, b1: 0.0, b2: 0.0, a1: 0.0, a2: 0.0 }; SECTIONS_MAX],
};

/// v = kp e + ki times the integral of e: kp 1e-6 to 1e5, ki_per_s 0 to 1e5 and times the sample time at most 2 kp. Tune it for the arm
/// without friction.
pub const fn pi(kp: f32, ki_per_s: f32) -> Controller {
    Controller { kind: 1, kp, ki_per_s, ..NONE }
}

/// One to `SECTIONS_MAX` sections for the sample time, the first nearest to e.
pub fn sections(sections: &[Section]) -> Controller {
    let mut controller = Controller { kind: 2, section_count: sections.len().try_into().unwrap_or(u32::MAX), ..NONE };
    for (own, given) in controller.sections.iter_mut().zip(sections) {
        *own = *given;
    }
    controller
}

/// The paper's, for 1 ms and an arm like the paper's.
pub const fn paper() -> Controller {
    Controller { kind: 4, ..NONE }
}

/// A controller of yours between `error` and `command`.
pub const fn own() -> Controller {
    Controller { kind: 3, ..NONE }
}

/// What is learned of breakaway at the usual force, in the positive and the negative direction, and what the guard says.
#[derive(Clone, Copy, Debug)]
pub struct AxisReport {
    pub breakaway_n: [f32; 2],
    /// Between low and high it is, at 95 % if the rig is as configured.
    pub low_n: [f32; 2],
    pub high_n: [f32; 2],
    /// Multiply the configured breakaway by it and make a new axis: 3 or 0.2 if it is far off, otherwise 1.
    pub breakaway_factor: f32,
    /// Learned from.
    pub travel_n: f32,
    /// Work of the controller (not error) at a reversal: so many times less than without compensation; 0: not known.
    pub times_less: f32,
    /// Of friction that the guard lets through, 0 to 1.
    pub share: f32,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
    pub forgotten: u32,
    /// Samples that were not learned from in time.
    pub late: u32,
    warnings: u32,
}

impl From<tribo_sys::AxisReport> for AxisReport {
    fn from(now: tribo_sys::AxisReport) -> Self {
        AxisReport {
            breakaway_n: now.breakaway_n,
            low_n: now.low_n,
            high_n: now.high_n,
            breakaway_factor: now.breakaway_factor,
            travel_n: now.travel_n,
            times_less: now.times_less,
            share: now.share,
            bad_inputs: now.bad_inputs,
            limited_ticks: now.limited_ticks,
            forgotten: now.forgotten,
            late: now.late,
            warnings: now.warnings,
        }
    }
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

macro_rules! axis {
    ($(#[$doc:meta])* $name:ident, $sys:ident, $memory:ident, $force:ty) => {
        $(#[$doc])*
        pub struct $name(tribo_sys::$memory);

        impl $name {
            fn made(config: &AxisConfig, full_scale_n: f32) -> Result<Self, Refused> {
                let mut axis = tribo_sys::$memory([0; size_of::<tribo_sys::$memory>()]);
                done(unsafe { tribo_sys::$sys::axis_init(&mut axis, config, full_scale_n) })?;
                Ok($name(axis))
            }

            /// u for the reference and the reading, within its limits whatever they are.
            pub fn step(&mut self, r: $force, y: $force) -> $force {
                unsafe { tribo_sys::$sys::axis_step(&mut self.0, r, y) }
            }

            /// The first half of a tick, with `own()`: the error for your controller.
            pub fn error(&mut self, r: $force, y: $force) -> $force {
                unsafe { tribo_sys::$sys::axis_error(&mut self.0, r, y) }
            }

            /// The second half: u for the output of your controller.
            pub fn command(&mut self, v: $force) -> $force {
                unsafe { tribo_sys::$sys::axis_command(&mut self.0, v) }
            }

            /// What the limit took from the last command: add it, times a gain, to your integral.
            pub fn excess(&self) -> $force {
                unsafe { tribo_sys::$sys::axis_excess(&self.0) }
            }

            /// Another config with the same sample time, between two ticks: u does not jump, and what is learned stays.
            pub fn change(&mut self, config: &AxisConfig) -> Result<(), Refused> {
                done(unsafe { tribo_sys::$sys::axis_change(&mut self.0, config) })
            }

            /// At rest: the next tick is the first one, with what is learned. For the tick after the drive was off.
            pub fn rest(&mut self) {
                unsafe { tribo_sys::$sys::axis_rest(&mut self.0) }
            }

            /// Friction comes back in full, once the cause is found.
            pub fn restore(&mut self) {
                unsafe { tribo_sys::$sys::axis_restore(&mut self.0) }
            }

            /// Not for the tick.
            pub fn report(&mut self) -> AxisReport {
                let mut now = tribo_sys::AxisReport::default();
                unsafe { tribo_sys::$sys::axis_report(&mut self.0, &mut now) };
                now.into()
            }

            /// What is learned, to be kept over a loss of power.
            pub fn export(&mut self) -> [u8; LEARNED_BYTES] {
                let mut bytes = [0; LEARNED_BYTES];
                unsafe { tribo_sys::$sys::axis_export(&mut self.0, bytes.as_mut_ptr()) };
                bytes
            }

            /// Takes over what an axis of the same rig and arithmetic has learned, at any time; u does not jump. A refusal changes nothing.
            pub fn import(&mut self, learned: &[u8]) -> Result<(), Refused> {
                done(unsafe { tribo_sys::$sys::axis_import(&mut self.0, learned.as_ptr(), learned.len()) })
            }
        }
    };
}

axis!(
    /// A force axis, in float32 and N; NaN: there was no reading. `step` is the same C as in a drive; an axis may be moved, and sent to another
    /// thread.
    Axis,
    f32,
    AxisF32,
    f32
);

axis!(
    /// A force axis in fixed point, for a processor without an FPU: forces of a tick are Q31 of the full scale, config and report are in N.
    ///
    /// ```
    /// use tribo::{pi, AxisConfig, AxisQ31, Breakaway};
    /// let config = AxisConfig {
    ///     sample_time_s: 1e-3,
    ///     u_min_n: -2.0,
    ///     u_max_n: 2.0,
    ///     positive: Breakaway { offset_n: 0.007, slope: 0.3 },
    ///     actuator_pole_rad_per_s: 200.0,
    ///     sensor_pole_rad_per_s: 55.0,
    ///     controller: pi(1.0, 56.0),
    ///     ..Default::default()
    /// };
    /// let mut axis = AxisQ31::new(&config, 8.0)?; // i32::MAX is 8 N
    /// let u = axis.step(1 << 27, 1 << 26); // 0.5 N and 0.25 N, every millisecond
    /// axis.learn(); // when there is time, at least every 10 ms
    /// # assert!(u > 0);
    /// # Ok::<(), tribo::Refused>(())
    /// ```
    AxisQ31,
    q31,
    AxisQ31,
    i32
);

impl Axis {
    /// At rest, nothing learned.
    pub fn new(config: &AxisConfig) -> Result<Self, Refused> {
        Self::made(config, 0.0)
    }
}

impl AxisQ31 {
    /// At rest, nothing learned. Forces, limits and breakaway fit into the full scale; better twice.
    pub fn new(config: &AxisConfig, full_scale_n: f32) -> Result<Self, Refused> {
        Self::made(config, full_scale_n)
    }

    /// After every tick, or at least once in ten: learns from the sample of a tick, in float32. True where there was one. `late` of the report
    /// counts those that it missed; a tick itself does not learn.
    pub fn learn(&mut self) -> bool {
        unsafe { tribo_sys::tribo_sys_axis_q31_learn(&mut self.0) != 0 }
    }
}
