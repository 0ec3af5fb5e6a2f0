//! Makes models of closed solids, in millimetres: a flange, a bracket with rounded edges, a blade, and an assembly.
//!
//! `cargo run --release --example make_models` writes them to `resources/models`.

mod assembly;
mod blade;
mod bracket;
mod flange;
mod solid;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/models");
    for model in [flange::model()?, bracket::model()?, blade::model()?, assembly::model()?] {
        model.check()?;
        let mut text = Vec::new();
        model.write(&mut text)?;
        std::fs::write(format!("{folder}/{}.ffm", model.name), text)?;
    }
    Ok(())
}
