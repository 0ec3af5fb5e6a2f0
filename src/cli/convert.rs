//! `freeform convert`: reads a CAD model and writes it in the project's own format.

use std::io::{BufWriter, Write as _};
use std::path::Path;

use freeform_surface::model::Model;

use super::ConvertArguments;
use crate::io::output::{Output, replace};
use crate::io::{Error, Result, say};

/// Reads the model and writes it.
///
/// # Errors
/// The model cannot be read or written.
pub(super) fn run(arguments: &ConvertArguments) -> Result<()> {
    let ConvertArguments { input, load, output } = arguments;
    let to_standard = output == Path::new("-");
    if !to_standard {
        if !output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ffm")) {
            let name = format!("\"{}\"", output.display());
            return Err(Error::invalid("output", name, "a name that ends in .ffm"));
        }
        Output::File(output.clone()).check_keeps(std::slice::from_ref(input))?;
    }
    let model = Model::load(input, &load.options())?;
    if to_standard {
        let mut out = BufWriter::new(std::io::stdout().lock());
        return model
            .write(&mut out)
            .and_then(|()| out.flush())
            .map_err(|error| Error::file("write", "standard output", error));
    }
    replace(output, |file| model.write(file))
        .map_err(|error| Error::file("write", output, error))?;
    say(format_args!(
        "wrote {}: {} faces, {} edges, {} products",
        output.display(),
        model.faces.len(),
        model.edges.len(),
        model.products.len(),
    ))
}
