#!/bin/bash
# The report as an array job, here for Slurm; of other schedulers only the name of the index differs.
#
#   sbatch --array=1-4 verify/examples/job-array.sh
#   target/debug/verify report --merge target/parts --out target/report      # when all have ended
#
# Every task runs its part of the studies with the binary that is there: build it once, before. It was not run on a cluster.
#SBATCH --job-name=lsvi-report
#SBATCH --cpus-per-task=4
set -euo pipefail
index=${SLURM_ARRAY_TASK_ID:?the index of this task}
count=${SLURM_ARRAY_TASK_COUNT:?the number of tasks}
exec target/debug/verify report --shard "$index/$count" --out target/parts
