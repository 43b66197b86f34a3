#!/bin/sh
# A whole table in one job over MPI. Sent to the queue by: sbatch sweep/slurm/mpi.sh scenes.toml
#SBATCH --ntasks=256
#SBATCH --time=24:00:00
# SIGUSR1 to every rank ten minutes before the end: they write their checkpoints and stop.
#SBATCH --signal=USR1@600
#SBATCH --requeue
#SBATCH --open-mode=append

# A rank that dies does not end the others. --mpi as the cluster's MPI library wants it: `srun --mpi=list`.
srun --mpi=pmix --no-kill --kill-on-bad-exit=0 gradient-mc-sweep "$1"
code=$?

# 75: stopped by the signal. The same job goes on where it was.
if [ "$code" -eq 75 ]; then
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$code"
