#!/bin/sh
# Runs examples/cluster/slurm.sh on a Slurm of one node: an array of 8 tasks over 400 pictures, one of which is killed
# in the middle and requeued. The pictures must be those of a single run. Debian and Ubuntu, as root; elsewhere it says
# that nothing was tested.
#
#     sh tests/slurm.sh target/release/freeform
set -eu
program="$(realpath "$1")"
root="$(realpath "$(dirname "$0")/..")"

if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null 2>&1; then
    echo "Slurm cannot be installed here: the array job was not tested"
    exit 0
fi
if ! command -v slurmctld >/dev/null 2>&1 || ! command -v slurmd >/dev/null 2>&1; then
    DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
        munge slurm-client slurmctld slurmd >/dev/null 2>&1 ||
        { echo "Slurm cannot be installed here: the array job was not tested"; exit 0; }
fi

folder="$(mktemp -d)"
daemons=""
job=""
stop() {
    # After a failure, tasks may still run.
    if [ -n "$job" ] && scancel --signal=KILL --full "$job" 2>/dev/null; then
        sleep 2
    fi
    for daemon in $daemons; do kill "$daemon" 2>/dev/null || true; done
    wait
    rm -rf "$folder"
}
trap stop EXIT
trap 'exit 1' INT TERM

# The daemons, with all of their files in the folder.
chmod 755 "$folder"
mkdir "$folder/state" "$folder/spool"
install -d -o munge -g munge -m 755 "$folder/munge"
install -o munge -g munge -m 600 /dev/null "$folder/munge/key"
head -c 1024 /dev/urandom >"$folder/munge/key"
setpriv --reuid=munge --regid=munge --clear-groups munged --foreground --key-file="$folder/munge/key" \
    --socket="$folder/munge/socket" --pid-file="$folder/munge/pid" --log-file="$folder/munge/log" \
    --seed-file="$folder/munge/seed" >/dev/null 2>&1 &
daemons="$!"
host="$(hostname -s)"
cpus="$(nproc)"
export SLURM_CONF="$folder/slurm.conf"
cat >"$SLURM_CONF" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=2,bf_interval=2
KillWait=1
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$cpus State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
CONF
slurmctld -D >"$folder/slurmctld.log" 2>&1 &
daemons="$daemons $!"
slurmd -D -N "$host" >"$folder/slurmd.log" 2>&1 &
daemons="$daemons $!"

# Waits until a command succeeds, for at most a number of seconds.
await() {
    tries="$(($1 * 5))"
    shift
    until "$@" >/dev/null 2>&1; do
        tries=$((tries - 1))
        if [ "$tries" -lt 0 ]; then
            echo "waited in vain for: $*"
            tail -n 20 "$folder"/*.log
            exit 1
        fi
        sleep 0.2
    done
}
is_idle() {
    sinfo -h -o %T | grep -q idle
}
# Not every container lets daemons start.
(await 60 is_idle) || {
    echo "Slurm does not start here: the array job was not tested"
    exit 0
}

# 400 scenes of different colours; with 256 samples each, a task takes many seconds.
mkdir "$folder/in"
for number in $(seq 400); do
    scene="$folder/in/$number.toml"
    printf '[[surface]]\ncontrol_points = "default"\ncolor = [0.%03d, 0.5, 0.2]\n' "$number" >"$scene"
    echo "$scene"
done >"$folder/list"
mkdir "$folder/bin"
printf '#!/bin/sh\nexec "%s" "$@" --samples 256 --resolution 160x120\n' "$program" >"$folder/bin/freeform"
chmod +x "$folder/bin/freeform"
PATH="$folder/bin:$PATH"

job="$(sbatch --parsable --array=1-8 --output="$folder/task-%a.txt" \
    "$root/examples/cluster/slurm.sh" "$folder/list" "$folder/out")"
state() {
    squeue -h -r -j "${job}_$1" -o %T 2>/dev/null || true
}
# Task 2 is killed once it has made some of its pictures.
has_begun() {
    [ "$(wc -l <"$folder/out/log-2.jsonl")" -ge 5 ]
}
await 120 has_begun
scancel --signal=KILL --full "${job}_2"
is_over() {
    ! state 2 | grep -q RUNNING
}
await 60 is_over
made="$(wc -l <"$folder/out/log-2.jsonl")"
scontrol requeue "${job}_2"
# Requeued tasks wait for two minutes unless they are told otherwise.
is_pending() {
    state 2 | grep -q PENDING
}
await 60 is_pending
scontrol update "jobid=${job}_2" starttime=now 2>/dev/null || true
is_done() {
    ! squeue -h -j "$job" -o %T | grep -q .
}
await 300 is_done

freeform render --list "$folder/list" -o "$folder/whole" >/dev/null
rm "$folder"/out/log-*.jsonl
diff -r "$folder/whole" "$folder/out"
kept="$(grep -c '^kept ' "$folder/task-2.txt" || true)"
if [ "$kept" = 0 ]; then
    echo "the killed task did not go on where it was"
    exit 1
fi
echo "right: 8 tasks of Slurm made 400 pictures; the one that was killed had made $made, and kept $kept"
