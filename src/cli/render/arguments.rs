//! The options of `freeform render` for many pictures.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::{Args, ValueEnum};
use freeform_surface::glam::DVec3;
use sha2::{Digest as _, Sha256};

/// The largest number of a frame.
const MAX_FRAME: i64 = 9_999_999;

#[derive(Debug, Args)]
pub(in crate::cli) struct BatchArguments {
    /// A file with the paths of more scenes or folders, one a line; "-" for standard input. Their pictures keep the
    /// folders of these paths, below the folder of the output.
    #[arg(long, value_name = "FILE")]
    pub(super) list: Option<PathBuf>,

    /// Also render the scenes of folders within the given folders.
    #[arg(long)]
    pub(super) recursive: bool,

    /// How many processes draw pictures at the same time. By default as many as the processor has cores if the driver
    /// draws on the CPU, or 1.
    #[arg(long, value_name = "N")]
    pub(super) jobs: Option<NonZeroUsize>,

    /// How long a picture may take, in seconds, from reading its scene to writing its file.
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub(super) timeout: Option<Duration>,

    /// Render only the part I of N of the pictures, 1 to N. To which part a picture belongs depends only on its name
    /// below the folder of the output.
    #[arg(long, value_name = "I/N")]
    pub(super) shard: Option<Shard>,

    /// Keep pictures that are whole and were made from the same files by the same settings and version.
    #[arg(long)]
    pub(super) resume: bool,

    /// Append a line of JSON about each picture to this file: input, output, status, error, ms, triangles,
    /// largest_bound (px), peak_memory (bytes).
    #[arg(long, value_name = "FILE.jsonl")]
    pub(super) log: Option<PathBuf>,

    /// Draw this many pictures of each scene, of a camera that goes once around it; their names end in the number of the
    /// frame, from -0001 on.
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(1..=MAX_FRAME))]
    pub(super) turntable: Option<u32>,

    /// The axis that the camera goes around: x, y or z. By default the axis that is vertical in the scene.
    #[arg(long, value_name = "AXIS", requires = "turntable")]
    pub(super) axis: Option<Axis>,

    /// Draw the frames A to B: of the turntable, or of the scene's camera_key tables, whose times are numbers of
    /// frames.
    #[arg(long, value_name = "A-B")]
    pub(super) frames: Option<FrameRange>,

    /// Draw what standard input asks for, one line of JSON for each picture.
    #[arg(long, hide = true)]
    pub(super) worker: bool,
}

impl BatchArguments {
    /// Whether any of them is given.
    pub(super) const fn is_used(&self) -> bool {
        let Self { list, recursive, jobs, timeout, shard, resume, log, worker: _, .. } = self;
        let Self { turntable, axis: _, frames, .. } = self;
        turntable.is_some()
            || frames.is_some()
            || list.is_some()
            || *recursive
            || jobs.is_some()
            || timeout.is_some()
            || shard.is_some()
            || *resume
            || log.is_some()
    }
}

/// An axis of world space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    pub(super) const fn direction(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

/// Frames with no gap between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FrameRange {
    pub(super) first: u32,
    pub(super) last: u32,
}

impl FromStr for FrameRange {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (first, last) = text.split_once('-').unwrap_or((text, text));
        let range = first.parse().ok().zip(last.parse().ok());
        range
            .map(|(first, last)| Self { first, last })
            .filter(|range| range.first <= range.last && i64::from(range.last) <= MAX_FRAME)
            .ok_or("expected A-B, two whole numbers from 0 to 9999999, A at most B")
    }
}

/// A part of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shard {
    /// From 1.
    number: u64,
    count: u64,
}

impl Shard {
    /// Whether a picture of this name belongs to the part.
    pub(super) fn has(self, name: &str) -> bool {
        let digest = Sha256::digest(name);
        let first = digest.first_chunk().expect("a digest has 32 bytes");
        u64::from_be_bytes(*first) % self.count == self.number - 1
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.split_once('/')
            .and_then(|(number, count)| {
                Some(Self { number: number.parse().ok()?, count: count.parse().ok()? })
            })
            .filter(|shard| (1..=shard.count).contains(&shard.number))
            .ok_or("expected I/N, two whole numbers, I from 1 to N")
    }
}

fn seconds(text: &str) -> Result<Duration, &'static str> {
    text.parse()
        .ok()
        .filter(|seconds| (0.001..=1e9).contains(seconds))
        .map(Duration::from_secs_f64)
        .ok_or("expected a number of seconds from 0.001 to 1e9")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_in_one_shard_and_shards_are_of_similar_size() {
        for count in [1, 3, 7] {
            let shards: Vec<Shard> =
                (1..=count).map(|number| format!("{number}/{count}").parse().unwrap()).collect();
            let mut sizes = vec![0_usize; shards.len()];
            for number in 0..2100 {
                let name = format!("folder/scene{number}.png");
                let own: Vec<usize> =
                    (0..shards.len()).filter(|shard| shards[*shard].has(&name)).collect();
                assert_eq!(own.len(), 1, "{name}: {own:?}");
                sizes[own[0]] += 1;
            }
            let fair: usize = 2100 / shards.len();
            assert!(sizes.iter().all(|size| size.abs_diff(fair) < fair / 3), "{sizes:?}");
        }
        // Machines of a cluster may run different builds: the parts must never change. The number is that of
        // `printf x.png | sha256sum`: 0x3910c6508d0ae9c1.
        assert!(Shard { number: 1 + 0x3910_c650_8d0a_e9c1 % 7, count: 7 }.has("x.png"));
    }

    #[test]
    fn wrong_shards_frames_and_times_are_refused() {
        for text in ["", "1", "0/3", "4/3", "1/0", "-1/3", "a/b", "1/3/5"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        for text in ["", "0", "-1", "nan", "inf", "1e10"] {
            assert!(seconds(text).is_err(), "{text}");
        }
        for text in ["", "1-", "-1", "2-1", "1-2-3", "1-10000000", "a-b"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
        assert_eq!("7".parse(), Ok(FrameRange { first: 7, last: 7 }));
        assert_eq!("0-12".parse(), Ok(FrameRange { first: 0, last: 12 }));
        assert_eq!(seconds("0.5"), Ok(Duration::from_millis(500)));
    }
}
