"""What is done for paper A: energy-optimal trajectory of a UR5, degree-7 B-spline, improved sparrow search."""

from __future__ import annotations

from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.drawings import best_motion, convergence_picture, motions_picture
from ocp_traj.papers.experiments import EQUAL_EVALUATIONS, PUBLISHED_PROTOCOL, Protocol
from ocp_traj.papers.measurement_control_2023.claims import ISSA, PSO, SSA, claims
from ocp_traj.papers.measures import number, order_with_tests, with_unit
from ocp_traj.papers.paper import Claim, Paper
from ocp_traj.papers.records import Records
from ocp_traj.pictures.picture import Picture


class MeasurementControl2023(Paper):
    """Energy of a UR5 on its return trip; the printed points, limits and energies are lost."""

    key = "A"
    name = "Measurement and Control 2023"
    title = "Energy-optimal welding trajectory by an improved sparrow search"
    reference = "Measurement and Control (2023), doi:10.1177/00202940231220080"
    summary = (
        "A UR5 returns empty from palletizing through eight joint positions. A B-spline of degree 7 joins "
        "them; the seven durations are chosen for the least energy (integral of the sum of |torque times "
        "velocity|) by a sparrow search with elite opposition, Gauss-Cauchy mutation and non-dominated "
        "sorting of cost and violation. The paper compares it with the plain sparrow search and with a "
        "particle swarm."
    )
    case = "ur5-palletizing"
    protocol = Protocol(
        methods=((ISSA, "issa-a@paper"), (SSA, "ssa[population=100]"), (PSO, "pso@paper-a")),
        population=100,
        generations=50,
        further=(
            ("ISSA of A, feasible first", "issa-a@paper[handling=feasible-first]"),
            ("ISSA of A, beta scalar", "issa-a@paper[beta=scalar]"),
            ("SSA, beta scalar", "ssa[population=100,beta=scalar]"),
            ("CMA-ES, scaled", "cmaes[encoding=scaled]"),
        ),
        gradient=(("IPOPT", "ipopt"),),  # the others take minutes over this energy
    )
    minimised = "energy"
    stand_ins = (
        "Path points (Table 1), limits, time series (Table 3) and running times (Table 2) are lost: "
        "waypoints, limits and the bound of 2.8 s on the duration are stand-ins, so no number of the paper "
        "can be met, only its order. A motion longer than that bound is infeasible, whatever its worst ratio.",
        "The energy formula is lost; the sum of |torque times velocity| is our reading.",
        "Readings: beta is one normal number per coordinate, as in the program of sparrow search's author; one number "
        "for all coordinates, which the text allows too, is a further row.",
        "Equations 9 to 12 are lost: elite opposition, Gauss-Cauchy mutation and its threshold 1e-3 are standard "
        "forms.",
        "Producers 20 %, scouts 10 %, ST 0.8, the swarm's inertia 0.9 to 0.4 and c1 = c2 = 2 are stand-ins.",
    )

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        own = {label: records.values(label, "energy", PUBLISHED_PROTOCOL) for label in self.protocol.labels}
        ordered, _, tests = order_with_tests(own)
        best = records.raw("IPOPT", "energy", EQUAL_EVALUATIONS)
        medians = ", ".join(f"{label} {with_unit(quartiles(own[label])[1], 'J')}" for label in ordered)
        feasible = {
            label: int(sum(row.record.feasible for row in records.runs(label, PUBLISHED_PROTOCOL)))
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
        """Return the paper's claims."""
        return claims(self, records)

    def figures(self, records: Records) -> list[Picture | str]:
        """Return the convergence of the methods, and the best motion."""
        motion = best_motion(self.task(), records.runs(ISSA, PUBLISHED_PROTOCOL), "energy")
        figures: list[Picture | str] = [
            "Fig. 1, flow chart: a drawing, not a result: not regenerated, nothing to compute.",
            convergence_picture(
                records,
                self.protocol.labels,
                PUBLISHED_PROTOCOL,
                "Fig. 2",
                "Energy over evaluations, median and quartiles over seeds (the paper shows one run over generations; "
                "a curve starts where more than half of the runs are feasible).",
                "J",
            ),
        ]
        if motion is not None:
            caption = "Position, velocity, acceleration and jerk of ISSA's best motion."
            figures.append(motions_picture(self.task(), {ISSA: motion}, "Fig. 3 to 6", caption))
        return figures


def _feasibility(records: Records) -> str:
    runs = [row.record for row in records.runs("IPOPT", EQUAL_EVALUATIONS)]
    if not runs:
        return "not run"
    return "feasible by the audit" if runs[0].feasible else f"not feasible by the audit: {runs[0].message}"
