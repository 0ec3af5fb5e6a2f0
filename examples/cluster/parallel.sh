#!/bin/sh
# GNU parallel shares the parts out among machines: `sh parallel.sh LIST OUT 8 --sshloginfile machines`. Without a file of
# machines, all parts are drawn on this one. LIST has the path of a scene a line, OUT is a folder that all machines share.
set -eu
list="$1" out="$2" parts="$3"
shift 3
mkdir -p "$out"
seq "$parts" | parallel --quote "$@" --wd . --halt never --retries 3 \
    freeform render --list "$list" -o "$out" --resume --shard "{}/$parts" --log "$out/log-{}.jsonl"
