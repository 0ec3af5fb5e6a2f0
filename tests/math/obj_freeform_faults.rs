//! What is wrong or not supported in free-form surfaces of OBJ files, and how scenes take such files.

use std::path::Path;

use freeform_surface::{CreaseAngle, Mesh, Paint, Scene};
use glam::dvec2;

use crate::obj_freeform::{SHEET, read, scene, words};

#[test]
fn what_is_not_supported_is_left_out() {
    let curves = "vp 0.2 0.2\nvp 0.8 0.2\nvp 0.5 0.8\ncstype cardinal\ndeg 3\ncurv2 1 2 3 1\nparm u 0 1\nend\n\
        cstype bezier\ndeg 16\ncurv2 1 2 3\nend\ndeg 1\ncurv2 1 2 3 1\nparm u 0 1 2 3\nend\nsp 1\n\
        curv 0 1 1 2\nparm u 0 1\nend\n";
    let text = format!(
        "{curves}{SHEET}trim 0 1 1\nhole 0 3 3\nscrv 0 1 3\nend\nctech cparm 1\nstech cparmb 1\ncon 1 0 1 1 2 0 1 1\n\
         bmat u 1 0 0 1\nstep 1 1\ncstype taylor\nsurf 0 1 0 1 1 2 3 4\nend\n"
    );
    let left = read(&text);
    assert_eq!(left.surfaces.len(), 1);
    // The curve in the border is not supported; the hole remains.
    assert_eq!(left.surfaces[0].trims.loops.len(), 1);
    assert!(
        left.surfaces[0].trims.cut(dvec2(0.5, 0.4)) && !left.surfaces[0].trims.cut(dvec2(0.1, 0.1))
    );
    // Two of a kind.
    let twice = format!("curv 0 1 1 2\nparm u 0 1\nend\n{text}");
    let twice = Mesh::read_obj(twice.as_bytes(), Path::new("x.obj"), CreaseAngle::default());
    assert!(twice.unwrap_err().to_string().contains("2 curves in space"));
    let mesh = Mesh::read_obj(text.as_bytes(), Path::new("x.obj"), CreaseAngle::default());
    let said = mesh.unwrap_err().to_string();
    for what in [
        "1 NURBS surface",
        "1 Bézier curve of degree 16",
        "1 cardinal curve",
        "1 curve in space",
        "1 taylor surface",
        "1 trim statement with unsupported curves",
        "1 scrv statement",
        "1 sp statement",
        "1 ctech statement",
        "1 stech statement",
        "1 con statement",
        "1 bmat statement",
        "1 step statement",
    ] {
        assert!(said.contains(what), "{what}: {said}");
    }
}

