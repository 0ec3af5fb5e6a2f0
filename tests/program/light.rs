//! The light on the command line.

use crate::harness::program::{Folder, resource, text};

#[test]
fn the_command_line_overrides_the_light_of_a_scene() {
    let folder = Folder::new();
    let camera = "[camera]\neye = [0, 1, 2]\ntarget = [0, 0, 0]\n";
    let scene = |light| format!("{camera}{light}[[surface]]\ncontrol_points = \"default\"\n");
    folder.write("none.toml", scene(""));
    folder.write("thesis.toml", scene("[render]\nlight = \"thesis\"\n"));
    let picture = |file: &str, light: &[&str]| {
        let command = [&["render", file, "-o", "-", "--resolution", "80x60"], light].concat();
        let output = folder.run(&command);
        assert!(output.status.success(), "{}", text(&output.stderr));
        output.stdout
    };
    let [studio, thesis] =
        ["studio", "thesis"].map(|light| picture("none.toml", &["--light", light]));
    assert!(studio != thesis);
    assert!(picture("none.toml", &[]) == studio);
    assert!(picture("thesis.toml", &[]) == thesis);
    assert!(picture("thesis.toml", &["--light", "studio"]) == studio);
    let teapot = resource("surfaces/teapot.bpt");
    assert!(picture(&teapot, &[]) == picture(&teapot, &["--light", "studio"]));
    let output = folder.run(&["render", "none.toml", "--light", "sun"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("expected studio or thesis"), "{}", text(&output.stderr));
}
