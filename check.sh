#!/bin/sh
# Everything that must hold before a commit; continuous integration runs the same.
set -eu
cd "$(dirname "$0")"

# Both backends, whether installed or not: a missing one must fail here.
export FREEFORM_TEST_BACKENDS="${FREEFORM_TEST_BACKENDS:-egl,osmesa}"

# Chromium, which looks at the report's page, and libGLU, which it is measured beside, too.
export FREEFORM_TEST_REPORT=1

sh setup.sh check
# The reader of CAD files: its warnings are errors, and the tests of real files need it.
sh setup.sh cad
cargo fmt --check
cargo clippy --release --all-targets --features viewer -- -D warnings
cargo clippy --release -- -D warnings
cargo clippy --release --no-default-features -- -D warnings
cargo test --release --no-default-features --features inspect
RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps --document-private-items --features viewer
cargo test --release --features viewer --bin freeform --test window --example demo
# The command of the README, word for word.
sh setup.sh tests && cargo test --release
# Pictures on a cluster of one node, where Slurm can be installed.
sh tests/slurm.sh target/release/freeform
