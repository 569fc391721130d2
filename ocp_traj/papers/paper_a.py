"""Paper A: energy-optimal welding trajectory of a UR5, degree-7 B-spline, improved sparrow search."""

from __future__ import annotations

from pathlib import Path

from ocp_traj.papers.experiments import equal_evaluations
from ocp_traj.papers.measures import claim_order, median_of, number, order_with_tests, spread_of, with_unit
from ocp_traj.papers.paper import (
    EQUAL_EVALUATIONS,
    PUBLISHED_PROTOCOL,
    Claim,
    Experiment,
    Figure,
    Paper,
    generations_budget,
)
from ocp_traj.papers.records import Records

ISSA, SSA, PSO = "ISSA of A", "SSA", "PSO"
OWN = ((ISSA, "issa-a@paper"), (SSA, "ssa[population=100]"), (PSO, "pso@paper-a"))
POPULATION, GENERATIONS = 100, 50


class PaperA(Paper):
    """Energy of a UR5 on its return trip; the printed points, limits and energies are lost."""

    key = "A"
    title = "Energy-optimal welding trajectory by an improved sparrow search"
    reference = "doi:10.1177/00202940231220080"
    summary = (
        "A UR5 returns empty from palletizing through eight joint positions. A B-spline of degree 7 joins them; the "
        "seven durations are chosen for the least energy (integral of the sum of |torque times velocity|) by a "
        "sparrow "
        "search with elite opposition, Gauss-Cauchy mutation and non-dominated sorting of cost and violation. The "
        "paper compares it with the plain sparrow search and with a particle swarm."
    )
    case = "ur5-palletizing"
    minimised = "energy"
    stand_ins = (
        "Path points (Table 1), limits, time series (Table 3) and running times (Table 2) are lost: waypoints, "
        "limits "
        "and the bound of 2.8 s on the duration are stand-ins, so no number of the paper can be met, only its order.",
        "The energy formula is lost; the sum of |torque times velocity| is our reading.",
        "Equations 9 to 12 are lost: elite opposition, Gauss-Cauchy mutation and its threshold 1e-3 are standard "
        "forms.",
        "Producers 20 %, scouts 10 %, ST 0.8, the swarm's inertia 0.9 to 0.4 and c1 = c2 = 2 are stand-ins.",
    )

    def experiments(self, reduced: bool) -> list[Experiment]:
        """Return A's three methods with its n = 100 and T = 50, then equal evaluations."""
        generations = 2 if reduced else GENERATIONS
        methods = (
            *OWN,
            ("ISSA of A, feasible first", "issa-a@paper[handling=feasible-first]"),
            ("SSA, debiased", "ssa-debiased[population=100]"),
            ("PSO, constriction", "pso-constriction"),
            ("DE", "de"),
            ("CMA-ES", "cmaes"),
            ("CMA-ES, scaled", "cmaes[encoding=scaled]"),
            ("random search", "random"),
        )
        return [
            *(
                Experiment(PUBLISHED_PROTOCOL, label, solver, generations_budget(solver, generations))
                for label, solver in OWN
            ),
            *equal_evaluations(methods, POPULATION * GENERATIONS, reduced),
        ]

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        own = {label: records.values(label, "energy", PUBLISHED_PROTOCOL) for label, _ in OWN}
        ordered, _, tests = order_with_tests(own)
        best = records.raw("IPOPT", "energy", EQUAL_EVALUATIONS)
        medians = ", ".join(
            f"{label} {with_unit(median_of(records, label, 'energy', PUBLISHED_PROTOCOL), 'J')}"
            for label in ordered
        )
        feasible = {
            label: int(sum(row["feasible"] for row in records.runs(label, PUBLISHED_PROTOCOL)))
            for label in own
        }
        return [
            "With A's population and generations the order of median energies, best first, is "
            f"{medians} ({tests}).",
            "Runs that found a motion inside the limits: "
            + ", ".join(f"{label} {count} of {len(own[label])}" for label, count in feasible.items())
            + ".",
            f"IPOPT needs no population: {number(float(best[0]) if len(best) else None)} J "
            f"({_feasibility(records)}).",
        ]

    def claims(self, records: Records) -> list[Claim]:
        """Return A's claims."""
        own = {label: records.values(label, "energy", PUBLISHED_PROTOCOL) for label, _ in OWN}
        seconds = {label: records.raw(label, "processor", PUBLISHED_PROTOCOL) for label, _ in OWN}
        spent = {label: records.raw(label, "generations", PUBLISHED_PROTOCOL) for label, _ in OWN}
        slowest = {label: -spent[label] for label in (PSO, SSA, ISSA)}
        swarm = claim_order("PSO converges slowest of the three", "Fig. 2, text", slowest, "")
        generations = "; ".join(f"{label} {spread_of(spent[label], 0)}" for label in spent)
        return [
            claim_order("energy: ISSA < SSA < PSO", "Fig. 2, text", own, "J"),
            Claim(
                "PSO converges after 43 generations",
                "Fig. 2, text",
                f"PSO {spread_of(spent[PSO], 0)} of {GENERATIONS} generations, median and quartiles",
                "another case (stand-in); one run there",
            ),
            Claim(swarm.sentence, swarm.source, f"generations: {generations}", swarm.verdict),
            claim_order(
                "ISSA's average running time is significantly lower than that of SSA and PSO (processor time)",
                "Table 2 (lost), text, 20 runs",
                {ISSA: seconds[ISSA], SSA: seconds[SSA], PSO: seconds[PSO]},
                "s",
            ),
            Claim(
                "equal population and generations compare the methods fairly",
                "implied by section 4",
                "evaluations really spent: "
                + ", ".join(
                    f"{label} {int(records.raw(label, 'evaluations', PUBLISHED_PROTOCOL)[0])}"
                    for label in own
                ),
                "does not hold: scouts, opposite points and mutants cost evaluations",
            ),
            *self._smoothness(records),
            Claim(
                "printed energies, running times and time series",
                "Tables 1 to 3",
                "lost in the text we have",
                "cannot be checked",
            ),
        ]

    def _smoothness(self, records: Records) -> list[Claim]:
        from ocp_traj.audit import audit
        from ocp_traj.papers.figures import best_motion

        motion = best_motion(self.task(), records.runs(ISSA, PUBLISHED_PROTOCOL), "energy")
        if motion is None:
            return []
        verdict = audit(self.task(), motion)
        return [
            Claim(
                "velocity, acceleration and jerk are zero at start and end, and every point is met",
                "Figs. 3 to 6",
                f"ISSA's best motion: ends missed by {verdict.boundary_error:.1g} of the limits, points by "
                f"{verdict.waypoint_error:.1g} rad",
                "holds"
                if verdict.boundary_error <= 1e-8 and verdict.waypoint_error <= 1e-8
                else "does not hold",
            ),
            Claim(
                "the motion keeps the kinematic limits",
                "conclusion 3",
                "ISSA's best motion keeps every limit" if verdict.feasible else verdict.findings[0],
                "holds" if verdict.feasible else "does not hold",
            ),
        ]

    def figures(self, records: Records, folder: Path) -> list[Figure]:
        """Draw A's figures."""
        from ocp_traj.papers.figures import best_motion, convergence_figure, motion_figure

        labels = [label for label, _ in OWN]
        motion = best_motion(self.task(), records.runs(ISSA, PUBLISHED_PROTOCOL), "energy")
        found = [
            Figure("1", "flow chart: a drawing, not a result", impossible="nothing to compute"),
            Figure(
                "2",
                "Energy over evaluations, median and quartiles over seeds (the paper shows one run over generations; "
                "a curve starts where more than half of the runs are feasible).",
                convergence_figure(
                    records,
                    labels,
                    PUBLISHED_PROTOCOL,
                    folder / "paper-a-convergence.png",
                    "Paper A, Fig. 2",
                    "J",
                ),
            ),
        ]
        if motion is not None:
            name = motion_figure(
                self.task(),
                {ISSA: motion},
                folder / "paper-a-motion.png",
                "Paper A, Figs. 3 to 6, stand-in case",
            )
            found.append(
                Figure("3 to 6", "Position, velocity, acceleration and jerk of ISSA's best motion.", name)
            )
        return found


def _feasibility(records: Records) -> str:
    rows = records.runs("IPOPT", EQUAL_EVALUATIONS)
    if not rows:
        return "not run"
    return (
        "feasible by the audit" if rows[0]["feasible"] else f"not feasible by the audit: {rows[0]['message']}"
    )
