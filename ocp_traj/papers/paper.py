"""What a reproduced paper is: its case, its experiments, and its claims held against the records."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from ocp_traj.comparison.report.document import Table, text
from ocp_traj.papers.experiments import Experiment, Protocol
from ocp_traj.papers.records import Records
from ocp_traj.pictures.picture import Picture

if TYPE_CHECKING:
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
class AuditedMotion:
    """A motion the paper reports, judged: words, duration and findings."""

    words: str
    duration: float
    feasible: bool
    ratio: float
    finding: str
    smallest_feasible_scale: float | None


def table_of(
    caption: str, columns: Sequence[str], rows: Sequence[Sequence[str]], note: str = ""
) -> Table:
    """Return a table of texts; on a page its caption is the heading of its section."""
    cells = tuple(tuple(text(cell) for cell in row) for row in rows)
    return Table(caption, tuple(columns), cells, note)


class Paper(ABC):
    """One of the four papers; one subclass per paper.

    Attributes
    ----------
    key, name, title, reference : str
        Letter, author and year, and what else a reader finds the paper by.
    summary : str
        What the paper does, in two or three sentences.
    case : str
        Name of the packaged case.
    protocol : Protocol
        What it ran, and what is run beside it.
    minimised : str
        ``"duration"`` or ``"energy"``: the column tables are about.
    best_of : int
        Of how many runs the paper reports the best or the mean; our best is taken of the same number.
    stand_ins : tuple of str
        Numbers that were lost or never printed, and what stands in for them.
    """

    key: ClassVar[str]
    name: ClassVar[str]
    title: ClassVar[str]
    reference: ClassVar[str]
    summary: ClassVar[str]
    case: ClassVar[str]
    protocol: ClassVar[Protocol]
    minimised: ClassVar[str] = "duration"
    best_of: ClassVar[int] = 20
    stand_ins: ClassVar[tuple[str, ...]]

    @property
    def stem(self) -> str:
        """Name of the page's file and beginning of its pictures' names, for instance ``ma-2024``."""
        return "-".join(word for word in self.name.lower().split() if word not in ("et", "al.", "and"))

    @property
    def heading(self) -> str:
        """Author, year, letter and title."""
        return f"{self.name} (paper {self.key}): {self.title}"

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
    def figures(self, records: Records) -> list[Picture | str]:
        """Return the pictures that redo the paper's figures, and a sentence for each figure that cannot be redone."""

    def audited(self, records: Records) -> list[AuditedMotion]:
        """Return the judged motions the paper reports (none unless it prints durations)."""
        return []

    def tables(self, records: Records) -> list[Table]:
        """Return further tables."""
        return []
