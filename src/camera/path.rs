//! Cameras that move: along keys, and around a scene.

use glam::{DQuat, DVec3};

use super::{Camera, Lens};
use crate::error::{Error, Result};

/// Where a camera is at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraKey {
    /// The time, counted in frames: frame 12 shows time 12.
    pub time: f64,
    /// The eye in world space.
    pub eye: DVec3,
    /// The point in the middle of the picture.
    pub target: DVec3,
    /// The vertical direction.
    pub up: DVec3,
}

/// A camera that passes its keys at their times and moves smoothly in between.
///
/// Eye, target and up each follow cubics with continuous derivatives. At a key, the derivative is that of the parabola
/// through the key and its two neighbours; at the first and the last key, it is the one that makes a parabola of the
/// first and of the last piece. So a motion along parabolas is exact, and two keys make a motion along a line. Before
/// the first key the camera stands there, and after the last one here.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    keys: Vec<CameraKey>,
}

/// Eye, target and up.
type Place = [DVec3; 3];

impl CameraPath {
    /// A path through keys in the order of their times.
    ///
    /// # Errors
    /// No key, a time that is not finite or not after the one before, a key at which there can be no camera
    /// ([`Camera::new`]).
    pub fn new(keys: Vec<CameraKey>) -> Result<Self> {
        if keys.is_empty() {
            return Err(Error::invalid("camera keys", "none", "one or more"));
        }
        let mut before = f64::NEG_INFINITY;
        for key in &keys {
            key.check_after(before)?;
            before = key.time;
        }
        Ok(Self { keys })
    }

    /// The keys, in the order of their times.
    #[must_use]
    pub fn keys(&self) -> &[CameraKey] {
        &self.keys
    }

    /// The camera at a time.
    ///
    /// # Errors
    /// There can be no camera: between two keys, the eye may meet the target, or up the line of sight.
    pub fn at(&self, time: f64, lens: Lens) -> Result<Camera> {
        let next = self.keys.partition_point(|key| key.time <= time);
        let [eye, target, up] = match next {
            0 => self.keys[0].place(),
            next if next == self.keys.len() => self.keys[next - 1].place(),
            next => self.between(next - 1, time),
        };
        Camera::new(eye, target, up, lens)
    }

    /// The place at a time between a key and the next.
    fn between(&self, number: usize, time: f64) -> Place {
        let [from, to] = [self.keys[number], self.keys[number + 1]];
        let length = to.time - from.time;
        let t = (time - from.time) / length;
        let [a, b] = [from.place(), to.place()];
        let [in_a, in_b] = [self.derivative(number), self.derivative(number + 1)];
        std::array::from_fn(|i| {
            // Hermite's form.
            let (s, rise) = (1.0 - t, b[i] - a[i]);
            let [off_a, off_b] = [in_a[i] * length - rise, rise - in_b[i] * length];
            a[i] + t * rise + t * s * (s * off_a + t * off_b)
        })
    }

    /// The derivative by time at a key.
    fn derivative(&self, number: usize) -> Place {
        let last = self.keys.len() - 1;
        match number {
            _ if last == 0 => [DVec3::ZERO; 3],
            _ if last == 1 => self.slope(0),
            0 => self.end_derivative(0, 1),
            _ if number == last => self.end_derivative(last - 1, last - 1),
            _ => self.inner_derivative(number),
        }
    }

    fn inner_derivative(&self, number: usize) -> Place {
        let [before, here, after] = [number - 1, number, number + 1].map(|key| self.keys[key].time);
        let [left, right] = [self.slope(number - 1), self.slope(number)];
        let share = (here - before) / (after - before);
        std::array::from_fn(|i| left[i] * (1.0 - share) + right[i] * share)
    }

    /// The derivative at the end of a piece of which `inner` is the other end.
    fn end_derivative(&self, piece: usize, inner: usize) -> Place {
        let (slope, inner) = (self.slope(piece), self.inner_derivative(inner));
        std::array::from_fn(|i| 2.0 * slope[i] - inner[i])
    }

    /// The mean derivative between a key and the next.
    fn slope(&self, number: usize) -> Place {
        let [from, to] = [self.keys[number], self.keys[number + 1]];
        let [a, b] = [from.place(), to.place()];
        std::array::from_fn(|i| (b[i] - a[i]) / (to.time - from.time))
    }
}

impl CameraKey {
    fn place(&self) -> Place {
        [self.eye, self.target, self.up]
    }

    /// Checks that there can be a camera, after a key of an earlier time.
    pub(crate) fn check_after(&self, before: f64) -> Result<()> {
        if !self.time.is_finite() {
            return Err(Error::invalid("camera key time", self.time, "a finite number of frames"));
        }
        if self.time <= before {
            let expected = format!("more than {before}, the time of the key before");
            return Err(Error::invalid("camera key time", self.time, expected));
        }
        Camera::new(self.eye, self.target, self.up, Lens::default()).map(drop)
    }
}

