//! tribo's force loop, compiled from C for one rig (see build.rs), and its joint without a force sensor. The crate `tribo` is the safe way to both.
#![no_std]

/// Memory of an axis, of the size that axis.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct Axis(pub [u8; 1024]);

/// Memory of a joint, of the size that joint.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct Joint(pub [u8; 320]);

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
    pub static tribo_axis_period_s: f32;
    pub fn tribo_axis_start(axis: *mut Axis);
    pub fn tribo_axis_step(axis: *mut Axis, r: f32, y: f32) -> f32;
    pub fn tribo_axis_guard(axis: *const Axis) -> i32;

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
