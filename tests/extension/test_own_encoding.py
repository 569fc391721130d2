"""Encodings of a user's own: what variables mean, and where virtual knots are measured from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ocp_traj as ot
from metaheuristics import ParticleSwarm, minimize
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.runner import solve_case
from ocp_traj.comparison.runs.store import Store
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.solvers import Request, parse_solver
from ocp_traj.task import Search
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.condensed.encodings import ENCODINGS, Encoding
from ocp_traj.transcription.condensed.encodings.durations import Durations

POINTS = np.array([[0.0, 0.5], [1.0, 0.2], [0.4, 0.9]])
TASK = ot.TrajectoryTask(
    POINTS, ot.Limits(velocity=1.0, acceleration=2.0), virtual_knots=2, search=Search(offset=0.7)
)
SOLVER = "cmaes[encoding=speeds]"


class Speeds(Durations):
    """x holds the inverse of the durations, and offsets are measured from where the gap starts."""

    name = "speeds"

    def from_durations(self, durations: np.ndarray) -> np.ndarray:
        """Return minus the inverses, which grow with the durations."""
        return -1.0 / durations

    def to_durations(self, x: np.ndarray) -> np.ndarray:
        """Return the inverses."""
        return -1.0 / x

    def symbolic_durations(self, x: Any) -> Any:
        """Return the inverses."""
        return -1.0 / x

    def anchors(self, durations: np.ndarray) -> np.ndarray:
        """Return the last waypoint at every knot."""
        return self.starts[:, :, None]

    def symbolic_anchors(self, durations: Any) -> list[Any]:
        """Return the same."""
        return [row[None, :] for row in self.starts]

    @property
    def starts(self) -> np.ndarray:
        """The waypoint every knot comes after, or is, (S + 1, n)."""
        knots = np.arange(self.segments + 1)
        return np.asarray(self.task.waypoints)[knots // (self.task.virtual_knots + 1)]


def run(request: Mapping[str, Any]) -> dict[str, Any]:
    """Execute one run of a comparison where the encoding is known."""
    ENCODINGS["speeds"] = Speeds
    return solve_case(request)


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Add the encoding's one line."""
    monkeypatch.setitem(ENCODINGS, "speeds", Speeds)


def test_the_same_motion_costs_the_same_in_any_encoding() -> None:
    own, plain = (CondensedNlp(TASK, encoding=encoding) for encoding in (Speeds, "durations"))
    x = np.random.default_rng(1).uniform(plain.lower, plain.upper)
    motion = plain.decode(x)
    other = own.decode(own.encode(motion))
    np.testing.assert_allclose(other.breakpoints, motion.breakpoints, rtol=1e-12)
    np.testing.assert_allclose(other.coefficients, motion.coefficients, rtol=1e-9, atol=1e-9)
    for mine, theirs in zip(own.evaluate(own.encode(motion)).scores, plain.evaluate(x).scores):
        np.testing.assert_allclose(mine, theirs, rtol=1e-9)
    assert own.lower[0] < own.encode(motion)[0] < own.upper[0]


def test_its_symbols_say_what_its_evaluation_says() -> None:
    import casadi as ca

    nlp = ot.transcribe(TASK, encoding=Speeds, samples=8)
    x = np.random.default_rng(2).uniform(nlp.lower, nlp.upper)
    cost, rows = ca.Function("nlp", [nlp.x], [nlp.f, nlp.g])(x)
    judged = nlp.evaluate(x)
    assert float(cost) == pytest.approx(judged.cost[0], rel=1e-12)
    np.testing.assert_allclose(nlp.violations(np.array(rows).ravel()), judged.violation[0], atol=1e-9)


def test_a_population_solves_with_it_and_the_audit_agrees(known: None) -> None:
    result = ot.solve(TASK, SOLVER, seed=1, budget=6000)
    assert result.encoding == "speeds" and result.feasible
    best = ot.solve(TASK, "ipopt").duration
    assert best is not None and best <= result.duration < 1.1 * best  # type: ignore[operator]
    nlp = CondensedNlp(TASK, encoding=Speeds)
    found = minimize(nlp, ParticleSwarm(population=30), budget=600, rng=np.random.default_rng(0))
    assert ot.audit(TASK, nlp.decode(found.x)).waypoint_error < 1e-9


def test_it_is_compared(tmp_path: Path, known: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    case = CaseChoice("machines-2024-490")
    plan = Plan(
        (case,), (SOLVER, "pso"), seeds=1, budgets=(300,), references=False, runner="test_own_encoding:run"
    )
    compare(plan, tmp_path)
    with Store(tmp_path) as store:
        rows = {row.solver: row.record for row in store.rows()}
    assert set(rows) == {SOLVER, "pso"}
    assert [record.evaluations for record in rows.values()] == [300, 300]
    assert all(record.status != "failed" and record.duration for record in rows.values())


class Fixed(Durations):
    """Like durations, but it says that it decides the speed, and it has no symbols."""

    name = "fixed"
    decides_speed = True

    def symbolic_durations(self, x: Any) -> Any:
        """Refuse."""
        return Encoding.symbolic_durations(self, x)


def test_an_encoding_without_symbols_says_so() -> None:
    with pytest.raises(UnavailableError, match="the fixed encoding has no symbols"):
        _ = CondensedNlp(TASK, encoding=Fixed).g


def test_an_encoding_says_itself_that_it_decides_the_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pymoo")
    monkeypatch.setitem(ENCODINGS, "fixed", Fixed)
    with pytest.raises(InputError, match="NSGA-II decides the speed itself"):
        parse_solver("pymoo-nsga2[encoding=fixed]").run(
            ot.load_case("ur5-torque-limited"), Request(budget=50)
        )


def test_distances_are_the_encoding_s_own() -> None:
    scaled, plain = (CondensedNlp(TASK, encoding=name).encoding for name in ("scaled", "log-durations"))
    x = plain.lower.copy()
    longer = x + np.r_[np.full(TASK.gaps, 0.5), np.zeros(len(x) - TASK.gaps)]
    assert scaled.distance(x, longer) < 1e-12 < plain.distance(x, longer)