#[test]
fn what_is_wrong_is_said_with_line_and_words() {
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0 0\n";
    let curve = "vp 0.2 0.2\nvp 0.8 0.2\nvp 0.5 0.8\ncstype bezier\ndeg 1\ncurv2 1 2 3 1\nparm u 0 1 2 3\nend\n";
    let kind = "cstype bspline\ndeg 1 1\n";
    let surf = "surf 0 1 0 1 1 2 3 4\n";
    let parm = "parm u 0 0 1 1\nparm v 0 0 1 1\n";
    // The lines after the four points.
    for (text, words) in [
        ("cstype\n".to_owned(), "5: cstype has no kind; expected bezier or bspline"),
        ("cstype rat\n".into(), "5: cstype has no kind"),
        ("deg\n".into(), "5: deg has no degree; expected one for curves, two for surfaces"),
        ("deg 3 0\n".into(), "5: \"0\" is no degree; expected 1 to 15"),
        ("deg three\n".into(), "5: \"three\" is no degree"),
        ("vp\n".into(), "5: the parameter vertex has 0 numbers; expected u v, or u v weight"),
        ("vp 1 2 3 4\n".into(), "5: the parameter vertex has 4 numbers"),
        ("vp 1 nan\n".into(), "5: \"nan\" is no finite number"),
        ("end\n".into(), "5: end is here without surf, curv2 or curv before it"),
        ("parm u 0 1\n".into(), "5: parm outside of a curve or surface"),
        ("trim 0 1 1\n".into(), "5: trim outside of a surface; expected between surf and its end"),
        ("curv2 1 2\nhole 0 1 1\n".into(), "6: hole outside of a surface"),
        (
            format!("{surf}end\n"),
            "6: the surface has no cstype; expected bezier or bspline above it",
        ),
        ("curv2 1 2\nend\n".into(), "6: the curve has no cstype"),
        (
            format!("cstype bspline\n{surf}end\n"),
            "7: the surface has no degree; expected deg with two",
        ),
        (format!("cstype bspline\ndeg 3\n{surf}end\n"), "8: the surface has no degree"),
        (format!("{kind}{surf}{parm}"), "7: surf has no end"),
        (format!("{kind}{surf}curv2 1 2\n"), "8: curv2 before the end of surf of line 7"),
        (format!("{kind}surf 0 1 0\n"), "7: \"\" is no finite number"),
        (
            format!("{kind}surf 1 1 0 1 1 2 3 4\n"),
            "7: the range along u is 1 to 1; expected first < last",
        ),
        (format!("{kind}surf 0 1 1 0 1 2 3 4\n"), "7: the range along v is 1 to 0"),
        (format!("{kind}surf 0 1 0 1 1 2 0 4\n"), "7: index 0 of a position; expected 1 to 4"),
        (format!("{kind}surf 0 1 0 1 1 2 -5 4\n"), "7: index -5 of a position; expected −1 to −4"),
        (
            format!("{kind}surf 0 1 0 1 1 2 3 5\n{parm}end\n"),
            "7: index 5 of a position; expected 1 to 4",
        ),
        (
            format!("{kind}surf 0 1 0 1 1 2 3\n{parm}end\n"),
            "10: the surface has 3 control points; its degrees and parameters expect 2×2",
        ),
        (
            format!("{kind}surf 2 3 0 1 1 2 3 4\n{parm}end\n"),
            "10: the range along u of the surface is 2 to 3; expected a part of 0 to 1",
        ),
        (format!("{kind}{surf}parm w 0 1\n"), "8: parm begins with \"w\"; expected u or v"),
        (format!("{kind}{surf}parm u 0 x\n"), "8: \"x\" is no finite number"),
        (
            format!("{kind}{surf}parm u 0 1 1\nend\n"),
            "9: parm u has 3 numbers; expected at least 4 for degree 1",
        ),
        (
            format!("cstype bezier\ndeg 1 1\n{surf}parm u 1\nend\n"),
            "9: parm u has 1 number; expected at least 2",
        ),
        (
            format!("{kind}{surf}parm v 0 0 1 1\nparm u 0 1 0 1\nend\n"),
            "10: parm u: knot 2 is 0; expected at least 1",
        ),
        (
            format!("{kind}{surf}parm v 1 1 1 1\nparm u 0 0 1 1\nend\n"),
            "10: parm v: domain from knot 1 to knot 2 is 1 to 1",
        ),
        (
            format!("cstype rat bspline\ndeg 1 1\n{surf}{parm}end\n"),
            "7: the weight of position 4 is 0; expected above 0, from 1e-9 to 1e9",
        ),
        ("curv2 1 x\n".into(), "5: \"x\" is no index"),
        ("vp 0 0\ncurv2 1 0\n".into(), "6: index 0 of a parameter vertex; expected 1 to 1"),
        (
            format!("{curve}deg 1\ncurv2 1 4\nend\n"),
            "14: index 4 of a parameter vertex; expected 1 to 3",
        ),
        (
            format!("{curve}vp 1\ncurv2 1 4\nend\n"),
            "14: parameter vertex 4 has 1 number; expected u and v",
        ),
        (
            format!("{curve}vp 1e16 0\ncurv2 1 4\nend\n"),
            "14: parameter vertex 4 is [10000000000000000, 0, 0]; expected finite",
        ),
        (
            format!("{curve}vp 1 0 -1\ncstype rat bezier\ncurv2 1 4\nend\n"),
            "15: weight of parameter vertex 4 is -1; expected a number above 0",
        ),
        (
            format!("{curve}curv2 1 2 3\nend\n"),
            "14: the curve has 3 parameter vertices; its degree and parameters expect 2",
        ),
        (
            format!("{curve}{kind}{surf}trim\n"),
            "16: trim has no part; expected the first and the last parameter and the number",
        ),
        (
            format!("{curve}{kind}{surf}trim 0 3 1 0 1\n"),
            "16: trim ends in the middle of a part; expected the first",
        ),
        (
            format!("{curve}{kind}{surf}trim 0 3 2\n"),
            "16: index 2 of a trimming curve; expected 1 to 1",
        ),
        (format!("{kind}{surf}hole 0 3 1\n"), "8: index 1 of a trimming curve; but there is none"),
        (
            format!("{curve}{kind}{surf}hole 0 3.1 1\n"),
            "16: hole: the part from 0 to 3.1 of a curve; expected parameters from 0 to 3",
        ),
        (
            format!("{curve}{kind}{surf}hole 2 2 1\n"),
            "16: hole: the part from 2 to 2 of a curve; expected two different parameters",
        ),
        (
            format!("{curve}{kind}{surf}{parm}trim 0 2 1\nend\n"),
            "18: trim: gap between the end of curve 0 and the start of curve 0",
        ),
    ] {
        let said = scene(&format!("{points}{text}")).unwrap_err().to_string();
        assert!(said.starts_with(&format!("x.obj:{words}")), "{text}: {said}");
        assert_eq!(said.lines().count(), 1);
    }
}