/// A camera on a circle around an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turntable {
    pub(crate) start: Camera,
    pub(crate) center: DVec3,
    /// Of length 1.
    pub(crate) axis: DVec3,
}

impl Turntable {
    /// The camera after this many turns, counter-clockwise if the axis points at the viewer.
    #[must_use]
    pub fn at(&self, turns: f64) -> Camera {
        let Camera { eye, target, up, lens } = self.start;
        let turn = DQuat::from_axis_angle(self.axis, turns * std::f64::consts::TAU);
        let turned = |point: DVec3| self.center + turn * (point - self.center);
        Camera { eye: turned(eye), target: turned(target), up: turn * up, lens }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn key(time: f64, eye: DVec3) -> CameraKey {
        CameraKey { time, eye, target: dvec3(0.0, 0.0, -9.0), up: DVec3::Y }
    }

    fn eye(path: &CameraPath, time: f64) -> DVec3 {
        path.at(time, Lens::default()).unwrap().eye()
    }

    #[test]
    fn parabolas_and_lines_are_exact_whatever_the_times() {
        let parabola = |t: f64| dvec3(1.0 + t, 2.0 - 3.0 * t + 0.25 * t * t, 4.0 - t * t);
        for times in [&[1.0, 2.0, 4.5, 5.0, 9.0][..], &[0.0, 1.0, 7.0], &[-3.0, -1.0, 0.0, 10.0]] {
            let keys = times.iter().map(|time| key(*time, parabola(*time))).collect();
            let path = CameraPath::new(keys).unwrap();
            for step in 0..=100 {
                let time = times[0] + (times[times.len() - 1] - times[0]) * f64::from(step) / 100.0;
                let off = (eye(&path, time) - parabola(time)).length();
                assert!(off < 1e-12, "{times:?} at {time}: {off}");
            }
        }
        let path = CameraPath::new(vec![key(1.0, DVec3::ZERO), key(5.0, DVec3::X)]).unwrap();
        assert_eq!(eye(&path, 2.0), 0.25 * DVec3::X);
    }

    #[test]
    fn keys_are_passed_without_a_jump_of_place_or_speed() {
        let keys: Vec<_> = [(0.0, 0.0), (2.0, 5.0), (3.0, -1.0), (7.0, 2.0)]
            .map(|(time, x)| key(time, dvec3(x, x * x, 1.0)))
            .into();
        let path = CameraPath::new(keys.clone()).unwrap();
        for key in &keys {
            assert_eq!(eye(&path, key.time), key.eye);
        }
        for key in &keys[1..3] {
            let step = 1e-6;
            let [before, here, after] = [-step, 0.0, step].map(|off| eye(&path, key.time + off));
            let jump = ((after - here) - (here - before)) / step;
            assert!(jump.length() < 1e-3, "{jump}");
        }
        // The camera stands still outside of the keys, and at a single one.
        assert_eq!((eye(&path, -1.0), eye(&path, 99.0)), (keys[0].eye, keys[3].eye));
        let single = CameraPath::new(vec![keys[1]]).unwrap();
        assert!([0.0, 2.0, 9.0].iter().all(|time| eye(&single, *time) == keys[1].eye));
    }

    #[test]
    fn impossible_keys_are_refused() {
        let good = key(1.0, DVec3::ZERO);
        for (keys, word) in [
            (vec![], "none"),
            (vec![good, good], "more than 1"),
            (vec![good, key(0.5, DVec3::X)], "more than 1"),
            (vec![key(f64::NAN, DVec3::X)], "finite"),
            (vec![key(1.0, good.target)], "target"),
            (vec![CameraKey { up: DVec3::Z, ..good }], "line of sight"),
        ] {
            let text = CameraPath::new(keys).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
        // Half way, the eye is at the target.
        let other = key(3.0, dvec3(0.0, 0.0, -18.0));
        let path = CameraPath::new(vec![good, other]).unwrap();
        assert!(path.at(2.0, Lens::default()).unwrap_err().to_string().contains("target"));
    }

    #[test]
    fn a_turn_keeps_distances_and_comes_back() {
        let start =
            Camera::new(dvec3(4.0, 1.0, 0.0), dvec3(1.0, 0.0, 0.0), DVec3::Y, Lens::default())
                .unwrap();
        let table = Turntable { start, center: DVec3::X, axis: DVec3::Y };
        let quarter = table.at(0.25);
        assert!((quarter.eye() - dvec3(1.0, 1.0, -3.0)).length() < 1e-12, "{}", quarter.eye());
        assert!((quarter.target() - start.target()).length() < 1e-12);
        assert!((quarter.up() - DVec3::Y).length() < 1e-12);
        assert!((table.at(1.0).eye() - start.eye()).length() < 1e-12);
        let over = Turntable { axis: DVec3::Z, ..table }.at(0.25);
        assert!((over.up() - -DVec3::X).length() < 1e-12, "{}", over.up());
        assert!((over.eye() - dvec3(0.0, 3.0, 0.0)).length() < 1e-12, "{}", over.eye());
    }
}
