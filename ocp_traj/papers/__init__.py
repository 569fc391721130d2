"""Four published papers, run again and held to their word. A new one is a folder and one line here."""

from __future__ import annotations

from importlib import import_module

from ocp_traj.exceptions import UnknownNameError
from ocp_traj.papers.paper import Paper

PAPERS = {
    "A": "ocp_traj.papers.measurement_control_2023.experiment:MeasurementControl2023",
    "B": "ocp_traj.papers.ma_2024.experiment:Ma2024",
    "C": "ocp_traj.papers.zhang_2022.experiment:Zhang2022",
    "D": "ocp_traj.papers.zhu_wang.experiment:ZhuWang",
}


def get_paper(key: str) -> Paper:
    """Return a paper by its letter.

    Parameters
    ----------
    key : str
        ``"A"`` to ``"D"``.

    Raises
    ------
    UnknownNameError
        There is no such paper.
    """
    place = PAPERS.get(key.upper())
    if place is None:
        raise UnknownNameError(f"paper {key!r} is unknown, expected one of {', '.join(PAPERS)}")
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)()


__all__ = ["PAPERS", "Paper", "get_paper"]
