//! A joint that sticks, behind a PD of its owner's.

use tribo::{Cause, Joint, JointConfig, JointQ31};

const CONFIG: JointConfig =
    JointConfig { sample_time_s: 1e-3, effort_max: 1.0, travel: 4.0 / 8192.0, breakaway: 0.0, actuator_pole_rad_per_s: 0.0, gain: 0.9, wrap: 0.0 };

const COUNTS: JointConfig = JointConfig { travel: 4.0, ..CONFIG };

/// RMS error of a swing of a quarter turn, from the sixth second to the twelfth.
fn error_of(joint: &mut Joint) -> f64 {
    error_by(|effort, wanted, q| joint.step(effort, wanted, q))
}

/// Likewise, in fixed point; the encoder has wrapped.
fn error_in_counts(joint: &mut JointQ31) -> f64 {
    let counts = |turns: f32| i32::MAX.wrapping_add((turns * 8192.0).floor() as i32);
    error_by(|effort, wanted, q| {
        let u = joint.step((f64::from(effort.clamp(-1.0, 1.0)) * 2147483647.0) as i32, counts(wanted), counts(q));
        (f64::from(u) / 2147483648.0) as f32
    })
}

fn error_by(mut step: impl FnMut(f32, f32, f32) -> f32) -> f64 {
    let (mut angle, mut speed, mut last, mut square) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for tick in 0..12_000 {
        let wanted = 0.25 * (std::f64::consts::PI * 1e-3 * f64::from(tick)).sin();
        let q = (angle * 8192.0).floor() / 8192.0;
        let off = wanted - q;
        let u = f64::from(step((20.0 * off + 0.7 * (off - last) * 1e3) as f32, wanted as f32, q as f32));
        last = off;
        for _ in 0..10 {
            let push = u + 0.0126 * speed / 1e-4;
            speed = if push.abs() < 0.1 { 0.0 } else { (push - 0.1f64.copysign(push)) * 1e-4 / 0.0126 };
            angle += 1e-4 * speed;
        }
        square += if tick < 6_000 { 0.0 } else { (wanted - angle).powi(2) };
    }
    (square / 6_000.0).sqrt()
}

#[test]
fn takes_friction_out_and_says_what_it_learned() {
    let mut on = Joint::new(&CONFIG).unwrap();
    let mut off = Joint::new(&JointConfig { gain: 0.0, ..CONFIG }).unwrap();
    assert!(error_of(&mut off) > 2.5 * error_of(&mut on));
    let moved = Box::new(on); // it has no pointer into itself
    let report = moved.report();
    assert!(report.is_learned && report.low < 0.1 && 0.1 < report.high);
    assert_eq!(report.cause, Cause::Sound);
    assert_eq!(report.cause.to_string(), "sound");
    assert!(moved.force().low < moved.force().force && moved.force().force < moved.force().high);
}

#[test]
fn fixed_point_takes_friction_out_and_says_what_it_learned() {
    let mut on = JointQ31::new(&COUNTS).unwrap();
    let mut off = JointQ31::new(&JointConfig { gain: 0.0, ..COUNTS }).unwrap();
    assert!(error_in_counts(&mut off) > 2.5 * error_in_counts(&mut on));
    let moved = Box::new(on);
    let report = moved.report();
    assert!(report.is_learned && report.low < 0.1 && 0.1 < report.high && report.cause == Cause::Sound, "{report:?}");
    assert!(moved.force().low < moved.force().force && moved.force().force < moved.force().high);
}

#[test]
fn fixed_point_refuses_in_words_and_takes_a_load() {
    assert!(JointQ31::new(&CONFIG).err().unwrap().to_string().contains("travel")); // half a thousandth of a count
    let mut joint = JointQ31::new(&COUNTS).unwrap();
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
    let mut joint = Joint::new(&JointConfig { breakaway: 0.1, travel: 4.0, ..CONFIG }).unwrap();
    for stroke in 0..10 {
        let way = if stroke % 2 == 0 { 1.0 } else { -1.0 };
        for i in 0..400 {
            let q = if way > 0.0 { i as f32 } else { 400.0 - i as f32 };
            joint.step(-0.2 * way, q + way, q);
        }
    }
    assert_eq!((joint.report().cause, joint.report().share), (Cause::Reversed, 0.0));
    joint.restore();
    assert_eq!(joint.report().cause, Cause::Sound);
}

#[test]
fn a_wrong_sign_in_fixed_point() {
    let mut joint = JointQ31::new(&JointConfig { breakaway: 0.1, ..COUNTS }).unwrap();
    for stroke in 0..10 {
        let way = if stroke % 2 == 0 { 1 } else { -1 };
        for i in 0..400 {
            let q = if way > 0 { i } else { 400 - i };
            joint.step(-way * 429_496_730, q + way, q); // a fifth
        }
    }
    assert_eq!((joint.report().cause, joint.report().share), (Cause::Reversed, 0.0));
    joint.restore();
    assert_eq!(joint.report().cause, Cause::Sound);
}
