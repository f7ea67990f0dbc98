//! Files for people and programs, each format behind a cargo feature.
