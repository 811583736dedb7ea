#!/bin/bash
# A job array of SLURM in which every job is a worker of one sweep: sbatch docs/sweep-array.sh results/plan
# Write the list first: gpsec sweep plan.toml --list. Add --partition and --account as your site asks.
#SBATCH --job-name=gpsec-sweep
#SBATCH --array=1-20
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --time=04:00:00
#SBATCH --signal=INT@60
set -euo pipefail
exec gpsec sweep --worker "$1" --jobs "${SLURM_CPUS_PER_TASK:-1}"
