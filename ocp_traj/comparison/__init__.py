"""Comparing solvers: plan, execution, store, judging, statistics, report and pictures.

Nothing heavy is imported here; import the module you need, for instance ``ocp_traj.comparison.runs.compare``.
"""
