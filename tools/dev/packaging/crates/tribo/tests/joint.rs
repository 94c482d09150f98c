//! A joint that sticks, behind a PD of its owner's.

use tribo::{Cause, Joint, JointConfig};

const CONFIG: JointConfig =
    JointConfig { sample_time_s: 1e-3, effort_max: 1.0, travel: 4.0 / 8192.0, breakaway: 0.0, actuator_pole_rad_per_s: 0.0, gain: 0.9 };

/// RMS error of a swing of a quarter turn, from the sixth second to the twelfth.
fn error_of(joint: &mut Joint) -> f64 {
    let (mut angle, mut speed, mut last, mut square) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for tick in 0..12_000 {
        let wanted = 0.25 * (std::f64::consts::PI * 1e-3 * f64::from(tick)).sin();
        let q = (angle * 8192.0).floor() / 8192.0;
        let off = wanted - q;
        let u = f64::from(joint.step((20.0 * off + 0.7 * (off - last) * 1e3) as f32, wanted as f32, q as f32));
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
