//! Tests of the picture comparison: different pictures must fail.

use freeform_surface::Image;
use image::Rgba;

use crate::harness::{assert_same, difference, read_reference};

fn grey() -> Image {
    Image::from_pixel(20, 10, Rgba([100, 100, 100, 255]))
}

fn fails(name: &str, expected: &Image, actual: &Image, left_out: &[bool]) -> String {
    let run = || assert_same(name, expected, actual, left_out, 2);
    let panic = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).unwrap_err();
    panic.downcast_ref::<String>().unwrap().clone()
}

#[test]
fn a_difference_within_the_tolerance_passes() {
    let mut actual = grey();
    actual.put_pixel(3, 4, Rgba([102, 98, 100, 255]));
    assert_same("within", &grey(), &actual, &[], 2);
}

#[test]
fn one_pixel_fails_and_the_pictures_are_written() {
    for off in [Rgba([103, 100, 100, 255]), Rgba([100, 100, 100, 250])] {
        let mut actual = grey();
        actual.put_pixel(3, 4, off);
        let message = fails("one-pixel", &grey(), &actual, &[]);
        assert!(message.contains("wrong: 1") && message.contains("(3, 4)"), "{message}");
        let path = message.rsplit(": ").next().unwrap();
        assert_eq!(image::image_dimensions(path).unwrap(), (60, 10));
    }
}

#[test]
fn a_pixel_that_is_left_out_passes_and_its_neighbour_does_not() {
    let mut actual = grey();
    actual.put_pixel(3, 4, Rgba([0; 4]));
    let mut left_out = vec![false; 200];
    left_out[4 * 20 + 3] = true;
    assert_same("left-out", &grey(), &actual, &left_out, 2);
    actual.put_pixel(4, 4, Rgba([0; 4]));
    fails("left-out-neighbour", &grey(), &actual, &left_out);
}

#[test]
fn another_size_a_blank_picture_and_nothing_to_compare_fail() {
    fails("size", &grey(), &Image::new(10, 20), &[]);
    fails("blank", &grey(), &Image::new(20, 10), &[]);
    fails("nothing", &grey(), &grey(), &[true; 200]);
    assert!(difference(&grey(), &Image::new(10, 20), &[], 2).unwrap_err().contains("sizes"));
}

#[test]
fn a_missing_reference_fails() {
    let read = || read_reference("tests/references/no-such-picture.png".as_ref());
    let panic = std::panic::catch_unwind(read).unwrap_err();
    assert!(panic.downcast_ref::<String>().unwrap().contains("UPDATE_REFERENCES=1"));
}
