"""What is done for Zhang et al. 2022 (paper C): clamped cubic spline along a helix, improved sparrow search."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from metaheuristics.algorithms.tent_sparrow_search import TentSparrowSearch
from ocp_traj.comparison.report.document import Table
from ocp_traj.comparison.report.statistics import quartiles
from ocp_traj.papers.drawings import (
    best_motion,
    convergence_picture,
    lines_picture,
    motions_picture,
    tool_picture,
)
from ocp_traj.papers.experiments import EQUAL_EVALUATIONS, PUBLISHED_PROTOCOL, Protocol
from ocp_traj.papers.measures import number, order_with_tests
from ocp_traj.papers.motions import PATH_SAMPLES
from ocp_traj.papers.paper import Claim, Paper, table_of
from ocp_traj.papers.records import Records
from ocp_traj.papers.zhang_2022.claims import ADF_SSA, BEST_OF_TEN, SSA, T_SSA, TADF_SSA, claims, durations
from ocp_traj.papers.zhang_2022.inverse_timing import PATH_POINTS, SAVING, inverse_timing, timing_table
from ocp_traj.papers.zhang_2022.tent import BINS, NUMBERS, REPETITIONS, evenness, histograms
from ocp_traj.pictures.motion import path_length, sample_times, tool_path
from ocp_traj.pictures.picture import Picture

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


class Zhang2022(Paper):
    """Shortest clamped cubic spline through Cartesian points of a helix."""

    key = "C"
    name = "Zhang et al. 2022"
    title = "Time-optimal trajectory of a UR5 by unique domains and an improved sparrow search"
    reference = "Zhang et al., Front. Bioeng. Biotechnol. 10 (2022), doi:10.3389/fbioe.2022.852408"
    summary = (
        "A UR5 follows Cartesian points of a helix. Inverse kinematics computes only the branch of the "
        "current unique domain; a clamped cubic spline joins the joint positions, and its durations are "
        "minimised under limits of velocity, acceleration and jerk by a sparrow search with a Tent-chaos "
        "start, adaptive step factors, or both."
    )
    case = "ur5-helix"
    protocol = Protocol(
        methods=(
            (SSA, "ssa[population=100,safety=0.5]"),
            (T_SSA, "t-ssa@paper-t-ssa"),
            (ADF_SSA, "adf-ssa@paper-adf-ssa"),
            (TADF_SSA, "tadf-ssa@paper-tadf-ssa"),
        ),
        population=100,
        generations=80,
        published={label: f"{best} s, best of 10" for label, best in BEST_OF_TEN.items()},
        further=(
            ("SSA, beta scalar", "ssa[population=100,safety=0.5,beta=scalar]"),
            ("TADF-SSA, factors scale, beta scalar", "tadf-ssa@paper-tadf-ssa[factors=scale,beta=scalar]"),
            ("TADF-SSA, n = joiners", "tadf-ssa@paper-tadf-ssa[hungry=scroungers]"),
            ("ADF-SSA, factors scale", "adf-ssa@paper-adf-ssa[factors=scale]"),
            ("TADF-SSA, own extremes", "tadf-ssa@paper-tadf-ssa[tent_range=own-extremes]"),
            ("TADF-SSA, factors scale", "tadf-ssa@paper-tadf-ssa[factors=scale]"),
            ("TADF-SSA, scaled", "tadf-ssa@paper-tadf-ssa[encoding=scaled]"),
            ("PSO", "pso@paper-a"),
            ("CMA-ES, scaled", "cmaes[encoding=scaled]"),
        ),
        curves=((1, "free"), (3, "free")),
    )
    best_of = 10
    stand_ins = (
        "Sample points (Table 2), joint angles (Table 3), limits (Table 4), averages (Table 5) and durations "
        "(Table 6) are lost: height, number of points, orientation and limits are stand-ins, so no duration "
        "of the paper can be met.",
        "Equations 16 to 19 are lost; Tent map with a random kick, cosine annealing of beta (0.2 to 1) and K "
        "= sin(pi (t/T)^2) (0 to 1) are stand-ins that fit the words.",
        "Readings: the Tent numbers are scaled into the box (`own-extremes`, the paper's words, is a further row); "
        "the adaptive factors replace the random ones (`scale` is a further row); i > n/2 counts the whole population "
        "(the number of joiners, the paper's words, is a further row); beta and K of the plain search: beta one number "
        "per coordinate, as in the author's program (one for all is a further row).",
        "The search starts from a population in a box whose upper corner is the paper's initial 50 s.",
    )

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        columns = durations(self, records)
        ordered, _, tests = order_with_tests(columns)
        medians = ", ".join(f"{label} {number(quartiles(columns[label])[1])} s" for label in ordered)
        gradient = records.values("IPOPT", "duration", EQUAL_EVALUATIONS)
        seconds = records.raw("IPOPT", "seconds", EQUAL_EVALUATIONS)
        timing = inverse_timing(self.task(), records)
        best = min(float(np.min(column)) for column in columns.values())
        return [
            f"With C's population and generations, median durations, best first: {medians} ({tests}).",
            f"The best of all these runs is {number(best)} s; IPOPT finds {number(float(gradient[0]))} s on the same "
            f"curve and limits in {float(seconds[0]):.2f} s of computing.",
            "Unique domains save "
            + ", ".join(
                f"{100 * row['saving']:.1f} % ({row['form']}, {row['points']} points)" for row in timing
            )
            + f" of the inverse kinematics' time; the paper reports {100 * SAVING:.2f} %.",
        ]

    def tables(self, records: Records) -> list[Table]:
        """Return the timings of inverse kinematics and the evenness of the random numbers."""
        return [
            timing_table(inverse_timing(self.task(), records)),
            table_of(
                "Tent chaos against pseudo-random numbers",
                (f"{NUMBERS} numbers, chi-square over {BINS} bins", "5 %", "median", "95 %", "the draw of Fig. 1"),
                [
                    (name, *(f"{q:.1f}" for q in np.quantile(found, [0.05, 0.5, 0.95])), f"{histograms()[name][1]:.1f}")
                    for name, found in evenness().items()
                ],
                f"Quantiles of {REPETITIONS} repetitions. Independent uniform numbers give about {BINS - 1}; more is "
                "less even.",
            ),
        ]

    def claims(self, records: Records) -> list[Claim]:
        """Return the paper's claims."""
        return claims(self, records)

    def figures(self, records: Records) -> list[Picture | str]:
        """Return chaos, step factors, timings, convergence, and the best motion with its tool path."""
        return [
            _tent_picture(),
            _factors_picture(self.protocol.generations),
            "Fig. 3 and 4, flow chart and the robot's photograph: not regenerated, drawings, not results.",
            _timing_picture(inverse_timing(self.task(), records)),
            convergence_picture(
                records,
                self.protocol.labels,
                PUBLISHED_PROTOCOL,
                "Fig. 7",
                "Duration over evaluations, median and quartiles (a curve starts where half of the runs are "
                "feasible).",
                "s",
            ),
            *_motion_pictures(self.task(), records),
        ]


