"""Paper B: 3-5-3 polynomials of a six-axis arm, improved sparrow search, every joint alone."""

from __future__ import annotations

from pathlib import Path

from ocp_traj.papers.experiments import BETTER_CURVE, PUBLISHED_PROTOCOL, Protocol
from ocp_traj.papers.joints_apart import joints_table, segments_table, totals
from ocp_traj.papers.measures import number, order_with_tests, quartiles
from ocp_traj.papers.motions import audit_durations, certified_optimum, joint_optima, synchronised_optima
from ocp_traj.papers.paper import AuditedMotion, Claim, Figure, Paper, Table
from ocp_traj.papers.printed_b import ISSA, PSO, PUBLISHED_TOTALS, SSA, UNOPTIMISED
from ocp_traj.papers.records import Records

MOVING_JOINTS = (2, 3, 4, 5, 6)


class PaperB(Paper):
    """Shortest 3-5-3 motion through four points."""

    key = "B"
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
        "Eq. (43) is dropped; the reverse move replaces both branches of the scouts; a better position "
        "replaces, a worse does not.",
        "Equations (28) and (31) and the matrix A carry misprints; the 3-5-3 curve was derived, not copied.",
    )

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        rows = [row for label in self.protocol.labels for row in records.runs(label, PUBLISHED_PROTOCOL)]
        kept = sum(row["feasible"] for row in rows)
        issa = records.runs(ISSA, PUBLISHED_PROTOCOL)
        worst = max((row["worst"] for row in issa), key=lambda entry: entry["ratio"])
        shared = certified_optimum(self.task(), records)
        order, _, tests = order_with_tests(totals(self, records))
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
            f"Order of the three methods by synchronised total, feasible or not: {', '.join(order)} ({tests}).",
            f"What the same limits allow with a cubic spline: {'; '.join(curves)}.",
        ]

    def audited(self, records: Records) -> list[AuditedMotion]:
        """Return the synchronised optima of the joints, and ISSA's best synchronised run."""
        optima = joint_optima(self, records)
        task = self.task()
        found = [
            audit_durations(
                task, "every joint's own optimum, synchronised", synchronised_optima(self, optima)
            )
        ]
        for label in self.protocol.labels:
            best = min(
                records.runs(label, PUBLISHED_PROTOCOL), key=lambda row: float(row["duration"]), default=None
            )
            if best is not None:
                found.append(
                    audit_durations(task, f"{label}, its shortest synchronised run", best["segments"])
                )
        found.append(audit_durations(task, "unoptimised, 2 s a segment", [UNOPTIMISED / 3] * 3))
        return found

    def tables(self, records: Records) -> list[Table]:
        """Return the segments and the joints alone."""
        return [segments_table(self, records), joints_table(self, records, " Joint 1 does not move.")]

    def claims(self, records: Records) -> list[Claim]:
        """Return B's claims."""
        from ocp_traj.papers.claims_b import claims

        return claims(self, records)

    def figures(self, records: Records, folder: Path) -> list[Figure]:
        """Draw B's figures."""
        from ocp_traj.papers.figures import best_motion, joints_figure, motion_figure, tool_path_figure
        from ocp_traj.transcription import trajectory_from_durations

        task = self.task()
        labels = self.protocol.labels
        motions = {}
        for label in labels:
            motion = best_motion(task, records.runs(label, PUBLISHED_PROTOCOL), "duration")
            if motion is not None:
                motions[label] = motion
        optimum = trajectory_from_durations(task, certified_optimum(task, records)["durations"])
        path, length = tool_path_figure(task, optimum, folder / "paper-b-tool.png", "Paper B, Fig. 5")
        return [
            Figure(
                "1 to 4", "dimensions, frames, schematic and flow chart", impossible="drawings, not results"
            ),
            Figure(
                "5",
                f"Path of the tool on the feasible optimum, {length:.3f} m long. The paper plans its path in "
                "space but prints only the four joint positions; between them the path is that of the 3-5-3 "
                "curve.",
                path,
            ),
            Figure(
                "6",
                "Convergence of every moving joint, median over seeds and quartiles (joint 1 does not move).",
                joints_figure(
                    records,
                    labels,
                    PUBLISHED_PROTOCOL,
                    MOVING_JOINTS,
                    folder / "paper-b-joints.png",
                    "Paper B, Fig. 6",
                ),
            ),
            Figure(
                "7",
                "Position, velocity, acceleration and jerk of each method's best run (feasible first).",
                motion_figure(task, motions, folder / "paper-b-motion.png", "Paper B, Fig. 7"),
            ),
        ]
