//! The weak non-penetration constraints, step by step:
//! [`surface`] → [`search`] → [`projection`] → [`normals`] → [`integration`] → [`gaps`].

pub mod gaps;
pub mod integration;
pub mod normals;
pub mod pressure;
pub mod projection;
pub mod search;
pub mod surface;

pub use gaps::Pass;
pub use integration::FacetRule;
pub use search::Master;
pub use surface::Surface;
