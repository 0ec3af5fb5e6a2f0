//! Parsers answer any input with a result or an error, within bounds of memory. This test is a crate of its own,
//! because it has an allocator that counts.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::{BufReader, Read as _};
use std::path::Path;

use freeform_surface::inspect::TrimGrid;
use freeform_surface::model::Model;
use freeform_surface::{CreaseAngle, Degree, LoadOptions, Mesh, Scene, TrimLoop, Trims};
use glam::vec2;
use proptest::prelude::*;

thread_local! {
    /// The bytes that this thread has allocated and not released, and their peak.
    static NOW: Cell<isize> = const { Cell::new(0) };
    static MAX: Cell<isize> = const { Cell::new(0) };
}

/// Counts bytes that the current thread allocates or releases.
fn count(bytes: isize) {
    // A thread that ends has no counters any more.
    let _ = NOW.try_with(|now| {
        now.set(now.get() + bytes);
        let _ = MAX.try_with(|max| max.set(max.get().max(now.get())));
    });
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size().cast_signed());
        // SAFETY: as the caller promised.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-layout.size().cast_signed());
        // SAFETY: as the caller promised.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The peak of bytes that `work` allocated in this thread, beyond those allocated before.
fn most_memory(work: impl FnOnce()) -> usize {
    let before = NOW.get();
    MAX.set(before);
    work();
    (MAX.get() - before).unsigned_abs()
}

fn parse(text: &str) {
    for scene in
        [Scene::from_toml(text, Path::new("x.toml")), Scene::from_bpt(text, Path::new("x.bpt"))]
    {
        match scene {
            Ok(scene) => assert!(!scene.surfaces.is_empty() || !scene.meshes.is_empty()),
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        }
    }
}

const SCENE: &str = r#"
[camera]
eye = [0.45, 1.05, 1.15]
target = [0.0, 0.1, 0.0]
fov_y_degrees = 40.0
[render]
method = "thesis"
level = 32
newton = { iterations = 10, epsilon = 0.001 }
background = [0.2, 0.3, 0.3, 1.0]
[[surface]]
control_points = "default"
translate = [1.0, 2.0, 3.0]
rotate_degrees = [0.0, 90.0, 0.0]
color = [0.75, 0.75, 0.8]
[[surface.trim]]
circle = { center = [0.5, 0.5], radius = 0.2 }
[[surface.trim]]
interval = { u = [0.1, 0.2], v = [0.1, 0.2] }
[[surface.trim]]
ellipse = { center = [0.5, 0.5], radii = [0.2, 0.1] }
[[surface.trim]]
loop = [[[0.2, 0.5], [0.5, 0.9], [0.8, 0.5]], [[0.8, 0.5], [0.5, 0.1], [0.2, 0.5]]]
[[mesh]]
file = "resources/meshes/cube.obj"
smoothing = "phong"
alpha = 0.5
level = 3
crease_degrees = 30.0
color = [0.5, 0.5, 0.5]
scale = 2.0
"#;

const TRIMMED: &str = r#"
render = { method = "exact", samples = 4 }
[[surface]]
control_points = "default"
keep = "inside"
[[surface.trim]]
path = "M0 0H1V1H0Z m.2 .2 l.1 0 q.1.1 0 .2 t-.1 0z M.5.5c.1 0 .2.1.2.2s-.1.2-.2 0A.1.2 30 0 1 .5.5Z"
"#;

const FREE_FORM: &str = "v 0 0 0 1\nv 1 0 0 0.5\nv 0 1 0\nv 1 1 1 2\nvp 0.2 0.2\nvp 0.8 0.2 0.5\nvp 0.5 0.8\n\
    cstype rat bspline\ndeg 2\ncurv2 1 2 3 1\nparm u 0 0 0 1 2 2 2\nend\ncstype bezier\ndeg 1 1\ncurv2 -3 -2 -1 -3\n\
    parm u 0 1 2 3\nend\nsurf 0 2 0 1 1 2 3 4\nparm u 0 2\ntrim 0.5 1.5 1 0 1 2\nhole 3 0 2\nend\n\
    cstype rat bspline\nsurf 0 1 0 1 -4 -3/1 -2//1 -1\nparm u 0 0 1 1\nparm v 0 0 1 1\ntrim 0 2 1\nend\n";

