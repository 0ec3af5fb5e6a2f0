//! The `freeform` program: scenes in, pictures out.

mod cli;
mod io;
mod view;

use std::io::Write as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = cli::Arguments::read();
    // The driver's complaints come with the error of the picture that they belong to.
    let own = if arguments.verbose() { "freeform_surface=info" } else { "freeform_surface=warn" };
    let filter = format!("warn,{own},freeform_surface::gpu=off");
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or(filter))
        .format(|out, record| {
            let kind = match record.level() {
                log::Level::Error => "error: ",
                log::Level::Warn => "warning: ",
                log::Level::Info => "",
                log::Level::Debug | log::Level::Trace => "debug: ",
            };
            writeln!(out, "freeform: {kind}{}", record.args())
        })
        .init();
    match cli::run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(errors) => {
            for error in errors {
                eprintln!("freeform: {error}");
            }
            ExitCode::FAILURE
        }
    }
}
