#!/usr/bin/env bash
# A chain of batch jobs, each stopped by the queue's warning, ends with the files
# of one uninterrupted run, byte for byte. A stand-in takes the place of Slurm.
#
#     tests/scripts/slurm.sh NANOWEFT_BINARY MPIEXEC
set -euo pipefail

binary=$(realpath "$1")
mpiexec=$(command -v "$2")
job=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../../scripts/slurm/job.sh")
root=$(dirname "$(dirname "$(dirname "$job")")")
# shellcheck source=scripts/environment
. "$root/scripts/environment"
folder=$(mktemp -d "${TMPDIR:-/tmp}/nanoweft-test-XXXXXX")
finish() {
    local status=$?
    # A job's shell passes the signal on, and ends after its solver.
    jobs -pr | xargs -r kill 2>/dev/null || true
    wait
    rm -rf "$folder"
    exit "$status"
}
trap finish EXIT
trap 'exit 1' INT TERM

fail() {
    echo "FAILED: $*" >&2
    tail -n 20 "$folder"/*/log* >&2
    exit 1
}

# The stand-ins. sbatch keeps its options and a copy of the script, as Slurm does.
# The launchers check how they are called, then start ranks that are tied to no core:
# RANKS of them, since two that wait for each other are slow on a busy machine.
mkdir "$folder/bin"
cat >"$folder/bin/sbatch" <<'END'
#!/usr/bin/env bash
set -euo pipefail
count=$(find . -maxdepth 1 -name 'queued-*' | wc -l)
entry=queued-$((count + 1))
mkdir "$entry"
while [[ $1 == --* ]]; do
    echo "$1" >>"$entry/options"
    shift
done
cp "$1" "$entry/slurm_script"
shift
printf '%s\n' "$@" >"$entry/arguments"
echo "Submitted batch job $((count + 1))"
END
cat >"$folder/bin/squeue" <<'END'
#!/usr/bin/env bash
echo 1:30:00
END
cat >"$folder/bin/mpirun" <<END
#!/usr/bin/env bash
[[ "\${*:1:6}" == "-n 2 --map-by slot:PE=1 --bind-to core" ]] || exit 64
shift 6
exec '$mpiexec' --quiet --oversubscribe --bind-to none -n "\${RANKS:-2}" "\$@"
END
cat >"$folder/bin/srun" <<END
#!/usr/bin/env bash
[[ "\${*:1:3}" == "--ntasks=2 --cpus-per-task=1 --cpu-bind=cores" ]] || exit 64
shift 3
exec '$mpiexec' --quiet --oversubscribe --bind-to none -n "\${RANKS:-2}" "\$@"
END
chmod +x "$folder"/bin/*
export PATH=$folder/bin:$PATH

# Unbound ranks would all tie their threads to the first core.
export OMP_PROC_BIND=false OMP_WAIT_POLICY=passive NANOWEFT_PROGRAM=$binary

cat >"$folder/run.opts" <<'END'
-weave_fibres 4,4
-weave_segments 24
-damping_local 0.4
-ts_max_steps 60000
-energy_monitor ascii:energy.csv
-monitor_interval 50
-progress_interval 0.02
END

submit() { sbatch --ntasks=2 --cpus-per-task=1 "$job" "$@" >submitted; }

option() { sed -n "s/^--$2=//p" "queued-$1/options"; }

# start NUMBER: runs a queued job as Slurm does; $batch is its shell.
start() {
    local arguments exports
    mapfile -t arguments <"queued-$1/arguments"
    exports=$(option "$1" export)
    env ${exports:+"${exports#ALL,}"} SLURM_JOB_ID="$1" SLURM_NTASKS="$(option "$1" ntasks)" \
        SLURM_CPUS_PER_TASK="$(option "$1" cpus-per-task)" SLURM_JOB_PARTITION=long \
        bash "queued-$1/slurm_script" "${arguments[@]}" >"log-$1" 2>&1 &
    batch=$!
}

running() { kill -0 "$batch" 2>/dev/null; }

# The solver takes signals from its first progress line on.
await_progress() {
    until grep -qs ns/day "log-$1" || ! running; do sleep 0.02; done
}

# serve SIGNAL NUMBER: runs all jobs in turn and signals the first NUMBER of them;
# $status is that of the last, $count how many there were.
serve() {
    count=0
    while [[ -d queued-$((count + 1)) ]]; do
        count=$((count + 1))
        ((count < 10)) || fail "a chain without end"
        RANKS=$((count <= $2 ? 2 : 1)) start "$count"
        if ((count <= $2)); then
            await_progress "$count"
            kill "-$1" "$batch" || fail "job $count ended before it was signalled"
        fi
        status=0
        wait "$batch" || status=$?
    done
}

# expect WHAT STATUS COUNT
expect() {
    [[ $status == "$2" && $count == "$3" ]] ||
        fail "$1: last status $status (expected $2), $count jobs (expected $3)"
    echo "ok: $1"
}

# first_step NUMBER: the step a job went on from, nothing if it started anew.
first_step() { sed -n 's/.*restart from checkpoint.h5 at step //p' "log-$1"; }

enter() { mkdir "$folder/$1" && cd "$folder/$1"; }

enter whole
RANKS=1 OMP_NUM_THREADS=1 mpirun -n 2 --map-by slot:PE=1 --bind-to core "$binary" \
    -options_file ../run.opts -state_output final.h5 >log 2>&1 || fail "the uninterrupted run"

enter chain
submit ../run.opts checkpoint.h5 -state_output final.h5
serve USR1 3
expect "three warnings, three resubmissions" 0 4
step=0
[[ ! $(first_step 1) ]] || fail "the first job did not start anew"
for number in 2 3 4; do
    before=$step
    step=$(first_step "$number")
    ((step > before)) || fail "job $number did not go on from the checkpoint"
    [[ $(option $number time) == 1:30:00 && $(option $number partition) == long ]] ||
        fail "job $number: time limit or partition lost"
    cmp queued-1/arguments queued-$number/arguments || fail "job $number: other arguments"
done
for file in final.h5 energy.csv; do
    cmp "$file" "../whole/$file" || fail "$file differs from the uninterrupted run"
done
echo "ok: the files are those of one run"

enter limit
export NANOWEFT_RESUBMISSIONS_MAX=1
submit ../run.opts checkpoint.h5 -ts_max_steps 3000000
serve USR1 9
expect "no more resubmissions than allowed" 3 2
unset NANOWEFT_RESUBMISSIONS_MAX

enter cancelled
cp ../limit/checkpoint.h5 . # of another run
submit ../run.opts checkpoint.h5
serve TERM 1
expect "a cancelled job writes its checkpoint and is not resubmitted" 3 1
[[ ! $(first_step 1) ]] || fail "a first job went on from an old checkpoint"
cmp -s checkpoint.h5 ../limit/checkpoint.h5 && fail "no checkpoint of the cancelled job"

enter requeued
cp ../cancelled/checkpoint.h5 . # of another run
submit ../run.opts checkpoint.h5
SLURM_RESTART_COUNT=1 serve TERM 1
[[ ! $(first_step 1) ]] || fail "a job that was put back went on from an old checkpoint"
rm log-1
sleep 1.1 # file times may be whole seconds
serve TERM 1
[[ ! $(first_step 1) ]] || fail "a first job went on from an old checkpoint"
rm log-1
SLURM_RESTART_COUNT=1 serve TERM 1
expect "a job that has been put back into the queue goes on" 3 1
[[ $(first_step 1) ]] || fail "a job that was put back began anew"

enter bad_input
submit ../run.opts checkpoint.h5 -ts_maximal_steps 10
NANOWEFT_LAUNCHER=srun serve USR1 0
expect "bad input is not resubmitted" 1 1

enter unstable
submit ../run.opts checkpoint.h5 -ts_dt 1000 -ts_dt_unsafe
serve USR1 0
expect "an unstable run is not resubmitted" 2 1

enter failed # each rank catches the signal before any of them reports progress
cat >program <<'END'
#!/usr/bin/env bash
trap 'exit 2' USR1
touch "ready-$OMPI_COMM_WORLD_RANK"
until [[ -e ready-0 && -e ready-1 ]]; do sleep 0.02; done
echo ns/day
for _ in {1..500}; do sleep 0.02; done
END
chmod +x program
submit ../run.opts checkpoint.h5
NANOWEFT_PROGRAM=./program serve USR1 1
expect "a run that fails after the warning is not resubmitted" 2 1
