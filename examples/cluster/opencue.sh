#!/bin/sh
# Writes a command a line for OpenCue, each for a part of the pictures: `sh opencue.sh LIST OUT 8 > commands.txt`. Then
# `cuecmd commands.txt` makes a job with a frame for each line; a frame that is retried goes on where it was killed.
# LIST has the path of a scene a line, OUT is a folder that all machines share; both are absolute paths.
set -eu
for part in $(seq "$3"); do
    echo "freeform render --list $1 -o $2 --resume --shard $part/$3"
done
