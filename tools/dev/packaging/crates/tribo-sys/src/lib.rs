//! tribo's axis and joint, and a force loop whose params were made for one rig (see build.rs), compiled from C. The crate `tribo` is the safe
//! way to them.
#![no_std]

/// Memory of an axis, of the size that axis.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct Axis(pub [u8; 1664]);

/// Memory of a rig's loop, of the size that force_loop.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct ForceLoop(pub [u8; 1024]);

/// Memory of a joint, of the size that joint.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct Joint(pub [u8; 320]);

/// Bytes of what an axis has learned.
pub const LEARNED_BYTES: usize = 104;

/// A PI, a controller of yours, or (all 0) none, which is refused. Made by `tribo::pi` and `tribo::own`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Controller {
    pub kind: i32,
    pub kp: f32,
    pub ki_per_s: f32,
}

/// Friction to overcome at rest: offset_n + slope |F|.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Breakaway {
    /// 1e-6 to 1e6 N.
    pub offset_n: f32,
    /// 0 to 10 N per N.
    pub slope: f32,
}

/// All 0 by default: refused until the rig is in it, and each refusal names the next field. Forces are end-point forces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct AxisConfig {
    /// Of every tick, 1e-6 to 0.1 s.
    pub sample_time_s: f32,
    /// -1e6 to 0 N.
    pub u_min_n: f32,
    /// 0 to 1e6 N, over u_min_n.
    pub u_max_n: f32,
    /// Largest credible |r| and |y|, up to 1e6 N; 0: twice the larger limit of u.
    pub input_max_n: f32,
    /// |F| around which the rig usually works; 0: a quarter of the larger limit of u.
    pub usual_force_n: f32,
    /// Within a factor of 3; learning corrects it.
    pub positive: Breakaway,
    /// All 0: as the positive.
    pub negative: Breakaway,
    /// Constant load on the arm.
    pub gravity_n: f32,
    /// Damping over stiffness of the arm, up to 1000 ticks; 0: none that is known.
    pub arm_lag_s: f32,
    /// Standard deviation of y; 0: unknown.
    pub noise_n: f32,
    /// 1e-3 to 1e6 rad/s.
    pub actuator_pole_rad_per_s: f32,
    /// 1e-3 to 1e6 rad/s.
    pub sensor_pole_rad_per_s: f32,
    pub controller: Controller,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct AxisReport {
    pub breakaway_n: [f32; 2],
    pub low_n: [f32; 2],
    pub high_n: [f32; 2],
    pub travel_n: f32,
    pub times_less: f32,
    pub share: f32,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
    pub forgotten: u32,
    pub warnings: u32,
}

/// Units of effort and position are those of your loop.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointConfig {
    /// Of every tick, 1e-6 to 0.1 s.
    pub sample_time_s: f32,
    /// Limit of |u|, 1e-6 to 1e6.
    pub effort_max: f32,
    /// Least change of q that is motion and no noise: four counts of the encoder.
    pub travel: f32,
    /// Friction as you believe it; half of it is used until it is learned. 0: nothing is.
    pub breakaway: f32,
    /// Of the current loop, 1e-3 to 1e6; 0: fast.
    pub actuator_pole_rad_per_s: f32,
    /// Part of the learned friction that is taken out, 0 to 1.
    pub gain: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct JointReport {
    pub friction: f32,
    pub low: f32,
    pub high: f32,
    pub load: f32,
    pub share: f32,
    pub is_learned: i32,
    pub cause: i32,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
}

extern "C" {
    pub static tribo_sys_loop_period_s: f32;
    pub fn tribo_sys_loop_start(state: *mut ForceLoop);
    pub fn tribo_sys_loop_step(state: *mut ForceLoop, r: f32, y: f32) -> f32;
    pub fn tribo_sys_loop_guard(state: *const ForceLoop) -> i32;

    pub fn tribo_sys_axis_init(axis: *mut Axis, config: *const AxisConfig) -> i32;
    pub fn tribo_sys_axis_change(axis: *mut Axis, config: *const AxisConfig) -> i32;
    pub fn tribo_sys_axis_step(axis: *mut Axis, r: f32, y: f32) -> f32;
    pub fn tribo_sys_axis_error(axis: *mut Axis, r: f32, y: f32) -> f32;
    pub fn tribo_sys_axis_command(axis: *mut Axis, v: f32) -> f32;
    pub fn tribo_sys_axis_excess(axis: *const Axis) -> f32;
    pub fn tribo_sys_axis_report(axis: *mut Axis, report: *mut AxisReport);
    pub fn tribo_sys_axis_warning(warnings: *mut u32) -> *const u8;
    pub fn tribo_sys_axis_restore(axis: *mut Axis);
    pub fn tribo_sys_axis_export(axis: *mut Axis, bytes: *mut u8);
    pub fn tribo_sys_axis_import(axis: *mut Axis, bytes: *const u8, size: usize) -> i32;

    pub fn tribo_sys_joint_init(joint: *mut Joint, config: *const JointConfig) -> i32;
    pub fn tribo_joint_f32_step(joint: *mut Joint, effort: f32, q_ref: f32, q: f32) -> f32;
    pub fn tribo_joint_f32_load(joint: *mut Joint, load: f32);
    pub fn tribo_joint_f32_restore(joint: *mut Joint);
    pub fn tribo_sys_joint_gain(joint: *mut Joint, gain: f32) -> i32;
    pub fn tribo_sys_joint_report(joint: *const Joint, report: *mut JointReport);
    pub fn tribo_sys_joint_force(joint: *const Joint, force: *mut f32);
    pub fn tribo_sys_status_text(status: i32) -> *const u8;
    pub fn tribo_sys_joint_cause_text(cause: i32) -> *const u8;
}
