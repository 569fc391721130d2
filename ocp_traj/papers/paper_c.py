"""Paper C: clamped cubic spline of a UR5 along a helix, Tent chaos and adaptive step factors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.papers.experiments import EQUAL_EVALUATIONS, PUBLISHED_PROTOCOL, Protocol
from ocp_traj.papers.inverse_timing import PATH_POINTS, SAVING, inverse_timing, timing_table
from ocp_traj.papers.measures import number, order_with_tests, quartiles
from ocp_traj.papers.paper import Claim, Figure, Paper, Table
from ocp_traj.papers.printed_c import ADF_SSA, BEST_OF_TEN, SSA, T_SSA, TADF_SSA, durations
from ocp_traj.papers.records import Records
from ocp_traj.papers.tent import BINS, NUMBERS, histograms


class PaperC(Paper):
    """Shortest clamped cubic spline through Cartesian points of a helix."""

    key = "C"
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
            ("TADF-SSA, own extremes", "tadf-ssa@paper-tadf-ssa[tent_range=own-extremes]"),
            ("TADF-SSA, factors scale", "tadf-ssa@paper-tadf-ssa[factors=scale]"),
            ("TADF-SSA, scaled", "tadf-ssa@paper-tadf-ssa[encoding=scaled]"),
            ("PSO", "pso@paper-a"),
            ("CMA-ES, scaled", "cmaes[encoding=scaled]"),
        ),
        curves=((1, "free"), (3, "free")),
    )
    runs = 10
    stand_ins = (
        "Sample points (Table 2), joint angles (Table 3), limits (Table 4), averages (Table 5) and durations "
        "(Table 6) are lost: height, number of points, orientation and limits are stand-ins, so no duration "
        "of the paper can be met.",
        "Equations 16 to 19 are lost; Tent map with a random kick, cosine annealing of beta (0.2 to 1) and K "
        "= sin(pi (t/T)^2) (0 to 1) are stand-ins that fit the words.",
        "Readings: the Tent numbers are scaled into the box (`own-extremes`, the paper's words, is a further row); "
        "the adaptive factors replace the random ones (`scale` is a further row); i > n/2 counts the whole population, "
        "where the paper writes the number of joiners.",
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
            Table(
                "Tent chaos against pseudo-random numbers",
                (f"{NUMBERS} numbers", f"chi-square over {BINS} bins"),
                tuple((name, f"{value:.1f}") for name, (_, value) in histograms().items()),
                f"Independent uniform numbers give about {BINS - 1}; more is less even.",
            ),
        ]

    def claims(self, records: Records) -> list[Claim]:
        """Return C's claims."""
        from ocp_traj.papers.claims_c import claims

        return claims(self, records)

    def figures(self, records: Records, folder: Path) -> list[Figure]:
        """Draw C's figures."""
        from ocp_traj.papers.figures import (
            best_motion,
            convergence_figure,
            lines_figure,
            motion_figure,
            tool_path_figure,
        )

        counts = {name: values for name, (values, _) in histograms().items()}
        share, factors = step_factors()
        python = next(
            row
            for row in inverse_timing(self.task(), records)
            if row["form"] == "python" and row["points"] == PATH_POINTS[0]
        )
        times = {
            "eight branches": 1e3 * np.array(python["eight"]),
            "one domain": 1e3 * np.array(python["one"]),
        }
        found = [
            Figure(
                "1",
                f"How {NUMBERS} Tent and pseudo-random numbers fall into {BINS} equal bins.",
                lines_figure(
                    folder / "paper-c-tent.png",
                    np.arange(BINS) / BINS,
                    counts,
                    "lower end of the bin",
                    "numbers",
                    "Paper C, Fig. 1",
                    "bars",
                ),
            ),
            Figure(
                "2",
                "Step factors over generations (stand-ins: equations lost).",
                lines_figure(
                    folder / "paper-c-factors.png", share, factors, "generation", "factor", "Paper C, Fig. 2"
                ),
            ),
            Figure("3 and 4", "flow chart and the robot's photograph", impossible="drawings, not results"),
            Figure(
                "6",
                "Ten timings of both inverse solutions, plain Python.",
                lines_figure(
                    folder / "paper-c-inverse.png",
                    np.arange(1, 11),
                    times,
                    "repetition",
                    "time, ms",
                    "Paper C, Fig. 6",
                ),
            ),
            Figure(
                "7",
                "Duration over evaluations, median and quartiles (a curve starts where half of the runs are "
                "feasible).",
                convergence_figure(
                    records,
                    self.protocol.labels,
                    PUBLISHED_PROTOCOL,
                    folder / "paper-c-convergence.png",
                    "Paper C, Fig. 7",
                    "s",
                ),
            ),
        ]
        task = self.task()
        motion = best_motion(task, records.runs(TADF_SSA, PUBLISHED_PROTOCOL), "duration")
        if motion is None:
            return found
        path, length = tool_path_figure(
            task, motion, folder / "paper-c-tool.png", "Paper C, Figs. 5, 9 and 10"
        )
        name = motion_figure(
            task, {TADF_SSA: motion}, folder / "paper-c-motion.png", "Paper C, Fig. 8, stand-in case"
        )
        return [
            *found,
            Figure("8", "Position, velocity, acceleration and jerk of TADF-SSA's best motion.", name),
            Figure("5, 9 and 10", f"Path of the tool, {length:.3f} m, and its x, y, z over time.", path),
        ]


def step_factors() -> tuple[Any, dict[str, Any]]:
    """Return the generations and both adaptive factors over them."""
    from metaheuristics.algorithms.tent_sparrow_search import TentSparrowSearch

    search = TentSparrowSearch()
    generations = np.arange(PaperC.protocol.generations + 1)
    return generations, {
        "beta": np.array([search.find_beta(t / PaperC.protocol.generations) for t in generations]),
        "K": np.array([search.find_scout_factor(t / PaperC.protocol.generations) for t in generations]),
    }
