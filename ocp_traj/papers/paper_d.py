"""Paper D: 3-5-3 polynomials of a FANUC arm, particle swarm with trigonometric factors, every joint alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.exceptions import OcpTrajError
from ocp_traj.papers.experiments import better_curves, equal_evaluations
from ocp_traj.papers.measures import (
    audit_durations,
    certified_optimum,
    claim_order,
    joint_optima,
    number,
    path_length,
    quartiles,
    spread_of,
    synchronised_optima,
)
from ocp_traj.papers.paper import (
    PUBLISHED_PROTOCOL,
    AuditedMotion,
    Claim,
    Experiment,
    Figure,
    Paper,
    Table,
    generations_budget,
)
from ocp_traj.papers.records import Records

IMPROVED, PLAIN, REPAIRED = "PSO of D", "PSO", "PSO of D, repaired"
OWN = (
    (IMPROVED, "pso-d@paper-d"),
    (PLAIN, "pso[population=50,inertia=constant,weight=0.7]"),
    (REPAIRED, "pso-d[population=50,inertia=trigonometric-repaired]"),
)
PUBLISHED = [0.311, 0.660, 1.676]
"""Section 4, seconds."""

UNOPTIMISED = [2.0, 2.0, 2.0]
POPULATION, GENERATIONS = 50, 200
PRINTED_POINT, MENDED_POINT = "63.179", "-63.179"
CURVES = ((0, "free"), (3, "zero"), (7, "free"))


class PaperD(Paper):
    """Shortest 3-5-3 motion of a welding arm through four points."""

    key = "D"
    title = "Trajectory planning of a rotor welding manipulator by an improved particle swarm"
    reference = "Zhu and Wang, Tianjin University of Technology and Education"
    summary = (
        "A FANUC ARC Mate M-10iD/8L passes four joint positions on 3-5-3 polynomials. The three durations of "
        "every joint "
        "are minimised apart by a particle swarm whose inertia and learning factors follow trigonometric "
        "functions; the "
        "largest duration of each segment makes the joints synchronous. The paper prints these three durations."
    )
    case = "fanuc-m10id8l"
    joints_apart = True
    stand_ins = (
        "The limits are not printed: velocities and ranges are FANUC's own, accelerations (full speed in 0.25 s) "
        "are a "
        "stand-in. Durations of ours and of the paper therefore cannot be compared as better or worse.",
        "Population 50, and w = 0.7, c1 = c2 = 2 of the plain swarm, are stand-ins.",
        "Misprints mended in the case: row 4 of Table 1 (a = 195 mm, not 1100), the signs of alpha (those of the "
        "paper's "
        "own Eq. 3), joint 3's third waypoint (-63.179 deg), the unit of Table 2 (deg, not rad).",
        "Eq. (10) is run as printed (no + w_min, no pi inside the cosine); the repaired reading is a row of its own.",
    )

    def experiments(self, reduced: bool) -> list[Experiment]:
        """Return D's two swarms joint by joint (T = 200), then shared durations and other curves."""
        generations = 3 if reduced else GENERATIONS
        methods = (
            *OWN,
            ("PSO, constriction", "pso-constriction"),
            ("SSA", "ssa[population=50]"),
            ("SSA, debiased", "ssa-debiased[population=50]"),
            ("DE", "de"),
            ("CMA-ES", "cmaes"),
            ("random search", "random"),
            ("random search, scaled", "random[encoding=scaled]"),
        )
        return [
            *(
                Experiment(
                    PUBLISHED_PROTOCOL,
                    label,
                    solver,
                    6 * generations_budget(solver, generations),
                    ('search.protocol="per-joint"',),
                    "2.647 s" if label == IMPROVED else "",
                )
                for label, solver in OWN
            ),
            *equal_evaluations(methods, POPULATION * GENERATIONS, reduced),
            *better_curves(CURVES[: 1 if reduced else None]),
        ]

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        task = self.task()
        published = audit_durations(task, "", PUBLISHED)
        misprinted = audit_durations(self._misprinted(), "", PUBLISHED)
        shared = certified_optimum(task, records)
        rows = [row for label, _ in OWN for row in records.runs(label, PUBLISHED_PROTOCOL)]
        return [
            f"The printed durations (total {published.duration:.3f} s) are "
            f"{'feasible' if published.feasible else 'not feasible'} under FANUC's velocities and the stand-in "
            "accelerations "
            f"once the third waypoint of joint 3 is read as {MENDED_POINT} deg; as printed (+{PRINTED_POINT}) "
            "they are "
            f"{'feasible' if misprinted.feasible else 'not: ' + misprinted.finding}.",
            f"With shared durations the shortest 3-5-3 motion under these limits takes {number(shared['upper'])} s "
            f"(proved above {number(shared['lower'])} s).",
            f"Joints apart and synchronised: {sum(row['feasible'] for row in rows)} of {len(rows)} runs keep the "
            "limits; "
            f"median totals "
            + ", ".join(f"{label} {number(quartiles(self._totals(records)[label])[1])} s" for label, _ in OWN)
            + ".",
        ]

    @staticmethod
    def _totals(records: Records) -> dict[str, Any]:
        return {label: records.raw(label, "duration", PUBLISHED_PROTOCOL) for label, _ in OWN}

    def _misprinted(self) -> Any:
        rows = np.rad2deg(self.task().waypoints).round(3)
        rows[2, 2] = float(PRINTED_POINT)
        return self.task((f"waypoints.joints={rows.tolist()}",))

    def audited(self, records: Records) -> list[AuditedMotion]:
        """Return the printed durations, mended and as printed, and the joints' certified optima."""
        task = self.task()
        optima = joint_optima(self, records)
        return [
            audit_durations(task, "printed durations, joint 3 mended", PUBLISHED),
            audit_durations(
                self._misprinted(),
                f"printed durations, joint 3 at +{PRINTED_POINT} deg as printed",
                PUBLISHED,
            ),
            audit_durations(task, "unoptimised, 2 s a segment", UNOPTIMISED),
            audit_durations(
                task, "every joint's own optimum, synchronised", synchronised_optima(self, optima)
            ),
        ]

    def tables(self, records: Records) -> list[Table]:
        """Return the joints alone, what the printed durations ask of each joint, and energies."""
        optima = joint_optima(self, records)
        rows = []
        for joint, found in optima.items():
            cells = [f"{joint}", number(found["upper"]), found["message"]]
            for label, _ in OWN:
                cells.append(spread_of(records.part(label, joint, "cost", PUBLISHED_PROTOCOL)))
                cells.append(spread_of(records.part(label, joint, "generations", PUBLISHED_PROTOCOL), 0))
            rows.append(tuple(cells))
        header = ["joint", "optimum found, s", "proof"]
        for label, _ in OWN:
            header += [f"{label}, s", f"{label}, generations"]
        return [
            Table(
                "Every joint alone",
                tuple(header),
                tuple(rows),
                "Medians and quartiles over seeds; generations until within 0.1 % of the run's final best.",
            ),
            self._needed(),
            self._energies(records),
        ]

    def _needed(self) -> Table:
        from ocp_traj.audit import audit
        from ocp_traj.transcription import trajectory_from_durations

        task = self.task()
        verdict = audit(task, trajectory_from_durations(task, PUBLISHED))
        largest: dict[tuple[str, int], float] = {}
        for peak in verdict.peaks:
            place = (peak.limit, peak.joint)
            largest[place] = max(largest.get(place, 0.0), abs(float(np.rad2deg(peak.value))))
        rows = [
            (
                f"{joint + 1}",
                *(number(largest.get((name, joint)), 1) for name in ("velocity", "acceleration")),
            )
            for joint in range(task.n)
        ]
        return Table(
            "What the printed durations ask of each joint",
            ("joint", "largest velocity, deg/s", "largest acceleration, deg/s²"),
            tuple(rows),
            "The limits that the paper does not print must have been at least these.",
        )

    def _energies(self, records: Records) -> Table:
        found = _energy_rows(self, records)
        rows = tuple((row["motion"], number(row["duration"]), number(row["energy"], 1)) for row in found)
        from ocp_traj.papers.fanuc_inertia import SOURCE

        return Table(
            "Our extension: energy, the paper's outlook",
            ("motion", "duration, s", "energy, J"),
            rows,
            f"Integral of the sum of |torque times velocity|; inertia of the links from {SOURCE}, without "
            "payload, rotors, "
            "friction and gravity balancing, which it does not state.",
        )

    def claims(self, records: Records) -> list[Claim]:
        """Return D's claims."""
        joints = range(1, 7)
        total = sum(PUBLISHED)
        generations = {
            label: np.mean(
                [records.part(label, joint, "generations", PUBLISHED_PROTOCOL) for joint in joints], axis=0
            )
            for label in (IMPROVED, PLAIN)
        }
        medians = {
            joint: quartiles(records.part(IMPROVED, joint, "generations", PUBLISHED_PROTOCOL))[1]
            for joint in joints
        }
        quick = sum(value <= 30 for value in medians.values())
        accuracy = {
            label: np.mean(
                [records.part(label, joint, "cost", PUBLISHED_PROTOCOL) for joint in joints], axis=0
            )
            for label in (IMPROVED, PLAIN)
        }
        return [
            Claim(
                "most joints converge within 30 iterations",
                "section 4",
                "median generations of joints 1 to 6: "
                + ", ".join(f"{value:.0f}" for value in medians.values()),
                "holds" if quick > 3 else "does not hold",
            ),
            claim_order(
                "the improved swarm needs fewer iterations than the plain one (mean over joints)",
                "Figs. 1 and 2",
                generations,
                "generations",
            ),
            claim_order(
                "the improved swarm's solution is more accurate (mean of the joints' own optima)",
                "section 4",
                accuracy,
                "s",
            ),
            Claim(
                "2.647 s, 56 % less than the initial 6 s",
                "section 4",
                f"{' + '.join(map(str, PUBLISHED))} = {total:.3f} s, {100 * (1 - total / 6):.1f} % less; with our "
                "limits "
                f"(accelerations a stand-in) ours: {number(quartiles(self._totals(records)[IMPROVED])[1])} s "
                "synchronised",
                "arithmetic holds",
            ),
            *self._motion_claims(records),
            *self._print_claims(),
        ]

    def _motion_claims(self, records: Records) -> list[Claim]:
        task = self.task()
        before, after = path_length(task, UNOPTIMISED), path_length(task, PUBLISHED)
        mended = audit_durations(task, "", PUBLISHED)
        return [
            Claim(
                "a shorter path of the end effector",
                "section 4",
                f"2 s a segment: {before:.4f} m; printed durations: {after:.4f} m; shortest feasible motion: "
                f"{path_length(task, certified_optimum(task, records)['durations']):.4f} m",
                "holds" if after < before else "does not hold",
            ),
            Claim(
                "the synchronised motion keeps the kinematic limits",
                "section 4",
                f"printed durations: {mended.finding}; largest ratio {mended.ratio:.4f}",
                "holds under FANUC's velocities and the stand-in accelerations"
                if mended.feasible
                else "does not hold",
            ),
            Claim(
                "the largest duration of each segment makes the joints synchronous",
                "section 4",
                "a joint stretched in one segment only can exceed its limits in another; see the joints' optima, "
                "synchronised, before the judge",
                "synchronous yes; safe not in general (paper B's case breaks)",
            ),
        ]

    def _print_claims(self) -> list[Claim]:
        misprinted = audit_durations(self._misprinted(), "", PUBLISHED)
        try:
            self.task(('waypoints.unit="rad"',))
            unit = "accepted"
        except OcpTrajError as error:
            unit = f"refused: {error}"
        return [
            Claim(f"joint 3 passes +{PRINTED_POINT}", "Table 2", misprinted.finding, "misprint: the sign"),
            Claim("joint positions in rad", "Table 2", unit, "misprint: the unit is deg"),
            Claim(
                "a_3 = 1100 mm",
                "Table 1",
                "FANUC's own description has 195 mm between J3 and J4 and 1100 mm to J5",
                "misprint",
            ),
            Claim(
                "14 unknowns from Eq. (6)",
                "Eq. (6)",
                "the printed vector has 15 entries",
                "contradiction inside the paper",
            ),
        ]

    def figures(self, records: Records, folder: Path) -> list[Figure]:
        """Draw D's figures."""
        from ocp_traj.papers.figures import joints_figure, motion_figure, segments_figure, tool_path_figure
        from ocp_traj.transcription import trajectory_from_durations

        task = self.task()
        labels = [label for label, _ in OWN]
        found = []
        first = records.runs(IMPROVED, PUBLISHED_PROTOCOL)[:1]
        for row in first:
            for part in row["parts"][:2]:
                joint = part["joint"]
                found.append(
                    Figure(
                        f"{joint}a",
                        f"Durations of joint {joint}'s segments in the best particle over generations, first seed.",
                        segments_figure(
                            part,
                            folder / f"paper-d-segments-{joint}.png",
                            f"Paper D, Fig. {joint}a, joint {joint}",
                        ),
                    )
                )
        name = joints_figure(
            records,
            labels,
            PUBLISHED_PROTOCOL,
            (1, 2),
            folder / "paper-d-joints.png",
            "Paper D, Figs. 1b and 2b",
        )
        shared = certified_optimum(task, records)["durations"]
        motions = {
            "printed durations": trajectory_from_durations(task, PUBLISHED),
            "certified optimum": trajectory_from_durations(task, shared),
        }
        path, length = tool_path_figure(
            task, motions["printed durations"], folder / "paper-d-tool.png", "Paper D, path of the flange"
        )
        return [
            *found,
            Figure("1b and 2b", "Convergence of joints 1 and 2, median and quartiles over seeds.", name),
            Figure(
                "3 to 5",
                "Position, velocity, acceleration (and jerk) with the printed durations and with the certified "
                "optimum.",
                motion_figure(task, motions, folder / "paper-d-motion.png", "Paper D, Figs. 3 to 5"),
            ),
            Figure(
                "(not in the paper)", f"Path of the flange with the printed durations, {length:.3f} m.", path
            ),
        ]


