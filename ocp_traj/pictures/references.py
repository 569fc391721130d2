"""All references of one task in one picture: the phase planes of its paths, and every duration on one axis."""

from __future__ import annotations

from collections.abc import Mapping

from ocp_traj.pictures.bounds import bounds_panel, reference_entries, result_entries
from ocp_traj.pictures.phase_plane import phase_plane_picture
from ocp_traj.pictures.picture import Panel, Picture
from ocp_traj.references import ReferenceSet
from ocp_traj.trajectory import Trajectory


def references_picture(
    found: ReferenceSet, motion: Trajectory | None = None, durations: Mapping[str, float] | None = None
) -> Picture:
    """Return the phase plane of every path that could be timed, and the bounds, references and results.

    Parameters
    ----------
    found
        From `collect_references`.
    motion
        The trajectory that was given to it.
    durations
        Further durations to show, by name, s.

    Raises
    ------
    InputError
        No bound and no timing was found.
    """
    entries = reference_entries(found) + result_entries(durations or {})
    panels: list[Panel] = [bounds_panel(entries, f"How far from the best: {found.task.name}", coloured=False)]
    convex = {result.path: result for result in found.convex}
    timed = [result for result in found.toppra if result.duration]
    caption = "Percentages are gaps to the proved bound."
    if timed:
        paths = [
            motion if result.path == "spline" and motion is not None else result.path for result in timed
        ]
        phase = phase_plane_picture(
            found.task, paths, [(result, convex.get(result.path)) for result in timed]
        )
        panels = [*phase.panels, *panels]
        caption = f"{phase.caption} {caption}"
    return Picture("references", f"References of {found.task.name}", caption, tuple(panels), columns=2)
