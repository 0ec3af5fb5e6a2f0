//! Any bytes are a model or one line of error; a model is written as a text that reads as the same model, and its faces
//! are drawn or refused.
#![no_main]

use std::path::Path;

use freeform_surface::model::Model;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("fuzz.ffm");
    match Model::read(bytes, path) {
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        Ok(model) => {
            model.check().expect("a model that was read is valid");
            let mut text = Vec::new();
            model.write(&mut text).expect("memory takes it");
            let again = Model::read(&*text, path).expect("what was written is read");
            assert_eq!(again, model);
            for face in model.drawn_faces().into_iter().flatten() {
                assert!(face.area() >= 0.0);
            }
        }
    }
});
