//! `freeform view`: a window that shows a scene and edits it.
//!
//! ```text
//! window system → input → Key, Button → State → Changes → PreparedScene → picture → window
//! ```
//!
//! The effects of keys and mouse are decided without a window (in `state`, `gestures` and the table in
//! `action`) and are tested without one. The window itself is behind the feature `viewer`.
#![cfg_attr(not(feature = "viewer"), allow(dead_code, reason = "only a window uses it all"))]

mod action;
#[cfg(feature = "viewer")]
mod app;
mod camera;
mod faces;
mod files;
mod gestures;
#[cfg(feature = "viewer")]
mod gl;
#[cfg(feature = "viewer")]
mod input;
#[cfg(feature = "viewer")]
mod inset;
mod loading;
#[cfg(feature = "viewer")]
mod overlay;
#[cfg(feature = "viewer")]
mod panel;
mod pick;
mod pointer;
#[cfg(feature = "viewer")]
mod screen;
#[cfg(feature = "viewer")]
mod shading;
mod state;
mod trims;
mod undo;
#[cfg(feature = "viewer")]
mod watch;

use std::path::PathBuf;

use crate::io::Result;
use clap::Args;

use crate::io::input::{LoadArguments, PictureArguments};
use crate::io::say;

/// The arguments of `freeform view`.
#[derive(Debug, Args)]
pub(crate) struct ViewArguments {
    /// The scene: a .toml, .bpt or .obj file, or a CAD model (.ffm, .step, .iges or .brep); without one, a surface with
    /// bricks.
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,

    #[command(flatten)]
    load: LoadArguments,

    #[command(flatten)]
    picture: PictureArguments,

    /// Read and show the scene again whenever its file or a file that it names changes; the camera stays.
    #[arg(long)]
    watch: bool,

    /// Print the key and mouse bindings without opening a window.
    #[arg(long)]
    list_bindings: bool,
}

/// Opens the window, and returns when it is closed.
///
/// # Errors
/// The scene cannot be read, there is no window system or no OpenGL 4.5, or the program was built without
/// windows.
pub(crate) fn run(arguments: &ViewArguments) -> Result<()> {
    if arguments.list_bindings {
        return action::lines().try_for_each(|(keys, help)| say(format_args!("{keys:46} {help}")));
    }
    show(arguments)
}

#[cfg(feature = "viewer")]
fn show(arguments: &ViewArguments) -> Result<()> {
    app::run(arguments)
}

#[cfg(not(feature = "viewer"))]
fn show(_: &ViewArguments) -> Result<()> {
    Err(freeform_surface::Error::NotBuilt { what: "the window", feature: "viewer" }.into())
}
