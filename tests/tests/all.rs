//! All integration tests in one program: it is linked once, and tests that wait run beside tests
//! that calculate. `cargo test -p tests --test all view::` runs those of one file.

mod any_world;
mod arm;
mod avoidance;
mod bad_input;
mod behaviors;
mod bodies;
mod bridge;
mod campaign;
mod chip_architectures;
mod chip_body;
mod chip_faults;
mod chip_flash;
mod chip_host;
mod chip_link;
mod chip_places;
mod chip_python;
mod chip_twin;
mod compare;
mod controls;
mod damaged_logs;
mod defects;
mod demonstrations;
mod determinism;
mod errands;
mod faults;
#[cfg(unix)]
mod files;
mod golden;
mod hostile;
mod layout;
mod logs;
mod maps;
mod nomad;
mod paper;
mod readme;
mod rivals;
mod sequence;
mod serial;
mod servers;
mod several_steps;
mod sweep;
mod view;
