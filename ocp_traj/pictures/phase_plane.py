"""Pictures of how a path is driven: path speed over path length, its limits, and which of them is active."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.pictures.picture import LIMIT, Line, Panel, Picture
from ocp_traj.references import ReferenceResult, convex_reference, limit_curves, toppra_reference
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

_CURVES = {"velocity": 5, "acceleration": 6, "torque": 7}
"""Colours of the maximum velocity curves."""

_ACTIVE_COLOURS = (0, 1, 2, 3, 4, 9)
_OTHER = "other limits active"
_ROOM = 1.3
"""Height of the picture over the highest profile: limits far above it are not shown."""


def phase_plane_picture(
    task: TrajectoryTask,
    paths: Sequence[str | Trajectory] = ("uniform", "chord"),
    timings: Sequence[tuple[ReferenceResult, ReferenceResult | None]] = (),
) -> Picture:
    """Return one panel a path: path speed over arc length, the speed limits, and both optimal profiles.

    Parameters
    ----------
    task
        Whose limits hold.
    paths
        ``"uniform"``, ``"chord"`` or motions; of a motion its own speed is drawn too.
    timings
        TOPP-RA and convex timing of each path where they are known already; solved here otherwise.

    Raises
    ------
    InputError
        A path does not fit the task, or nothing moves along it.
    """
    if not timings:
        timings = [(toppra_reference(task, path), convex_reference(task, path)) for path in paths]
    colours = _active_colours([convex for _, convex in timings if convex is not None])
    panels = tuple(_panel(task, path, *pair, colours) for path, pair in zip(paths, timings, strict=True))
    caption = (
        "Above a dashed curve no motion along this path keeps the limits of that kind. The colour of the convex "
        "profile is the limit whose multiplier says that loosening it gains most there; TOPP-RA is dashed over it."
    )
    return Picture("phase-plane", "Phase plane", caption, panels, columns=2)


def _active_colours(results: Sequence[ReferenceResult]) -> dict[str, int]:
    """Return a colour for each of the limits that are active most often."""
    counted = Counter(name for result in results for name in result.active if name)
    return {name: colour for (name, _), colour in zip(counted.most_common(), _ACTIVE_COLOURS)}


def _panel(
    task: TrajectoryTask,
    path: str | Trajectory,
    fastest: ReferenceResult,
    convex: ReferenceResult | None,
    colours: dict[str, int],
) -> Panel:
    name = path if isinstance(path, str) else "spline"
    if fastest.duration is None:
        raise InputError(f"the {name} path has no timing to draw: {fastest.reason}")
    curves = limit_curves(task, path)
    own = _own_profile(path) if isinstance(path, Trajectory) else None
    top = _ROOM * max(float(profile.max()) for profile in (fastest.speed, own[1] if own else fastest.speed))
    if top == 0:
        raise InputError(f"nothing moves along the {name} path, so it has no phase plane")
    lines = [
        Line(np.full(2, place), np.array([0.0, top]), "waypoints", LIMIT, dashed=True)
        for place in curves.waypoints[1:-1]
    ]
    limits = {"velocity": curves.velocity, **curves.by_kind}
    for kind, colour in _CURVES.items():
        if kind in limits:
            lines += _runs(curves.s, limits[kind], limits[kind] <= top, f"{kind} limits", colour, dashed=True)
    if convex is not None and convex.duration is not None:
        lines += _coloured(convex, colours)
    lines.append(Line(fastest.s, fastest.speed, "TOPP-RA", 8, dashed=True))
    title = f"Path {name}: {fastest.duration:.4f} s"
    if own is not None and isinstance(path, Trajectory):
        lines.append(Line(*own, "the motion itself", 8))
        title += f" (the motion takes {path.duration:.4f} s)"
    return Panel(
        title, "share of the path's length s", "path speed ds/dt (1/s)", tuple(lines), y_range=(0.0, top)
    )


def _coloured(result: ReferenceResult, colours: dict[str, int]) -> list[Line]:
    """Return the profile as runs of cells with the same active limit."""
    words = [
        f"{name} active" if name in colours else (_OTHER if name else "no limit active")
        for name in result.active
    ]
    lines = []
    first = 0
    for last in range(1, len(words) + 1):
        if last == len(words) or words[last] != words[first]:
            cells = slice(first, last + 1)
            colour = colours.get(result.active[first], LIMIT)
            lines.append(Line(result.s[cells], result.speed[cells], words[first], colour, wide=True))
            first = last
    return lines


def _runs(x: Array, y: Array, shown: Array, label: str, colour: int, dashed: bool) -> list[Line]:
    """Return the shown parts of a curve as lines of their own."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(shown, dtype=int), [0]])))
    return [
        Line(x[first:last], y[first:last], label, colour, dashed)
        for first, last in zip(edges[::2], edges[1::2])
        if last - first > 1
    ]


def _own_profile(motion: Trajectory) -> tuple[Array, Array]:
    """Return arc length (scaled to 1) and path speed of a motion, 1/s."""
    t = np.linspace(motion.breakpoints[0], motion.breakpoints[-1], 4001)
    speed = np.linalg.norm(motion(t, 1), axis=1)
    length = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t)))
    return length[::8] / length[-1], speed[::8] / length[-1]
