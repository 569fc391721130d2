"""What is run for a paper: its own protocol, equal evaluations for every method, and better curves.

An evaluation judges all joints at once. Equal evaluations are as many as the paper's own protocol means to spend,
population times generations; where a paper optimises every joint alone, it spends that on each of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

PUBLISHED_PROTOCOL = "the paper's own protocol"
EQUAL_EVALUATIONS = "equal evaluations"
BETTER_CURVE = "the same limits with a better curve"

PER_JOINT = ('search.protocol="per-joint"',)

Methods = tuple[tuple[str, str], ...]
"""(label, solver as on the command line)."""

IMPROVED: Methods = (
    ("ISSA of A", "issa-a@paper"),
    ("ISSA of B", "issa-b@paper"),
    ("TADF-SSA", "tadf-ssa@paper-tadf-ssa"),
    ("PSO of D", "pso-d@paper-d"),
)
"""The papers' proposals with their printed settings; each also meets the cases of the other papers."""

GRADIENT: Methods = (("IPOPT", "ipopt"), ("Uno", "uno"), ("SLEQP", "sleqp"), ("Fatrop", "fatrop"))
"""They have no evaluations to share out and no seed: they run once."""

HYBRID: Methods = (
    ("PSO, then IPOPT", "pso+ipopt"),
    ("SSA, then IPOPT", "ssa+ipopt"),
    ("ISSA of A, then IPOPT", "issa+ipopt"),
    ("CMA-ES, then IPOPT", "cmaes+ipopt"),
    ("IPOPT from several starts", "ipopt-multistart"),
)
"""They run once too, with the same budget as the populations."""


@dataclass(frozen=True)
class Experiment:
    """One solver on the paper's case under one protocol, run with several seeds.

    Parameters
    ----------
    group : str
        The protocol, a heading of the page: ``"paper's protocol"`` or ``"equal evaluations"``.
    label : str
        Row of the table.
    solver : str
        As on the command line.
    budget : int or None
        Evaluations of x; None for gradient solvers.
    overrides : tuple of str
        Changes of the case, as ``--set`` takes them.
    published : str
        What the paper prints for it; empty where nothing.
    once : bool
        One seed is all that is run.
    """

    group: str
    label: str
    solver: str
    budget: int | None = None
    overrides: tuple[str, ...] = ()
    published: str = ""
    once: bool = False


@dataclass(frozen=True)
class Protocol:
    """What a paper ran, and what is run beside it.

    Parameters
    ----------
    methods : tuple of (label, solver)
        The paper's own.
    population, generations : int
        As printed, or a stand-in the paper names.
    joints : int
        How many joints are optimised one by one; 0 where they share their durations.
    published : mapping
        What the paper prints, by label.
    further : tuple of (label, solver)
        Other readings and methods to run at equal evaluations.
    curves : tuple of (int, str)
        Virtual knots a gap, and ``"zero"`` or ``"free"`` end accelerations, of cubic splines under the same limits.
    gradient : tuple of (label, solver)
        Solvers that use derivatives.
    """

    methods: Methods
    population: int
    generations: int
    joints: int = 0
    published: Mapping[str, str] = field(default_factory=dict)
    further: Methods = ()
    curves: tuple[tuple[int, str], ...] = ()
    gradient: Methods = GRADIENT

    @property
    def labels(self) -> list[str]:
        """The paper's own methods."""
        return [label for label, _ in self.methods]

    @property
    def budget(self) -> int:
        """Evaluations each method gets where all get the same."""
        return self.population * self.generations

    def experiments(self, reduced: bool) -> list[Experiment]:
        """Return every experiment of the page; `reduced` keeps few methods and tiny budgets, for tests."""
        return [*self._own(reduced), *self._equal(reduced), *self._curves(reduced)]

    def _own(self, reduced: bool) -> list[Experiment]:
        """Return the paper's methods with its population and generations."""
        generations = 3 if reduced else self.generations
        return [
            Experiment(
                PUBLISHED_PROTOCOL,
                label,
                solver,
                max(1, self.joints) * generations_budget(solver, generations),
                PER_JOINT if self.joints else (),
                self.published.get(label, ""),
            )
            for label, solver in self.methods
        ]

    def _equal(self, reduced: bool) -> list[Experiment]:
        """Return every method with the same evaluations."""
        methods = (*self.methods, *self.further, *_baselines(self.population))
        known = {label for label, _ in methods}
        methods += tuple(entry for entry in IMPROVED if entry[0] not in known)
        kept = methods[:: 4 if reduced else 1]
        spent = max(200, self.budget // 50) if reduced else self.budget
        quick: Methods = (("IPOPT", "ipopt[iterations=2,rounds=1]"),)
        gradient = quick if reduced else _usable(self.gradient)
        hybrid = () if reduced else _usable(HYBRID)
        return [
            *(Experiment(EQUAL_EVALUATIONS, label, solver, spent) for label, solver in kept),
            *(Experiment(EQUAL_EVALUATIONS, label, solver, once=True) for label, solver in gradient),
            *(Experiment(EQUAL_EVALUATIONS, label, solver, spent, once=True) for label, solver in hybrid),
        ]

    def _curves(self, reduced: bool) -> list[Experiment]:
        """Return IPOPT on cubic splines with virtual knots."""
        return [
            Experiment(
                BETTER_CURVE,
                curve_label(knots, ends),
                "ipopt",
                overrides=(
                    'spline.family="cubic"',
                    f"spline.virtual_knots={knots}",
                    f'boundary.acceleration="{ends}"',
                ),
                once=True,
            )
            for knots, ends in self.curves[: 1 if reduced else None]
        ]


def curve_label(knots: int, ends: str) -> str:
    """Return the row of a cubic spline."""
    return f"cubic spline, {knots} virtual knot{'s' * (knots != 1)} a gap, end accelerations {ends}"


def generations_budget(solver: str, generations: int) -> int:
    """Return the evaluations a population method spends in its first population and `generations` moves."""
    from ocp_traj.solvers import parse_solver
    from ocp_traj.solvers.population.population import Population

    parsed = parse_solver(solver)
    assert isinstance(parsed, Population)
    optimizer = parsed.optimizer()
    return optimizer.initial_evaluations + generations * optimizer.evaluations_per_generation


def _baselines(population: int) -> Methods:
    return (
        ("SSA, debiased", f"ssa-debiased[population={population}]"),
        ("PSO, constriction", "pso-constriction"),
        ("DE", "de"),
        ("CMA-ES", "cmaes"),
        ("random search", "random"),
    )


def _usable(methods: Methods) -> Methods:
    """Leave out solvers that cannot be loaded here."""
    from ocp_traj.solvers import solver_table

    usable = {entry.name for entry in solver_table() if entry.available}
    return tuple((label, solver) for label, solver in methods if solver in usable)
