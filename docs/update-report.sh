#!/bin/sh
# Measures on this machine and puts the report's plot and table into README.md, with today's date:
# sh docs/update-report.sh
set -eu
cd "$(dirname "$0")/.."
out=target/report
cargo run --release -- report --out "$out" --only tessellation --only trimming --only peers \
    --only models
cp "$out/summary.svg" docs/report.svg
awk -v table="$out/summary.md" -v date="$(date +%F)" '
    /^<!-- end of the report -->$/ { inside = 0 }
    !inside { print }
    /^<!-- report: made by docs\/update-report.sh -->$/ {
        inside = 1
        print ""
        while ((getline line < table) > 0)
            print line
        print "\n" date ". The plot is the teapot at 1000 × 600; the line across is half a pixel.\n"
        print "![Largest error over milliseconds a frame, by levels and by tolerance](docs/report.svg)\n"
    }
' README.md > "$out/README.md"
cp "$out/README.md" README.md
