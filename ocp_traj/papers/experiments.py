"""Rows that several papers share: reference methods at equal evaluations, and better curves under the same limits."""

from __future__ import annotations

from collections.abc import Sequence

from ocp_traj.papers.paper import BETTER_CURVE, EQUAL_EVALUATIONS, Experiment


def equal_evaluations(methods: Sequence[tuple[str, str]], budget: int, reduced: bool) -> list[Experiment]:
    """Return one experiment a (label, solver), all with the same budget; IPOPT comes last.

    `reduced` keeps every fourth method and a fiftieth of the budget.
    """
    kept = methods[:: 4 if reduced else 1]
    spent = max(200, budget // 50) if reduced else budget
    gradient = "ipopt[iterations=2,rounds=1]" if reduced else "ipopt"
    return [
        *(Experiment(EQUAL_EVALUATIONS, label, solver, spent) for label, solver in kept),
        Experiment(EQUAL_EVALUATIONS, "IPOPT", gradient, once=True),
    ]


def better_curves(knots: Sequence[tuple[int, str]]) -> list[Experiment]:
    """Return IPOPT on cubic splines with (virtual knots a gap, ``"zero"`` or ``"free"`` end accelerations)."""
    return [
        Experiment(
            BETTER_CURVE,
            f"cubic spline, {count} virtual knots a gap, end accelerations {ends}",
            "ipopt",
            overrides=(
                'spline.family="cubic"',
                f"spline.virtual_knots={count}",
                f'boundary.acceleration="{ends}"',
            ),
            once=True,
        )
        for count, ends in knots
    ]