/// A model with every kind of record, and models of solids.
const MODELS: [&[u8]; 4] = [
    include_bytes!("harness/every_record.ffm"),
    include_bytes!("../resources/models/assembly.ffm"),
    include_bytes!("../resources/models/blade.ffm"),
    include_bytes!("../resources/models/bracket.ffm"),
];

/// Reads a model from bytes, within the memory that any file may take.
fn parse_model(bytes: &[u8]) {
    let mut result = None;
    let memory = most_memory(|| result = Some(Model::read(bytes, Path::new("x.ffm"))));
    match result.expect("it was read") {
        Ok(model) => {
            model.check().unwrap();
            let mut text = Vec::new();
            model.write(&mut text).unwrap();
            assert_eq!(Model::read(text.as_slice(), Path::new("x.ffm")).unwrap(), model);
            drop(model.instances());
            for error in model.drawn_faces().into_iter().filter_map(Result::err) {
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
            }
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    }
    // A message takes room, however short the file is.
    let limit = 20 * bytes.len() + 1024;
    assert!(memory <= limit, "{memory} bytes for a file of {}", bytes.len());
}

/// What replaces a piece of a model.
#[derive(Debug, Clone)]
enum Piece {
    Bytes(Vec<u8>),
    /// Another piece of the model.
    Copy {
        start: prop::sample::Index,
        length: usize,
    },
}

/// Words that are wrong in most places.
const WORDS: [&str; 15] = [
    "1e999",
    "-0",
    "99999999999999999999",
    "18446744073709551615",
    "nan",
    "end",
    "edge",
    "face",
    "product",
    "use 0",
    "loop",
    "nurbs",
    "pcurve",
    "knots 9999999999",
    "points 65536 65536",
];

/// The number of mutated models: 100,000 in the long tests.
fn model_cases() -> u32 {
    if std::env::var_os("FREEFORM_TEST_LONG").is_some() { 100_000 } else { 1_000 }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None, cases: model_cases(), ..ProptestConfig::default()
    })]

    #[test]
    fn a_model_with_pieces_replaced_gets_an_answer(
        model in prop::sample::select(&MODELS),
        pieces in prop::collection::vec(
            (
                any::<prop::sample::Index>(), 0usize..40,
                prop_oneof![
                    "[-+.0-9a-z \"\\\\#\n]{0,12}".prop_map(|text| Piece::Bytes(text.into_bytes())),
                    prop::sample::select(&WORDS).prop_map(|word| Piece::Bytes(word.into())),
                    prop::collection::vec(any::<u8>(), 0..12).prop_map(Piece::Bytes),
                    (any::<prop::sample::Index>(), 0usize..200)
                        .prop_map(|(start, length)| Piece::Copy { start, length }),
                ],
            ),
            1..4,
        )
    ) {
        let mut bytes = model.to_vec();
        for (start, length, piece) in pieces {
            let piece = match piece {
                Piece::Bytes(bytes) => bytes,
                Piece::Copy { start, length } => {
                    let rest = &model[start.index(model.len())..];
                    rest[..length.min(rest.len())].to_vec()
                }
            };
            let start = start.index(bytes.len() + 1);
            bytes.splice(start..(start + length).min(bytes.len()), piece);
        }
        parse_model(&bytes);
    }
}

#[test]
fn a_model_cut_off_anywhere_gets_an_answer() {
    for model in MODELS {
        (0..model.len()).for_each(|length| parse_model(&model[..length]));
    }
}

/// A word of a gibibyte is not read to its end; a comment of a gibibyte is, in little memory.
#[test]
fn a_line_of_one_gib_is_read_in_little_memory() {
    for (start, byte) in
        [("", b'x'), ("", b' '), ("", 0), ("#", b'x'), ("freeform-model 1 name \"", b'x')]
    {
        let memory = most_memory(|| {
            let line = std::io::repeat(byte).take(1 << 30);
            let reader = BufReader::new(start.as_bytes().chain(line));
            let error = Model::read(reader, Path::new("x.ffm")).unwrap_err().to_string();
            assert!(error.starts_with("x.ffm:1: ") && error.len() < 100, "{error}");
        });
        assert!(memory < 1 << 16, "{memory} bytes");
    }
}