def _tent_picture() -> Picture:
    counts = {name: np.append(values, values[-1]) for name, (values, _) in histograms().items()}
    caption = f"How {NUMBERS} Tent and pseudo-random numbers fall into {BINS} equal bins."
    edges = np.linspace(0.0, 1.0, BINS + 1)
    return lines_picture("tent", "Fig. 1", caption, ("number", "numbers in the bin"), edges, counts, step=True)


def _factors_picture(count: int) -> Picture:
    search, generations = TentSparrowSearch(), np.arange(count + 1)
    factors = {
        "beta": [search.find_beta(t / count) for t in generations],
        "K": [search.find_scout_factor(t / count) for t in generations],
    }
    caption = "Step factors over generations (stand-ins: equations lost)."
    return lines_picture("factors", "Fig. 2", caption, ("generation", "factor"), generations, factors)


def _timing_picture(timing: list[dict[str, Any]]) -> Picture:
    python = next(row for row in timing if row["form"] == "python" and row["points"] == PATH_POINTS[0])
    times = {
        "eight branches": 1e3 * np.array(python["eight"]),
        "one domain": 1e3 * np.array(python["one"]),
    }
    repetitions = np.arange(1, len(python["eight"]) + 1)
    caption = "Ten timings of both inverse solutions, plain Python."
    return lines_picture("inverse", "Fig. 6", caption, ("repetition", "time, ms"), repetitions, times)


def _motion_pictures(task: TrajectoryTask, records: Records) -> list[Picture]:
    motion = best_motion(task, records.runs(TADF_SSA, PUBLISHED_PROTOCOL), "duration")
    if motion is None:
        return []
    caption = "Position, velocity, acceleration and jerk of TADF-SSA's best motion."
    length = path_length(tool_path(task, motion, sample_times(motion, PATH_SAMPLES)))
    words = f"Path of the tool, {length:.3f} m, and its x, y, z over time."
    return [
        motions_picture(task, {TADF_SSA: motion}, "Fig. 8", caption),
        tool_picture(task, motion, "Fig. 5, 9 and 10", words),
    ]
