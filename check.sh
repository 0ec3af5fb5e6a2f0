#!/bin/sh
# Everything that must hold before a commit; continuous integration runs the same.
set -eu
cd "$(dirname "$0")"

cargo fmt --check
cargo clippy --release --all-targets -- -D warnings
cargo clippy --release --no-default-features -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps --document-private-items
# The command of the README, word for word.
sh setup.sh tests && cargo test --release
