"""Runs a sweep on a cluster with SLURM: python docs/sweep_slurm.py plan.toml results/plan.

Needs `pip install 'gpsec[sweep]'` in an environment that all nodes see, and a folder on a disk that they share.
"""

import sys

from dask_jobqueue import SLURMCluster
from distributed import Client

import gpsec

# One worker with one core a run; SUMO is a process below it, which Dask's limit would not see, so that SLURM's holds.
JOB = {
    "cores": 8,
    "processes": 8,
    "memory": "16GB",
    "walltime": "04:00:00",
    "worker_extra_args": ["--memory-limit", "0"],
    "job_extra_directives": [],  # such as "--partition=short", "--account=lab"
}


def main() -> None:
    """Start workers, run what is missing, and say what became of it."""
    plan, folder = sys.argv[1:3]
    with SLURMCluster(**JOB) as cluster, Client(cluster) as client:
        cluster.adapt(maximum_jobs=20)
        sweep = gpsec.sweep(plan, folder, client=client)
    print(sweep.tasks.groupby("state").size())


if __name__ == "__main__":
    main()