#[test]
fn short_texts_of_large_surfaces_and_loops_are_refused() {
    let side = 700;
    let text = format!(
        "v 0 0 0\ncstype bspline\ndeg 15 15\nsurf 0 1 0 1{}\nparm u{knots}\nparm v{knots}\nend\n",
        " 1".repeat(side * side),
        knots = words(&(0..side + 16).map(|i| i as f64).collect::<Vec<_>>()),
    );
    let said = scene(&text.replace("surf 0 1 0 1", "surf 15 700 15 700")).unwrap_err().to_string();
    assert!(
        said.starts_with("x.obj:4: up to this surface there are 120121600")
            && said.contains("at most 16777216"),
        "{said}"
    );
    let count = 100_000;
    let curve = format!(
        "vp 0 0\nvp 1 0\ncstype bezier\ndeg 1\ncurv2 1{}\nparm u{}\nend\n",
        " 2 1".repeat(count / 2),
        words(&(0..=count).map(|i| i as f64).collect::<Vec<_>>()),
    );
    let all = format!(" 0 {count} 1");
    for (trims, words) in [
        (
            format!("trim{}\n", all.repeat(11)),
            "number of Bézier curves of the loop is 1100000; expected at most 1048576",
        ),
        (format!("trim{}\ntrim{}\n", all.repeat(9), all.repeat(2)), "loop 1, segment 100000"),
        // A part of a long curve takes no time.
        ("trim 4 6 1\n".repeat(50_000), ""),
    ] {
        let read = scene(&format!("{curve}{SHEET}{trims}end\n"));
        match words {
            "" => assert_eq!(read.unwrap().surfaces[0].trims.loops.len(), 50_000),
            _ => {
                let said = read.unwrap_err().to_string();
                assert!(said.contains(words), "{said}");
            }
        }
    }
}

#[test]
fn a_scene_keeps_the_trims_of_its_files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let triangle = "vp 0.2 0.2\nvp 0.8 0.2\nvp 0.5 0.8\ncstype bezier\ndeg 1\ncurv2 1 2 3 1\nparm u 0 1 2 3\nend\n";
    let trimmed = format!("{triangle}{SHEET}trim 0 3 1\nend\n");
    write("trimmed.obj", &trimmed);
    write("plain.obj", &format!("{SHEET}end\n"));
    write("two.obj", &format!("{SHEET}end\n{SHEET}end\n"));
    let patches = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\ncstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nend\n\
        deg 3 1\nsurf 0 1 0 1 1 1 2 2 3 3 4 4\nend\n";
    write("patches.obj", patches);
    let load = |table: &str| Scene::from_toml(table, &folder.path().join("scene.toml"));
    let scene = load("[[surface]]\nfile = \"trimmed.obj\"\ncolor = [1, 0, 0]\n").unwrap();
    assert_eq!(scene.surfaces[0].paint, Paint::Color([1.0, 0.0, 0.0]));
    assert_eq!(scene.surfaces[0].trims, read(&trimmed).surfaces[0].trims);
    assert!(scene.surfaces[0].trims.cut(dvec2(0.1, 0.1)));
    let circle = "[[surface.trim]]\ncircle = { center = [0.5, 0.5], radius = 0.2 }\n";
    for (file, count) in [("plain", 1), ("patches", 2)] {
        let scene = load(&format!("[[surface]]\nfile = \"{file}.obj\"\n{circle}")).unwrap();
        assert_eq!(scene.surfaces.len(), count);
        assert!(scene.surfaces.iter().all(|surface| surface.trims.circles.len() == 1));
    }
    for (table, words) in [
        (
            format!("[[surface]]\nfile = \"trimmed.obj\"\n{circle}"),
            [
                "scene.toml:3: trim or keep is beside a file whose surfaces have trims of their own",
                "without trims",
            ],
        ),
        (
            "[[surface]]\nfile = \"trimmed.obj\"\nkeep = \"outside\"\n".into(),
            ["scene.toml:3: trim or keep", "of their own"],
        ),
        (
            format!("[[surface]]\nfile = \"two.obj\"\n{circle}"),
            [
                "scene.toml:3: trim or keep is beside a file of several surfaces",
                "a file of one surface",
            ],
        ),
        (
            "[render]\nmethod = \"thesis\"\nlevel = 2\n[[surface]]\nfile = \"trimmed.obj\"\n"
                .into(),
            ["scene.toml:4: ", "NURBS surface"],
        ),
    ] {
        let said = load(&table).unwrap_err().to_string();
        assert!(words.iter().all(|words| said.contains(words)), "{table}: {said}");
    }
}