/// The records that take the most memory for their text.
#[test]
fn a_model_takes_at_most_20_times_its_file() {
    const MIB: usize = 1 << 20;
    let filled = |piece: &str| piece.repeat(MIB / piece.len());
    let plane = "plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 ";
    let face = format!("face tolerance 0 forward bounds 0 1 0 1 {plane}");
    let nurbs = "face tolerance 0 forward bounds 0 1 0 1 nurbs ";
    let pcurve = "+ 0 pcurve degree 1 knots 4 0 0 1 1 points 2 0 0 1 0 0 1 ";
    let turned = "use 0 columns 1 0 0 0 1 0 0 0 1 0 0 0 ";
    for (name, text) in [
        ("points", filled("edge tolerance 0 point ")),
        ("lines", filled("edge tolerance 0 range 0 1 line 0 0 0 1 0 0 ")),
        ("faces", filled(&face)),
        (
            "edges of a loop",
            format!("edge tolerance 0 point {face} loop {} {}", MIB / 4, filled("+ 0 ")),
        ),
        (
            "edges announced",
            format!("edge tolerance 0 point {face} loop {} {}", u64::MAX, filled("+ 0 ")),
        ),
        ("loops", format!("edge tolerance 0 point {face}{}", filled("loop 1 + 0 "))),
        (
            "curves in parameters",
            format!("edge tolerance 0 point {face} loop {MIB} {}", filled(pcurve)),
        ),
        ("knots", format!("{nurbs} degree 1 1 knots {} {}", MIB / 2, filled("0 "))),
        ("knots announced", format!("{nurbs} degree 1 1 knots {} {}", u64::MAX, filled("0 "))),
        (
            "control points",
            format!(
                "{nurbs} degree 1 1 knots 4 0 0 1 1 knots {} {} points 2 {} {}",
                MIB / 18 + 2,
                // The knots rise only in the middle, which is enough.
                "0 ".repeat(MIB / 36) + &"1 ".repeat(MIB / 18 + 2 - MIB / 36),
                MIB / 18,
                "0 0 0 1 ".repeat(MIB / 9),
            ),
        ),
        ("products", filled("product faces 0 0 ")),
        ("uses", format!("product faces 0 0 product faces 0 0 {}", filled(turned))),
        ("names", filled("product name \"\" faces 0 0 ")),
        ("white space", filled(" ")),
        ("a comment", format!("#{}", filled("x"))),
        ("a word", filled("x")),
        ("a text", format!("name \"{}", filled("x"))),
    ] {
        let text = format!("freeform-model 1 {text}");
        let memory = most_memory(|| drop(Model::from_text(&text, Path::new("x.ffm"))));
        println!("{name}: {:.1} times the file", memory as f64 / text.len() as f64);
        assert!(memory <= 20 * text.len(), "{name}: {memory} bytes for {}", text.len());
    }
}

