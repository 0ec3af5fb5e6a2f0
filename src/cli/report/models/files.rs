//! The models of the section: the project's own, a large one made of them, and the user's.

use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use crate::cli::report::bench::Bench;
use crate::io::{Error, Result};
use freeform_surface::Scene;
use freeform_surface::model::{Model, Product, ProductUse};
use glam::{DAffine3, DVec3};

/// The project's own models.
const OWN: [&str; 4] = ["flange", "bracket", "blade", "assembly"];
/// The faces of the large model, at least: as many as the largest of the models that were collected.
const MANY: usize = 1_755;

/// A model to measure.
#[derive(Debug)]
pub(super) struct Subject {
    pub(super) name: String,
    pub(super) path: PathBuf,
    pub(super) scene: Scene,
    /// Whether its file is removed with the folder.
    pub(super) is_made: bool,
}

impl Subject {
    fn load(name: String, path: PathBuf) -> Result<Self> {
        Ok(Self { scene: Scene::load(&path)?, name, path, is_made: false })
    }
}

/// A folder of files that ends with this value.
#[derive(Debug)]
pub(super) struct Files(PathBuf);

impl Drop for Files {
    fn drop(&mut self) {
        // Files that are left behind are in the system's folder for them.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

impl Files {
    pub(super) fn new() -> Result<Self> {
        let folder = std::env::temp_dir().join(format!("freeform-report-{}", std::process::id()));
        std::fs::create_dir_all(&folder)
            .map_err(|error| Error::file("make the folder", &folder, error))?;
        Ok(Self(folder))
    }

    /// Writes a model in the project's format.
    pub(super) fn write(&self, name: &str, model: &Model) -> Result<PathBuf> {
        let path = self.0.join(name);
        let write = || {
            let mut file = BufWriter::new(std::fs::File::create(&path)?);
            model.write(&mut file)?;
            file.flush()
        };
        write().map_err(|error| Error::file("write", &path, error))?;
        Ok(path)
    }

    /// The project's own models, the large one and the user's. A quick report has fewer and smaller ones.
    pub(super) fn subjects(&self, bench: &Bench) -> Result<Vec<Subject>> {
        let own = if bench.quick { &OWN[..1] } else { &OWN };
        let own = own
            .iter()
            .map(|name| Subject::load((*name).into(), bench.path(&format!("models/{name}.ffm"))));
        let mut subjects = own.collect::<Result<Vec<_>>>()?;
        let models: Vec<&Model> = subjects
            .iter()
            .flat_map(|subject| &subject.scene.models)
            .map(|one| &*one.model)
            .collect();
        let large = repeated(&models, if bench.quick { MANY / 20 } else { MANY });
        let name = format!("{} faces", large.faces.len());
        let large = Subject::load(name, self.write("large.ffm", &large)?)?;
        subjects.push(Subject { is_made: true, ..large });
        for path in &bench.models {
            subjects.push(Subject::load(name_of(path), path.clone())?);
        }
        Ok(subjects)
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A model of at least `count` faces: copies of some models side by side, each with faces and edges of its own.
fn repeated(models: &[&Model], count: usize) -> Model {
    let faces: usize = models.iter().map(|model| model.faces.len()).sum();
    let rounds = count.div_ceil(faces.max(1));
    let copies = rounds * models.len();
    let columns = (copies as f64).sqrt().ceil() as usize;
    let step = models.iter().map(|model| model.diagonal()).fold(0.0, f64::max);
    let mut all = Model {
        name: "copies".into(),
        unit: models[0].unit,
        edges: Vec::new(),
        faces: Vec::new(),
        products: Vec::new(),
    };
    let mut uses = Vec::with_capacity(copies);
    for (number, model) in models.iter().cycle().take(copies).enumerate() {
        let product = append(&mut all, model);
        let place = DVec3::new((number % columns) as f64, (number / columns) as f64, 0.0);
        let placement = DAffine3::from_translation(step * place);
        uses.push(ProductUse { product, placement, color: None });
    }
    let (name, end) = (all.name.clone(), all.faces.len());
    all.products.push(Product { name, color: None, faces: [end, 0], uses });
    all
}

/// Appends the edges, faces and products of a model. Returns the number of its last product.
fn append(all: &mut Model, model: &Model) -> usize {
    let (edges, faces, products) = (all.edges.len(), all.faces.len(), all.products.len());
    all.edges.extend(model.edges.iter().cloned());
    all.faces.extend(model.faces.iter().cloned());
    all.products.extend(model.products.iter().cloned());
    for coedge in all.faces[faces..].iter_mut().flat_map(|face| face.loops.iter_mut().flatten()) {
        coedge.edge += edges;
    }
    for product in &mut all.products[products..] {
        product.faces[0] += faces;
        product.uses.iter_mut().for_each(|used| used.product += products);
    }
    all.products.len() - 1
}

#[cfg(test)]
mod tests {
    use freeform_surface::LoadOptions;

    use super::*;

    #[test]
    fn copies_have_faces_of_their_own() {
        let path = |name: &str| {
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("resources/models/{name}.ffm"))
        };
        let models = ["assembly", "blade"]
            .map(|name| Model::load(&path(name), &LoadOptions::default()).unwrap());
        let large = repeated(&models.each_ref(), 90);
        large.check().unwrap();
        // 21 and 4 faces, four times.
        assert_eq!(large.faces.len(), 100);
        let instances = models.iter().map(|model| model.instances().unwrap().len()).sum::<usize>();
        assert_eq!(large.instances().unwrap().len(), 4 * instances);
    }
}
