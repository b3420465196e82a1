#!/bin/bash
#SBATCH --job-name=sweep
#SBATCH --array=0-3
#SBATCH --cpus-per-task=1
#SBATCH --output=sweep-%a.log
#SBATCH --requeue
# Which part of the sweep a task does is read from SLURM_ARRAY_TASK_ID and SLURM_ARRAY_TASK_COUNT.
exec host-sim sweep "$1" --threads "$SLURM_CPUS_PER_TASK"
