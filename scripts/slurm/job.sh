#!/usr/bin/env bash
#SBATCH --job-name=nanoweft
#SBATCH --output=%x-%j.out
#SBATCH --ntasks=4
#SBATCH --cpus-per-task=4
#SBATCH --threads-per-core=1
#SBATCH --time=24:00:00
#SBATCH --signal=B:USR1@300
# One job of a chain: runs nanoweft until it is done or the queue warns that
# time is nearly up, and submits the next job of the chain. See README.md here.
#
#     sbatch --ntasks=R --cpus-per-task=T scripts/slurm/job.sh RUN.opts CHECKPOINT.h5 [options]
set -euo pipefail

say() { echo "job: $*" >&2; }

if (($# < 2)); then
    say "usage: sbatch --ntasks=R --cpus-per-task=T scripts/slurm/job.sh RUN.opts CHECKPOINT.h5 [options]"
    exit 1
fi
arguments=("$@")
run=$1
checkpoint=$2
shift 2
options=("$@")

# The queue runs a copy of this script from a folder of its own, so paths count
# from the folder of submission.
program=${NANOWEFT_PROGRAM:-build/bin/nanoweft}
launcher=${NANOWEFT_LAUNCHER:-mpirun}
submission=${NANOWEFT_RESUBMISSION:-0}
most=${NANOWEFT_RESUBMISSIONS_MAX:-50}

ranks=${SLURM_NTASKS:?start this script with sbatch}
threads=${SLURM_CPUS_PER_TASK:-1}
export OMP_NUM_THREADS=$threads
export OMP_PLACES=${OMP_PLACES:-cores}
export OMP_PROC_BIND=${OMP_PROC_BIND:-close}

case $launcher in
mpirun) launch=(mpirun -n "$ranks" --map-by "slot:PE=$threads" --bind-to core) ;;
srun) launch=(srun --ntasks="$ranks" --cpus-per-task="$threads" --cpu-bind=cores) ;;
*)
    say "NANOWEFT_LAUNCHER is '$launcher', but has to be mpirun or srun"
    exit 1
    ;;
esac

restart=()
# A job that Slurm has put back into the queue goes on, too, from what it has written itself.
begun=$checkpoint.job-${SLURM_JOB_ID:-0}
if ((submission > 0)); then
    [[ ! -e $checkpoint ]] || restart=(-restart "$checkpoint")
elif ((${SLURM_RESTART_COUNT:-0} == 0)); then
    touch "$begun"
elif [[ -e $begun && $checkpoint -nt $begun ]]; then
    restart=(-restart "$checkpoint")
fi

# USR1, the queue's warning, asks for a checkpoint and the next job; TERM, as of
# scancel, for a checkpoint alone. Both launchers pass USR1 on to the ranks, but
# mpirun answers TERM by killing them.
solver='' signals=0 warned='' cancelled=''
# shellcheck disable=SC2317 # called by traps
pass_on() {
    signals=$((signals + 1))
    [[ -z $solver ]] || kill -USR1 "$solver" 2>/dev/null || true
}
trap 'warned=yes; pass_on' USR1
trap 'cancelled=yes; pass_on' TERM

# A trapped signal ends the wait, not the solver.
simulate() {
    "${launch[@]}" "$program" -options_file "$run" "${options[@]}" \
        -checkpoint_file "$checkpoint" "${restart[@]}" </dev/null &
    solver=$!
    local seen status
    while :; do
        seen=$signals status=0
        wait "$solver" || status=$?
        ((signals > seen)) || return "$status"
    done
}

# What was asked for on the command line of sbatch is not in the script.
resubmit() {
    local request=(--ntasks="$ranks" --cpus-per-task="$threads") limit
    limit=$(squeue --noheader --jobs="$SLURM_JOB_ID" --format=%l) || limit=
    request+=(
        ${SLURM_JOB_NAME:+--job-name="$SLURM_JOB_NAME"}
        ${limit:+--time="$limit"}
        ${SLURM_JOB_NUM_NODES:+--nodes="$SLURM_JOB_NUM_NODES"}
        ${SLURM_NTASKS_PER_NODE:+--ntasks-per-node="$SLURM_NTASKS_PER_NODE"}
        ${SLURM_JOB_PARTITION:+--partition="$SLURM_JOB_PARTITION"}
        ${SLURM_JOB_ACCOUNT:+--account="$SLURM_JOB_ACCOUNT"}
        ${SLURM_JOB_QOS:+--qos="$SLURM_JOB_QOS"}
        ${SLURM_MEM_PER_CPU:+--mem-per-cpu="$SLURM_MEM_PER_CPU"}
        ${SLURM_MEM_PER_NODE:+--mem="$SLURM_MEM_PER_NODE"}
        --export="ALL,NANOWEFT_RESUBMISSION=$((submission + 1))"
    )
    sbatch "${request[@]}" "$0" "${arguments[@]}"
}

say "$ranks rank(s) x $threads thread(s), resubmission $submission of at most $most"
status=0
simulate || status=$?
((status == 3)) || rm -f "$begun"

if ((status != 3)); then
    say "ended with status $status"
elif [[ $cancelled || ! $warned ]]; then
    say "stopped with a checkpoint, not by the queue's warning: not resubmitted"
elif ((submission >= most)); then
    say "stopped with a checkpoint; $most resubmissions are used up (NANOWEFT_RESUBMISSIONS_MAX)"
else
    resubmit || say "stopped with a checkpoint, but could not be resubmitted"
fi
exit "$status"
