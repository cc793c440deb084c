#!/usr/bin/env bash
# Collect demonstrations as a SLURM array, one shard a task, into a folder that all machines share; then merge them.
#
#   sbatch --array=1-16 docs/examples/slurm_collect.sh data/llakey_demos --task=all --num_episodes=1000
#   llakey merge --roots='data/llakey_demos.shards/*' --root=data/llakey_demos
#
# A task that ran out of time goes on where it was: submit the same command again.
#SBATCH --job-name=llakey-collect
#SBATCH --cpus-per-task=16
#SBATCH --mem=32G
#SBATCH --time=08:00:00
set -euo pipefail

if [[ $# -lt 2 ]]; then
  echo "Expected the folder of the dataset and options of llakey collect, got $# words; see the head of $0." >&2
  exit 1
fi
root=$1
shift

# Arrays may begin at 0 or at 1, and shards begin at 1.
shard=$((SLURM_ARRAY_TASK_ID - ${SLURM_ARRAY_TASK_MIN:-1} + 1))
export MUJOCO_GL=${MUJOCO_GL:-egl} OMP_NUM_THREADS=1

exec llakey collect --repo_id=local/llakey_demos --root="$root.shards/$shard" \
  --shard="$shard/$SLURM_ARRAY_TASK_COUNT" --num_workers="${SLURM_CPUS_PER_TASK:-0}" "$@"
