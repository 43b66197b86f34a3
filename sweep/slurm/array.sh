#!/bin/sh
# A whole table as a job array without MPI. Sent to the queue, with a job after it that merges, by:
#     array=$(sbatch --parsable sweep/slurm/array.sh scenes.toml)
#     sbatch --dependency=afterany:"$array" --wrap "gradient-mc-sweep scenes.toml --merge"
#SBATCH --array=0-99
#SBATCH --time=24:00:00
# SIGUSR1 to the program ten minutes before the end: it writes its checkpoint and stops.
#SBATCH --signal=USR1@600
#SBATCH --requeue
#SBATCH --open-mode=append

srun gradient-mc-sweep "$1" --share "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
code=$?

# 75: stopped by the signal. The same task of the array goes on where it was.
if [ "$code" -eq 75 ]; then
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
