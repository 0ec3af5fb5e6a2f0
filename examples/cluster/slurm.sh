#!/bin/sh
# An array job of Slurm: each task draws its part of the pictures. A task that is requeued goes on where it was killed.
#
#     sbatch --array=1-8 --cpus-per-task=4 slurm.sh LIST OUT
#
# LIST has the path of a scene a line, OUT is a folder that all nodes share.
#SBATCH --job-name=freeform
#SBATCH --requeue
set -eu
mkdir -p "$2"
exec freeform render --list "$1" -o "$2" --resume \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    --jobs "${SLURM_CPUS_PER_TASK:-1}" --log "$2/log-$SLURM_ARRAY_TASK_ID.jsonl"
