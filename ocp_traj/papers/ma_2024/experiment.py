"""What is done for Ma et al. 2024 (paper B): 3-5-3 polynomials, improved sparrow search, every joint alone."""

from __future__ import annotations

from ocp_traj.comparison.report.document import Table
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.drawings import best_motion, joints_picture, motions_picture, tool_picture
from ocp_traj.papers.experiments import BETTER_CURVE, PUBLISHED_PROTOCOL, Protocol
from ocp_traj.papers.joints_apart import joints_table, segments_table, slowed_totals, totals
from ocp_traj.papers.ma_2024.claims import ISSA, PSO, PUBLISHED_TOTALS, SSA, UNOPTIMISED, claims
from ocp_traj.papers.measures import number, order_with_tests
from ocp_traj.papers.motions import (
    audit_durations,
    certified_optimum,
    joint_optima,
    synchronised_optima,
    travelled,
)
from ocp_traj.papers.paper import AuditedMotion, Claim, Paper
from ocp_traj.papers.records import Records, number_of
from ocp_traj.pictures.picture import Picture
from ocp_traj.transcription import trajectory_from_durations

MOVING_JOINTS = (2, 3, 4, 5, 6)
"""From 1; joint 1 has the same angle at all four points."""


class Ma2024(Paper):
    """Shortest 3-5-3 motion through four points."""

    key = "B"
    name = "Ma et al. 2024"
    title = "Industrial robot trajectory optimisation by an improved sparrow search"
    reference = "Ma et al., Machines 12(7) 490 (2024), doi:10.3390/machines12070490"
    summary = (
        "A six-axis arm passes four joint positions on 3-5-3 polynomials (cubic, quintic, cubic; at rest at "
        "both ends). The three durations of every joint are minimised apart from the other joints, under "
        "limits of velocity and acceleration, by a sparrow search with a two-dimensional logistic chaotic "
        "start, Levy flights and reverse learning; the paper compares it with the plain sparrow search and a "
        "particle swarm, and reports one total each."
    )
    case = "machines-2024-490"
    protocol = Protocol(
        methods=((ISSA, "issa-b@paper"), (SSA, "ssa[population=30]"), (PSO, "pso@paper-b")),
        population=30,
        generations=1000,
        joints=len(MOVING_JOINTS),
        published={label: f"{total} s" for label, total in PUBLISHED_TOTALS.items()},
        further=(
            ("ISSA of B, scaled", "issa-b@paper[encoding=scaled]"),
            ("SSA, beta scalar", "ssa[population=30,beta=scalar]"),
            ("random search, scaled", "random[encoding=scaled]"),
        ),
        curves=((0, "free"), (3, "zero"), (3, "free"), (7, "free")),
    )
    stand_ins = (
        "How the joints are brought together is not said; the largest duration of each segment, over the joints that "
        "move in it, is our reading.",
        "A jerk limit is named but not printed: none is set.",
        "Stand-ins: chaos parameter a = 0.9, weights 0.9 to 0.4, the swarm's c1 = c2 = 2.",
        "Readings: coordinates of the chaotic start filled x, y alternately from one orbit; the stray 2 in "
        "Eq. (43) is dropped, and the sine's absolute value is taken where it is negative; X_b in "
        "Eq. (41) is the newest best, after producers and scroungers of the same generation; beta in Eq. (41) is one "
        "number per coordinate, as in the author's program (one for all is a further row); "
        "the reverse move replaces both branches of the scouts; a better position "
        "replaces, a worse does not.",
        "Equations (28) and (31) and the matrix A carry misprints; the 3-5-3 curve was derived, not copied.",
    )

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        rows = [row for label in self.protocol.labels for row in records.runs(label, PUBLISHED_PROTOCOL)]
        kept = sum(row.record.feasible for row in rows)
        issa = [row.record.worst for row in records.runs(ISSA, PUBLISHED_PROTOCOL) if row.record.worst]
        worst = max(issa, key=lambda entry: float(entry["ratio"]))
        shared = certified_optimum(self.task(), records)
        order, _, tests = order_with_tests(slowed_totals(self, records))
        raw, _, raw_tests = order_with_tests(totals(self, records))
        curves = [
            f"{experiment.label.removeprefix('cubic spline, ')}: "
            f"{number(quartiles(records.values(experiment.label, 'duration', BETTER_CURVE))[1])} s"
            for experiment in self.experiments(False)
            if experiment.group == BETTER_CURVE and records.runs(experiment.label, BETTER_CURVE)
        ]
        return [
            f"The published total of {PUBLISHED_TOTALS[ISSA]} s is no feasible synchronised motion: with "
            "shared durations no 3-5-3 motion within the paper's own limits is shorter than "
            f"{number(shared['lower'])} s ({number(shared['upper'])} s is reached; {shared['message']}).",
            f"With the paper's protocol {kept} of {len(rows)} synchronised motions keep the limits; ISSA's "
            f"worst one exceeds the limit of {worst['limit']} of joint {worst['joint']} {worst['ratio']:.3f} "
            f"times, at {worst['time']:.3f} s.",
            "Order of the three methods by synchronised total once slowed into the limits: "
            f"{', '.join(order)} ({tests}); feasible or not: {', '.join(raw)} ({raw_tests}).",
            f"What the same limits allow with a cubic spline: {'; '.join(curves)}.",
        ]

    def audited(self, records: Records) -> list[AuditedMotion]:
        """Return the synchronised optima of the joints, and ISSA's best synchronised run."""
        task = self.task()
        together = synchronised_optima(task, joint_optima(task, records))
        motions = {"every joint's own optimum, synchronised": together}
        for label in self.protocol.labels:
            rows = [row for row in records.runs(label, PUBLISHED_PROTOCOL) if row.record.duration is not None]
            if rows:
                best = min(rows, key=lambda row: number_of(row, "duration") or 0.0)
                motions[f"{label}, its shortest synchronised run"] = best.record.details["segments"]
        motions["unoptimised, 2 s a segment"] = [UNOPTIMISED / 3] * 3
        return [audit_durations(task, words, durations) for words, durations in motions.items()]

    def tables(self, records: Records) -> list[Table]:
        """Return the segments and the joints alone."""
        return [segments_table(self, records), joints_table(self, records, " Joint 1 does not move.")]

    def claims(self, records: Records) -> list[Claim]:
        """Return the paper's claims."""
        return claims(self, records)

    def figures(self, records: Records) -> list[Picture | str]:
        """Return the path of the tool, the convergence of the joints, and each method's best motion."""
        task, labels = self.task(), self.protocol.labels
        optimum = certified_optimum(task, records)["durations"]
        best = {label: best_motion(task, records.runs(label, PUBLISHED_PROTOCOL), "duration") for label in labels}
        return [
            "Fig. 1 to 4, dimensions, frames, schematic and flow chart: not regenerated, drawings, not results.",
            tool_picture(
                task,
                trajectory_from_durations(task, optimum),
                "Fig. 5",
                f"Path of the tool on the feasible optimum, {travelled(task, optimum):.3f} m long. The paper plans its "
                "path in space but prints only the four joint positions; between them the path is that of the 3-5-3 "
                "curve.",
            ),
            joints_picture(
                records,
                labels,
                PUBLISHED_PROTOCOL,
                MOVING_JOINTS,
                "Fig. 6",
                "Convergence of every moving joint, median over seeds and quartiles (joint 1 does not move).",
            ),
            motions_picture(
                task,
                {label: motion for label, motion in best.items() if motion is not None},
                "Fig. 7",
                "Position, velocity, acceleration and jerk of each method's best run (feasible first).",
            ),
        ]
