"""What is done for Zhu and Wang (paper D): 3-5-3 polynomials of a FANUC arm, improved swarm, every joint alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.audit import audit
from ocp_traj.comparison.report.document import Table
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.drawings import joints_picture, motions_picture, segments_picture, tool_picture
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL, Protocol
from ocp_traj.papers.joints_apart import joints_table, segments_table, totals
from ocp_traj.papers.measures import number
from ocp_traj.papers.motions import (
    audit_durations,
    certified_optimum,
    joint_optima,
    synchronised_optima,
    travelled,
)
from ocp_traj.papers.paper import AuditedMotion, Claim, Paper, table_of
from ocp_traj.papers.records import Records
from ocp_traj.papers.zhu_wang.claims import (
    IMPROVED,
    MENDED_POINT,
    PLAIN,
    PRINTED_POINT,
    PUBLISHED,
    REPAIRED,
    UNOPTIMISED,
    claims,
    misprinted,
)
from ocp_traj.papers.zhu_wang.fanuc_energy import energy_table
from ocp_traj.pictures.picture import Picture
from ocp_traj.transcription import trajectory_from_durations

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

SHOWN_JOINTS = (1, 2)
"""Of Figs. 1 and 2."""


class ZhuWang(Paper):
    """Shortest 3-5-3 motion of a welding arm through four points."""

    key = "D"
    name = "Zhu and Wang"
    title = "Trajectory planning of a rotor welding manipulator by an improved particle swarm"
    reference = "Zhu and Wang, Tianjin University of Technology and Education"
    summary = (
        "A FANUC ARC Mate M-10iD/8L passes four joint positions on 3-5-3 polynomials. The three durations of "
        "every joint are minimised apart by a particle swarm whose inertia and learning factors follow "
        "trigonometric functions; the largest duration of each segment makes the joints synchronous. The "
        "paper prints these three durations."
    )
    case = "fanuc-m10id8l"
    protocol = Protocol(
        methods=(
            (IMPROVED, "pso-d@paper-d"),
            (PLAIN, "pso[population=50,inertia=constant,weight=0.7]"),
            (REPAIRED, "pso-d[population=50,inertia=trigonometric-repaired]"),
        ),
        population=50,
        generations=200,
        joints=6,
        published={IMPROVED: f"{sum(PUBLISHED):.3f} s"},
        further=(("SSA", "ssa[population=50]"), ("random search, scaled", "random[encoding=scaled]")),
        curves=((0, "free"), (3, "zero"), (7, "free")),
    )
    stand_ins = (
        "The limits are not printed: velocities and ranges are FANUC's own, accelerations (full speed in 0.25 "
        "s) are a stand-in. Durations of ours and of the paper therefore cannot be compared as better or "
        "worse.",
        "Population 50, and w = 0.7, c1 = c2 = 2 of the plain swarm, are stand-ins.",
        "Misprints mended in the case: row 4 of Table 1 (a = 195 mm, not 1100), the signs of alpha (those of the "
        "paper's own Eq. 3), joint 3's third waypoint (-63.179 deg), the unit of Table 2 (deg, not rad).",
        "Eq. (10) is run as printed (no + w_min, no pi inside the cosine); the repaired reading is a row of its own.",
    )

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        task = self.task()
        published = audit_durations(task, "", PUBLISHED)
        printed = audit_durations(misprinted(self), "", PUBLISHED)
        shared = certified_optimum(task, records)
        rows = [row for label in self.protocol.labels for row in records.runs(label, PUBLISHED_PROTOCOL)]
        medians = ", ".join(
            f"{label} {number(quartiles(values)[1])} s" for label, values in totals(self, records).items()
        )
        return [
            f"The printed durations (total {published.duration:.3f} s) are "
            f"{'feasible' if published.feasible else 'not feasible'} under FANUC's velocities and the stand-in "
            f"accelerations once the third waypoint of joint 3 is read as {MENDED_POINT} deg; as printed "
            f"(+{PRINTED_POINT}) they are {'feasible' if printed.feasible else 'not: ' + printed.finding}.",
            f"With shared durations the shortest 3-5-3 motion under these limits takes {number(shared['upper'])} s "
            f"(proved above {number(shared['lower'])} s).",
            f"Joints apart and synchronised: {sum(row.record.feasible for row in rows)} of {len(rows)} runs keep the "
            f"limits; median totals {medians}.",
        ]

    def audited(self, records: Records) -> list[AuditedMotion]:
        """Return the printed durations, mended and as printed, and the joints' certified optima."""
        task = self.task()
        together = synchronised_optima(task, joint_optima(task, records))
        return [
            audit_durations(task, "printed durations, joint 3 mended", PUBLISHED),
            audit_durations(
                misprinted(self),
                f"printed durations, joint 3 at +{PRINTED_POINT} deg as printed",
                PUBLISHED,
            ),
            audit_durations(task, "unoptimised, 2 s a segment", UNOPTIMISED),
            audit_durations(task, "every joint's own optimum, synchronised", together),
        ]

    def tables(self, records: Records) -> list[Table]:
        """Return segments, the joints alone, what the printed durations ask of each joint, and energies."""
        return [
            segments_table(self, records, PUBLISHED),
            joints_table(self, records),
            _needed(self.task()),
            energy_table(self.task(), records),
        ]

    def claims(self, records: Records) -> list[Claim]:
        """Return the paper's claims."""
        return claims(self, records)

    def figures(self, records: Records) -> list[Picture | str]:
        """Return durations and convergence of the first two joints, the motions, and the path of the flange."""
        task, labels = self.task(), self.protocol.labels
        segments = [
            segments_picture(
                records,
                IMPROVED,
                PUBLISHED_PROTOCOL,
                joint,
                f"Fig. {joint}a",
                f"Durations of joint {joint}'s segments in the best particle over generations, first seed.",
            )
            for joint in SHOWN_JOINTS
        ]
        motions = {
            "printed durations": trajectory_from_durations(task, PUBLISHED),
            "certified optimum": trajectory_from_durations(task, certified_optimum(task, records)["durations"]),
        }
        return [
            *(picture for picture in segments if picture is not None),
            joints_picture(
                records,
                labels,
                PUBLISHED_PROTOCOL,
                SHOWN_JOINTS,
                "Fig. 1b and 2b",
                "Convergence of joints 1 and 2, median and quartiles over seeds.",
            ),
            motions_picture(
                task,
                motions,
                "Fig. 3 to 5",
                "Position, velocity, acceleration (and jerk) with the printed durations and with the certified "
                "optimum.",
            ),
            tool_picture(
                task,
                motions["printed durations"],
                "Fig. (not in the paper)",
                f"Path of the flange with the printed durations, {travelled(task, PUBLISHED):.3f} m.",
            ),
        ]


def _needed(task: TrajectoryTask) -> Table:
    """Return the largest velocity and acceleration of each joint with the printed durations."""
    verdict = audit(task, trajectory_from_durations(task, PUBLISHED))
    largest: dict[tuple[str, int], float] = {}
    for peak in verdict.peaks:
        place = (peak.limit, peak.joint)
        largest[place] = max(largest.get(place, 0.0), abs(float(np.rad2deg(peak.value))))
    rows = [
        (f"{joint + 1}", *(number(largest.get((name, joint)), 1) for name in ("velocity", "acceleration")))
        for joint in range(task.n)
    ]
    return table_of(
        "What the printed durations ask of each joint",
        ("joint", "largest velocity, deg/s", "largest acceleration, deg/s²"),
        rows,
        "The limits that the paper does not print must have been at least these.",
    )