#[test]
fn an_error_of_a_file_holds_the_error_of_the_system() {
    let error = Scene::load("none.toml".as_ref()).unwrap_err();
    let source = std::error::Error::source(&error).expect("a source");
    let system: &std::io::Error = source.downcast_ref().expect("the system's");
    assert_eq!(system.kind(), std::io::ErrorKind::NotFound);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_gets_an_answer(text in "\\PC{0,300}") {
        parse(&text);
    }

    #[test]
    fn any_numbers_get_an_answer(
        values in prop::collection::vec(
            prop_oneof![
                Just("3".to_owned()), Just("4".to_owned()), Just("5".to_owned()), Just("nan".to_owned()),
                any::<f64>().prop_map(|v| v.to_string()), any::<u64>().prop_map(|v| v.to_string()),
            ],
            0..120,
        )
    ) {
        parse(&values.join(" "));
    }

    #[test]
    fn a_scene_with_a_piece_replaced_gets_an_answer(
        start in 0..SCENE.len(), length in 0usize..30, piece in "[-+.0-9a-z\\[\\]{}=\", \n#]{0,12}"
    ) {
        let end = (start + length).min(SCENE.len());
        parse(&format!("{}{piece}{}", &SCENE[..start], &SCENE[end..]));
    }

    #[test]
    fn a_free_form_surface_with_a_piece_replaced_gets_an_answer(
        start in 0..FREE_FORM.len(), length in 0usize..30, piece in "[-+.0-9a-z \n]{0,12}"
    ) {
        let end = (start + length).min(FREE_FORM.len());
        let text = format!("v 0 0 0\n{}{piece}{}", &FREE_FORM[..start], &FREE_FORM[end..]);
        if let Err(error) = Scene::from_text(&text, Path::new("x.obj"), &LoadOptions::default()) {
            assert_eq!(error.to_string().lines().count(), 1, "{error}");
        }
    }

    #[test]
    fn a_path_with_a_piece_replaced_gets_an_answer(
        start in 0..TRIMMED.len(), length in 0usize..30, piece in "[-+.0-9a-zA-Z\", \n]{0,12}"
    ) {
        let end = (start + length).min(TRIMMED.len());
        parse(&format!("{}{piece}{}", &TRIMMED[..start], &TRIMMED[end..]));
    }

    #[test]
    fn any_path_gets_an_answer(data in "[MmLlHhVvQqTtCcSsAaZz0-9.e, -]{0,80}|\\PC{0,60}") {
        let mut trims = Trims::default();
        match TrimLoop::from_svg_path(&data) {
            Ok(loops) => {
                assert!(!loops.is_empty());
                trims.loops = loops;
                // Any path that was read can be compiled and evaluated.
                let _ = TrimGrid::new(&trims).cut(vec2(0.5, 0.5));
            }
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        }
    }

    #[test]
    fn patches_are_read_back_as_written(
        degrees in prop::collection::vec([1..=15_usize, 1..=15_usize], 1..6), counts in prop::bool::ANY,
        seed in any::<u32>(),
    ) {
        let value = |i: usize| f64::from(seed.wrapping_mul(i as u32 + 1) % 1000) / 8.0;
        let mut text = format!("{}\n", degrees.len());
        for [u, v] in &degrees {
            let extra = usize::from(counts);
            text += &format!("{} {}\n", u + extra, v + extra);
            for i in 0..(u + 1) * (v + 1) {
                text += &format!("{} {} {}\n", value(i), -value(i + 1), value(i + 2));
            }
        }
        let scene = Scene::from_bpt(&text, Path::new("x.bpt")).unwrap();
        let patches: Vec<_> = scene.surfaces.iter().flat_map(|surface| surface.patches()).collect();
        prop_assert_eq!(patches.len(), degrees.len());
        for (patch, [u, v]) in patches.iter().zip(degrees) {
            prop_assert_eq!(patch.degree(), Degree::new(u, v).unwrap());
            for (i, point) in patch.points().iter().enumerate() {
                prop_assert_eq!(point.to_array(), [value(i), -value(i + 1), value(i + 2), 1.0]);
            }
        }
    }
}

