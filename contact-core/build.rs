//! Hands on to the source what Ipopt was found and linked, and by which compiler all this is built.

use std::{env, process::Command};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // ipopt-sys tells these; where documentation is made without an Ipopt they are absent.
    pass_on(
        "IPOPT_CONTACT_IPOPT_VERSION",
        env::var("DEP_IPOPT_VERSION").ok(),
    );
    pass_on("IPOPT_CONTACT_IPOPT_LIBS", env::var("DEP_IPOPT_LIBS").ok());
    pass_on("IPOPT_CONTACT_RUSTC", rustc_version());
    pass_on("IPOPT_CONTACT_PROFILE", env::var("PROFILE").ok());
}

fn pass_on(name: &str, value: Option<String>) {
    println!("cargo::rustc-env={name}={}", value.unwrap_or_default());
}

fn rustc_version() -> Option<String> {
    let output = Command::new(env::var_os("RUSTC")?)
        .arg("--version")
        .output()
        .ok()?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
