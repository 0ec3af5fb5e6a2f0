//! The `freeform` program: scenes in, pictures out.

mod cli;
mod view;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = cli::Arguments::read();
    // The driver's complaints come with the error of the picture that they belong to.
    let filter = env_logger::Env::default().default_filter_or("warn,freeform_surface::gpu=off");
    env_logger::Builder::from_env(filter).format_timestamp(None).init();
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