#[test]
fn a_file_of_one_mib_never_takes_more_than_64() {
    const MIB: usize = 1 << 20;
    let filled = |piece: &str| piece.repeat(MIB / piece.len());
    let mut patch = String::from("3 3 ");
    patch += &"0 ".repeat(48);
    let count = MIB / patch.len();
    // Surfaces of about this text each, as many of them as fill the file.
    let in_surfaces = |piece: &str| {
        let surface = format!("[[surface]]\n{}", piece.repeat((200_000 / piece.len()).max(1)));
        surface.repeat((MIB / surface.len()).max(1))
    };
    let numbered = |before: &str, after: &str| -> String {
        (0..20_000).map(|i| format!("{before}{i:05}{after}")).collect()
    };
    let in_path = |commands: &str| {
        format!(
            "[[surface]]\ncontrol_points=\"default\"\n[[surface.trim]]\npath=\"M0 0{commands}z\"\n"
        )
    };
    let mut max = 0;
    for (name, text) in [
        ("numbers", filled("1 ")),
        ("many patches", format!("{count}\n{}", patch.repeat(count))),
        ("a large count", format!("1073741824 {}", filled("3 "))),
        ("brackets", filled("[")),
        ("an array", format!("surface = [{}]", filled("1,"))),
        ("tables in an array", format!("surface = [{}]", filled("{},"))),
        ("empty surfaces", filled("[[surface]]\n")),
        ("surfaces", filled("[[surface]]\ncontrol_points=\"default\"\n")),
        ("inline surfaces", format!("surface=[{}]", filled("{control_points=\"default\"},"))),
        ("meshes", filled("[[mesh]]\nfile=\"x.obj\"\n")),
        ("inline meshes", format!("mesh=[{}]", filled("{file=\"x.obj\"},"))),
        ("trims", in_surfaces("[[surface.trim]]\ncircle={center=[0,0],radius=1}\n")),
        ("trims in arrays", in_surfaces("trim=[{loop=[[[0,0],[0,0]],[[0,0],[0,0]]]}]\n")),
        (
            "inline trims",
            in_surfaces(&format!("trim=[{}]\n", "{circle={center=[0,0],radius=1}},".repeat(6_000))),
        ),
        ("points", in_surfaces(&format!("control_points=[{}]\n", "[0,0,0],".repeat(28_000)))),
        ("flat points", in_surfaces(&format!("control_points=[{}]\n", "0,".repeat(110_000)))),
        ("tables", in_surfaces("[a]\n")),
        ("tables in a surface", in_surfaces("a={}\n")),
        ("keys in a surface", in_surfaces(&numbered("k", "=1\n"))),
        ("tables by dots", in_surfaces(&numbered("k", ".a=1\n"))),
        ("dots in a surface", in_surfaces(&format!("{}=1\n", "a.".repeat(100_000)))),
        ("inline tables", in_surfaces(&format!("trim=[{}]\n", "{a={}},".repeat(30_000)))),
        ("keys", (0..MIB / 10).map(|i| format!("k{i:06}=1\n")).collect()),
        ("dots", format!("{}=1", filled("a."))),
        ("a quote in quotes", format!("trim=['\"',{}]", filled("{a={}},"))),
        ("strings", in_surfaces(&format!("trim=[{}]\n", "\"\",".repeat(60_000)))),
        ("longer strings", in_surfaces(&format!("trim=[{}]\n", "\"xxxxxxxx\",".repeat(18_000)))),
        ("keys in quotes", in_surfaces(&numbered("\"", "\"=1\n"))),
        ("one path", in_path(&"h1".repeat(MIB / 2 - 100))),
        ("a path of curves", in_path(&"t1 1".repeat(MIB / 4 - 100))),
        ("a string", format!("surface = \"{}\"", filled("x"))),
        ("comments", filled("#\n")),
    ] {
        assert!((MIB / 2..=MIB + 4096).contains(&text.len()), "{name} has {} bytes", text.len());
        let toml = most_memory(|| drop(Scene::from_toml(&text, Path::new("x.toml"))));
        let bpt = most_memory(|| drop(Scene::from_bpt(&text, Path::new("x.bpt"))));
        println!("{name}: {} MiB as .toml, {} MiB as .bpt", toml / MIB, bpt / MIB);
        max = max.max(toml).max(bpt);
    }
    assert!(max <= 64 * MIB, "{max} bytes");
    // An arc becomes up to 20 cubics, and a subpath of one line becomes a loop of two. Both take more memory
    // than their text.
    for piece in ["a9 9 0 1 1 1 9", "a9e14 9e14 0 1 1 9 9e14", "zh1"] {
        let text = in_path(&piece.repeat(MIB / piece.len() - 100));
        let bytes = most_memory(|| drop(Scene::from_toml(&text, Path::new("x.toml"))));
        assert!(bytes <= 160 * MIB, "{piece}: {bytes} bytes");
    }
}

/// Reading takes memory in proportion to the triangles: a file of two million fits in half a gigabyte.
#[test]
fn a_mesh_takes_few_bytes_a_triangle() {
    for side in [50, 160, 500] {
        let mut text = String::new();
        for i in 0..(side + 1) * (side + 1) {
            let (x, y) = (i % (side + 1), i / (side + 1));
            text += &format!("v {x} {y} {}\n", x * y % 7);
        }
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let a = y * (side + 1) + x + 1;
            let b = a + side + 1;
            text += &format!("f {a} {} {}\nf {a} {} {b}\n", a + 1, b + 1, b + 1);
        }
        let path = Path::new("x.obj");
        let crease = CreaseAngle::default();
        let max = most_memory(|| drop(Mesh::read_obj(text.as_bytes(), path, crease).unwrap()));
        let each = max / (2 * side * side);
        println!("{side}: {each} bytes a triangle");
        // The mesh itself takes about 80 bytes. The rest is for its neighbours and normals while they are
        // computed.
        assert!(each <= 180, "{each} bytes for each of {} triangles", 2 * side * side);
    }
}

#[test]
fn the_teapot_has_32_bicubic_patches() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/surfaces/teapot.bpt");
    let scene = Scene::load(&path).unwrap();
    assert_eq!(scene.surfaces.len(), 1);
    assert_eq!(scene.surfaces[0].degree(), Degree::CUBIC);
    assert_eq!(scene.surfaces[0].patches().len(), 32);
}
