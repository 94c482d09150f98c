//! Compiles the library and the loop of one rig: TRIBO_RIG is the header that `tribo-sim params RIG --name rig` has made, else that of
//! the paper's rig at 1 kHz. CC and CFLAGS are as usual; for thumb targets the compiler is arm-none-eabi-gcc.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

const SOURCES: &[&str] = &[
    "axis.c",
    "axis_q31.c",
    "force_loop.c",
    "joint.c",
    "joint_q31.c",
    "text.c",
    @RUST_SOURCES@,
];

/// Of the targets with an FPU that Rust uses for arguments.
fn flags(target: &str) -> Vec<&'static str> {
    let mut flags = vec!["-std=c11", "-O2", "-ffreestanding", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections"];
    flags.extend(match target {
        "thumbv7em-none-eabihf" => ["-mthumb", "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"].as_slice(),
        "thumbv7em-none-eabi" => ["-mthumb", "-mcpu=cortex-m4", "-mfloat-abi=soft"].as_slice(),
        "thumbv7m-none-eabi" => ["-mthumb", "-mcpu=cortex-m3"].as_slice(),
        "thumbv6m-none-eabi" => ["-mthumb", "-mcpu=cortex-m0plus"].as_slice(),
        _ => ["-fPIC"].as_slice(),
    });
    flags
}

fn run(command: &mut Command) {
    let status = command.status().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(status.success(), "{command:?}: {status}");
}

fn main() {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR").unwrap());
    let out = PathBuf::from(env::var("OUT_DIR").unwrap());
    let target = env::var("TARGET").unwrap();
    let prefix = if target.starts_with("thumb") { "arm-none-eabi-" } else { "" };
    let compiler = env::var("CC").unwrap_or_else(|_| format!("{prefix}gcc"));
    let rig = env::var("TRIBO_RIG").map(PathBuf::from).unwrap_or_else(|_| here.join("rig_1khz_f32.h"));
    let archive = out.join("libtribo.a");
    let _ = std::fs::remove_file(&archive);
    for source in SOURCES {
        let object = out.join(source.replace('/', "_")).with_extension("o");
        run(Command::new(&compiler)
            .args(flags(&target))
            .args(env::var("CFLAGS").unwrap_or_default().split_whitespace())
            .arg(format!("-DRIG=\"{}\"", rig.display()))
            .arg("-I")
            .arg(here.join("lib/include"))
            .arg("-c")
            .arg(here.join(Path::new(source)))
            .arg("-o")
            .arg(&object));
        run(Command::new(format!("{prefix}ar")).arg("crs").arg(&archive).arg(&object));
    }
    println!("cargo:rerun-if-env-changed=TRIBO_RIG");
    println!("cargo:rerun-if-env-changed=CC");
    println!("cargo:rerun-if-env-changed=CFLAGS");
    println!("cargo:rerun-if-changed={}", rig.display());
    for source in SOURCES.iter().chain(&["movable_axis.h", "lib/include"]) {
        println!("cargo:rerun-if-changed={source}");
    }
    println!("cargo:rustc-link-search=native={}", out.display());
    println!("cargo:rustc-link-lib=static=tribo");
}
