"""``python -m ocp_traj``: the command line."""

from ocp_traj.cli.main import main

main()