def _energy_rows(paper: PaperD, records: Records) -> list[dict[str, Any]]:
    """Return durations and energies of known motions and of the least-energy ones within given times, once."""
    from ocp_traj.case import task_digest
    from ocp_traj.papers.fanuc_inertia import with_inertia

    task = with_inertia(paper.task())
    shortest = certified_optimum(paper.task(), records)["durations"]
    found = records.computed(
        "energies", lambda: {"rows": _compute_energies(task, shortest)}, task_digest(task)
    )
    rows: list[dict[str, Any]] = found["rows"]
    return rows


def _compute_energies(task: Any, shortest: list[float]) -> list[dict[str, Any]]:
    from dataclasses import replace

    from ocp_traj.energy import energy
    from ocp_traj.solve import solve
    from ocp_traj.task import Objective
    from ocp_traj.transcription import trajectory_from_durations

    known = {
        "certified shortest": shortest,
        "printed durations": PUBLISHED,
        "unoptimised, 2 s a segment": UNOPTIMISED,
    }
    rows = []
    for words, durations in known.items():
        motion = trajectory_from_durations(task, durations)
        rows.append({"motion": words, "duration": motion.duration, "energy": energy(task, motion)})
    for allowed in (1.5, sum(PUBLISHED), sum(UNOPTIMISED)):
        economical = replace(task, objective=Objective(energy=1.0, duration=(0.1, allowed)))
        result = solve(economical, "de", seed=0, budget=10_000)
        verdict = "" if result.feasible else ", not feasible"
        rows.append(
            {
                "motion": f"least energy within {allowed:.3f} s (DE, 10 000 evaluations{verdict})",
                "duration": result.duration,
                "energy": result.energy,
            }
        )
    return rows
