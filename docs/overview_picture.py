"""Draw the README's picture, ``docs/images/overview.svg``: run it again when numbers change."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

import ocp_traj as ot
from ocp_traj.references import kinematic_bound, toppra_reference

CASE = "machines-2024-490"


def main() -> None:
    """Solve one published problem in several ways and draw durations and accelerations."""
    published = ot.load_case(CASE)
    rows = [
        (
            "the published curve, 3-5-3, at its best",
            ot.solve(published, "pso[encoding=scaled]", budget=20_000).duration,
        )
    ]
    timings = [toppra_reference(published, path).duration for path in ("uniform", "chord")]
    tasks = {
        knots: ot.load_case(CASE, ["spline.family=cubic", f"spline.virtual_knots={knots}"])
        for knots in (0, 1, 3, 7)
    }
    results = {knots: ot.solve(task) for knots, task in tasks.items()}
    rows.append(("cubic spline, no virtual knots", results[0].duration))
    rows.append(("TOPP-RA, better of two paths", min(timings)))
    rows += [(f"cubic spline, virtual knots: {knots} a gap", results[knots].duration) for knots in (1, 3, 7)]
    bound = kinematic_bound(tasks[7], time_limit=1.0).estimate

    figure, (bars, lines) = plt.subplots(2, 1, figsize=(7, 5.6), layout="constrained")
    names, values = zip(*rows)
    colours = ["#9aa5b1", "#7aa6c2", "#c2a37a", "#4f8fb8", "#2f7bab", "#0b5d91"]
    bars.barh(names, values, color=colours)
    bars.invert_yaxis()
    bars.axvline(bound, color="black", linewidth=1)
    bars.text(bound + 0.05, -0.75, f"kinematic bound, estimate: {bound:.4f} s", fontsize=10)
    for place, value in enumerate(values):
        bars.text(value + 0.04, place, f"{value:.3f} s", va="center", fontsize=10)
    bars.set(xlabel="duration of the motion, s", xlim=(0, 5))

    best = results[7]
    t = np.linspace(0.0, best.duration, 2000)
    limit = np.asarray(published.limits.get("acceleration"))[0, 1]
    for joint in range(1, published.n):
        lines.plot(t, best.trajectory(t, derivative=2)[:, joint] / limit[joint], label=f"joint {joint + 1}")
    lines.set(xlabel="time, s", ylabel="acceleration / limit", ylim=(-1.15, 1.15))
    lines.legend(
        ncol=5, loc="lower center", bbox_to_anchor=(0.5, 1.0), frameon=False, columnspacing=1, handlelength=1
    )
    for axis in (bars, lines):
        axis.spines[["top", "right"]].set_visible(False)
    assert all(result.feasible for result in results.values())
    figure.savefig(Path(__file__).parent / "images" / "overview.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
