//! The driver on the collection of Hock and Schittkowski: each problem is its statement alone, its derivatives are
//! exact by hyper-dual numbers, and its solution is checked against the published one and by conditions evaluated here.
#![cfg(feature = "ipopt")]
#![allow(missing_docs)]

mod collection;
mod hyper_dual;
mod kkt;
mod problem;
mod solutions;
mod statements;
mod variants;
