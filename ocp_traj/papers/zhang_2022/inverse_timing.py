"""The time that unique domains save in inverse kinematics, as Fig. 6 of Zhang et al. 2022 (paper C) measures it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.comparison.report.document import Table
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.paper import Claim, table_of
from ocp_traj.papers.records import Records

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

SAVING = 0.3976
"""Printed, the share of 2.6149 ms saved by 1.5752 ms."""

PATH_POINTS = (9, 90, 900)
REPEATS = 10
"""As in Fig. 6."""

CONSTANT = 0.05
"""Proportions that differ by less are called the same."""


def inverse_timing(task: TrajectoryTask, records: Records) -> list[dict[str, Any]]:
    """Return the times of both inverse solutions by form and number of points, measured once."""
    found = records.computed("inverse kinematics", lambda: {"rows": _time_paths(task)})
    return [
        {
            **row,
            "best_eight": min(row["eight"]),
            "best_one": min(row["one"]),
            "saving": 1 - min(row["one"]) / min(row["eight"]),
        }
        for row in found["rows"]
    ]


def timing_table(timing: list[dict[str, Any]]) -> Table:
    """Return the table of both solutions' times."""
    rows = [
        (
            row["form"],
            f"{row['points']}",
            *(
                f"{1e3 * row[f'best_{way}']:.3f} ({1e3 * quartiles(np.array(row[way]))[1]:.3f})"
                for way in ("eight", "one")
            ),
            f"{100 * row['saving']:.1f} %",
        )
        for row in timing
    ]
    return table_of(
        "Eight branches against one",
        ("form", "points", "eight branches and filter, ms", "one domain, ms", "saved"),
        (("paper, MATLAB", "lost", "2.6149", "1.5752", f"{100 * SAVING:.2f} %"), *rows),
        f"Least (median) of {REPEATS} repetitions, processor time; the share saved is that of the least, which other "
        f"work on the machine disturbs least. The paper prints means of {REPEATS}.",
    )


def timing_claims(rows: list[dict[str, Any]]) -> list[Claim]:
    """Judge the saved share, and how it grows with the number of points."""
    plain = [row for row in rows if row["form"] == "python"]
    growth = plain[-1]["saving"] - plain[0]["saving"]
    saved = [(row["points"], row["best_eight"] - row["best_one"]) for row in plain]
    absolute = ", ".join(f"{points} points {1e3 * value:.2f} ms" for points, value in saved)
    linear = saved[-1][1] / saved[0][1] / (saved[-1][0] / saved[0][0])
    shares = "; ".join(f"{row['form']}, {row['points']} points: {100 * row['saving']:.1f} %" for row in rows)
    return [
        Claim(
            "unique domains save 39.76 % of the inverse kinematics' time",
            "Fig. 6",
            shares,
            "holds: at least that" if all(row["saving"] >= SAVING for row in rows) else "depends on the form",
        ),
        Claim(
            "the saved proportion increases linearly with the number of points",
            "section 5",
            f"proportions: {shares}; times saved by plain Python: {absolute}",
            ("does not hold" if abs(growth) < CONSTANT else "depends on the form")
            + f": in plain Python the proportion changes by {100 * growth:+.1f} points of a percent from "
            f"{plain[0]['points']} to {plain[-1]['points']} points; the time saved grows at {linear:.2f} of the "
            "linear rate",
        ),
    ]


def _time_paths(task: Any) -> list[dict[str, Any]]:
    """Time both inverse solutions along the helix with more and more points."""
    from ocp_traj.robot.inverse_kinematics.domain_timing import measure_domain_timing
    from ocp_traj.transcription import initial_guess

    motion = initial_guess(task)
    rows = []
    for points in PATH_POINTS:
        positions = motion(np.linspace(0.0, motion.duration, points))
        poses = np.stack([task.robot.pose(q) for q in positions])
        for form in ("python", "vectorised"):
            timing = measure_domain_timing(
                task.robot, poses, positions[0], [6.0, 5.0, 4.0, 3.0, 2.0, 1.0], form
            )
            rows.append(
                {
                    "form": form,
                    "points": points,
                    "eight": timing.eight_branches.tolist(),
                    "one": timing.one_domain.tolist(),
                }
            )
    return rows
