//! What this Ipopt is and has.
//!
//! ```text
//! cargo run --release -p contact-core --example doctor
//! ```

use contact_core::ipopt::{Error, diagnose};

fn main() -> Result<(), Error> {
    println!("{}", diagnose()?);
    Ok(())
}
