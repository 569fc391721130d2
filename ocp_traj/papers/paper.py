"""What a reproduced paper is: its case, its experiments, and its claims held against the records."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from ocp_traj.papers.experiments import Experiment, Protocol

if TYPE_CHECKING:
    from ocp_traj.papers.records import Records
    from ocp_traj.task import TrajectoryTask


MEASURED_SEEDS = 20
"""Seeds of a page that ranks methods."""


@functools.cache
def _load(case: str, overrides: tuple[str, ...]) -> TrajectoryTask:
    """Read a packaged case once: a page asks for it hundreds of times, and nothing changes a task."""
    from ocp_traj.case import load_case

    return load_case(case, overrides)


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper, what was measured, and a verdict: holds, does not hold, cannot be checked."""

    sentence: str
    source: str
    measured: str
    verdict: str


@dataclass(frozen=True)
class Figure:
    """A regenerated figure: file name below the page, caption; or the reason why it cannot be made."""

    number: str
    caption: str
    file: str = ""
    impossible: str = ""


@dataclass(frozen=True)
class AuditedMotion:
    """A motion the paper reports, judged: words, duration and findings."""

    words: str
    duration: float
    feasible: bool
    ratio: float
    finding: str
    smallest_feasible_scale: float | None


@dataclass(frozen=True)
class Table:
    """A further table of a page: title, header and rows of text, and a sentence below it."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


class Paper(ABC):
    """One of the four papers; a subclass a paper.

    Attributes
    ----------
    key, title, reference : str
    summary : str
        What the paper does, in two or three sentences.
    case : str
        Name of the packaged case.
    protocol : Protocol
        What it ran, and what is run beside it.
    minimised : str
        ``"duration"`` or ``"energy"``: the column tables are about.
    runs : int
        Of how many runs the paper reports the best or the mean; our best is taken of the same number.
    stand_ins : tuple of str
        Numbers that were lost or never printed, and what stands in for them.
    """

    key: ClassVar[str]
    title: ClassVar[str]
    reference: ClassVar[str]
    summary: ClassVar[str]
    case: ClassVar[str]
    protocol: ClassVar[Protocol]
    minimised: ClassVar[str] = "duration"
    runs: ClassVar[int] = 20
    stand_ins: ClassVar[tuple[str, ...]]

    def task(self, overrides: tuple[str, ...] = ()) -> TrajectoryTask:
        """Return the paper's task."""
        return _load(self.case, overrides)

    def experiments(self, reduced: bool) -> list[Experiment]:
        """Return the experiments; `reduced` shrinks budgets for tests and says so on the page."""
        return self.protocol.experiments(reduced)

    @abstractmethod
    def story(self, records: Records) -> list[str]:
        """Return what came out, in a few sentences."""

    @abstractmethod
    def claims(self, records: Records) -> list[Claim]:
        """Return every claim with what the records say."""

    @abstractmethod
    def figures(self, records: Records, folder: Path) -> list[Figure]:
        """Draw the figures into `folder`."""

    def audited(self, records: Records) -> list[AuditedMotion]:
        """Return the judged motions the paper reports (none unless it prints durations)."""
        return []

    def tables(self, records: Records) -> list[Table]:
        """Return further tables."""
        return []
