"""
Scaling out with Dask
=====================

A comparison runs on this machine's cores, or on the workers of a Dask cluster; here two local workers, elsewhere
an address. Seeds come from the plan, so results depend neither on the order nor on the number of workers, and
what is finished is never run again.
"""

import tempfile
from pathlib import Path

from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan

try:
    from distributed import LocalCluster
except ImportError:
    print("this example needs Dask: pip install 'ocp-traj[cluster]'")
else:
    plan = Plan(
        cases=(CaseChoice("machines-2024-490", ("spline.family=cubic", "spline.virtual_knots=0")),),
        solvers=("ipopt", "pso"),
        seeds=2,
        budgets=(500,),
        references=False,
    )
    with (
        tempfile.TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
    ):
        finished = []

        def tell(progress):
            """Print one line a finished run."""
            if progress.record is not None:
                finished.append(progress.record)
                print(progress.finished, "of", progress.total, progress.spec.solver, progress.record.status)

        compare(plan, Path(folder), dask=cluster.scheduler_address, progress=tell)
        compare(plan, Path(folder), dask=cluster.scheduler_address)  # nothing is left to do
    print(len(finished), "runs, should be", plan.size, "and none of them twice")
    assert len(finished) == plan.size and all(record.status != "failed" for record in finished)
