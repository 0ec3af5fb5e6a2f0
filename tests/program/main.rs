//! The program `freeform` from outside: its commands, their files, exit statuses and messages.

#[path = "../harness/mod.rs"]
mod harness;

mod batch;
mod batch_kills;
mod commands;
mod frames;
mod light;
mod measure;
mod models;
mod report;
mod shading;
mod smooth;
