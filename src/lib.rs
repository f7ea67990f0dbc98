//! Facade.
pub use contact_core;
pub use contact_fem;
