//! What joints say of themselves and refuse. The project's tests compare their ticks with those of the library's own calls.

use tribo::{Cause, Joint, JointConfig, JointQ31};

const CONFIG: JointConfig =
    JointConfig { sample_time_s: 1e-3, effort_max: 1.0, travel: 4.0, breakaway: 0.0, actuator_pole_rad_per_s: 0.0, gain: 0.9, wrap: 0.0 };

/// Ten strokes of 400 counts, to and fro, with the reference a count ahead.
fn strokes(effort: f32, mut step: impl FnMut(f32, f32, f32)) {
    for stroke in 0..10 {
        let way = if stroke % 2 == 0 { 1.0 } else { -1.0 };
        for i in 0..400 {
            let q = if way > 0.0 { i as f32 } else { 400.0 - i as f32 };
            step(effort * way, q + way, q);
        }
    }
}

fn strokes_f32(joint: &mut Joint, effort: f32) {
    strokes(effort, |effort, q_ref, q| {
        joint.step(effort, q_ref, q);
    });
}

fn strokes_q31(joint: &mut JointQ31, effort: f32) {
    strokes(effort, |effort, q_ref, q| {
        joint.step((effort * 2147483648.0) as i32, q_ref as i32, q as i32);
    });
}

#[test]
fn says_what_it_learned() {
    let mut joint = Joint::new(&JointConfig { gain: 0.0, ..CONFIG }).unwrap();
    strokes_f32(&mut joint, 0.2);
    let moved = Box::new(joint); // it has no pointer into itself
    let report = moved.report();
    assert!(report.is_learned && report.low < 0.2 && 0.2 < report.high, "{report:?}");
    assert_eq!(report.cause, Cause::Sound);
    assert_eq!(report.cause.to_string(), "sound");
    assert!(moved.force().low < moved.force().force && moved.force().force < moved.force().high);
}

#[test]
fn fixed_point_says_what_it_learned() {
    let mut joint = JointQ31::new(&JointConfig { gain: 0.0, ..CONFIG }).unwrap();
    strokes_q31(&mut joint, 0.2);
    let moved = Box::new(joint);
    let report = moved.report();
    assert!(report.is_learned && report.low < 0.2 && 0.2 < report.high && report.cause == Cause::Sound, "{report:?}");
    assert!(moved.force().low < moved.force().force && moved.force().force < moved.force().high);
}

#[test]
fn fixed_point_refuses_in_words_and_takes_a_load() {
    assert!(JointQ31::new(&JointConfig { travel: 4.0 / 8192.0, ..CONFIG }).err().unwrap().to_string().contains("travel")); // half a thousandth of a count
    let mut joint = JointQ31::new(&CONFIG).unwrap();
    assert!(joint.gain(2.0).unwrap_err().to_string().contains("gain") && joint.gain(0.5).is_ok());
    joint.load(1 << 28);
    assert!((joint.step(0, 0, 0) - (1 << 28)).abs() < 4);
    assert_eq!(joint.step(i32::MAX, 0, 0), i32::MAX);
}

#[test]
fn refuses_in_words_and_is_finite_whatever_comes() {
    let refused = Joint::new(&JointConfig { effort_max: 0.0, ..CONFIG }).err().unwrap();
    assert!(refused.to_string().contains("effort_max"), "{refused}");
    let mut joint = Joint::new(&CONFIG).unwrap();
    assert!(joint.gain(2.0).unwrap_err().to_string().contains("gain"));
    assert!(joint.gain(0.5).is_ok());
    joint.load(0.1);
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        assert!(joint.step(bad, 0.0, 0.0).abs() <= 1.0 && joint.step(0.1, bad, 0.0).abs() <= 1.0 && joint.step(0.1, 0.0, bad).abs() <= 1.0);
    }
    assert!(joint.report().bad_inputs >= 6);
    assert!((joint.step(0.0, 0.0, 0.0) - 0.1).abs() < 1e-6);
}

#[test]
fn a_wrong_sign_takes_the_term_out_until_it_is_restored() {
    let mut joint = Joint::new(&JointConfig { breakaway: 0.1, ..CONFIG }).unwrap();
    strokes_f32(&mut joint, -0.2);
    assert_eq!((joint.report().cause, joint.report().share), (Cause::Reversed, 0.0));
    joint.restore();
    assert_eq!(joint.report().cause, Cause::Sound);
}

#[test]
fn a_wrong_sign_in_fixed_point() {
    let mut joint = JointQ31::new(&JointConfig { breakaway: 0.1, ..CONFIG }).unwrap();
    strokes_q31(&mut joint, -0.2);
    assert_eq!((joint.report().cause, joint.report().share), (Cause::Reversed, 0.0));
    joint.restore();
    assert_eq!(joint.report().cause, Cause::Sound);
}
