"""Paper C: clamped cubic spline of a UR5 along a helix, Tent chaos and adaptive step factors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from metaheuristics.chaos import draw_tent, measure_uniformity
from ocp_traj.papers.experiments import better_curves, equal_evaluations
from ocp_traj.papers.measures import claim_order, number, order_with_tests, quartiles, spread_of
from ocp_traj.papers.paper import (
    EQUAL_EVALUATIONS,
    PUBLISHED_PROTOCOL,
    Claim,
    Experiment,
    Figure,
    Paper,
    Table,
    generations_budget,
)
from ocp_traj.papers.records import Records

SSA, T_SSA, ADF_SSA, TADF_SSA = "SSA", "T-SSA", "ADF-SSA", "TADF-SSA"
OWN = (
    (SSA, "ssa[population=100,safety=0.5]"),
    (T_SSA, "t-ssa@paper-t-ssa"),
    (ADF_SSA, "adf-ssa@paper-adf-ssa"),
    (TADF_SSA, "tadf-ssa@paper-tadf-ssa"),
)
BEST_OF_TEN = {SSA: 10.83, T_SSA: 12.07, ADF_SSA: 9.85, TADF_SSA: 8.99}
FINAL, INITIAL, SAVING = 8.6618, 50.0, 0.3976
POPULATION, GENERATIONS = 100, 80
NUMBERS, BINS = 1000, 10
PATH_POINTS = (9, 90, 900)


class PaperC(Paper):
    """Shortest clamped cubic spline through Cartesian points of a helix."""

    key = "C"
    title = "Time-optimal trajectory of a UR5 by unique domains and an improved sparrow search"
    reference = "Zhang et al., Front. Bioeng. Biotechnol. 10 (2022), doi:10.3389/fbioe.2022.852408"
    summary = (
        "A UR5 follows Cartesian points of a helix. Inverse kinematics computes only the branch of the current "
        "unique "
        "domain; a clamped cubic spline joins the joint positions, and its durations are minimised under limits of "
        "velocity, acceleration and jerk by a sparrow search with a Tent-chaos start, adaptive step factors, or both."
    )
    case = "ur5-helix"
    runs = 10
    stand_ins = (
        "Sample points (Table 2), joint angles (Table 3), limits (Table 4), averages (Table 5) and durations "
        "(Table 6) are "
        "lost: height, number of points, orientation and limits are stand-ins, so no duration of the paper can "
        "be met.",
        "Equations 16 to 19 are lost; Tent map with a random kick, cosine annealing of beta (0.2 to 1) and K = "
        "sin(pi "
        "(t/T)^2) (0 to 1) are stand-ins that fit the words.",
        "Readings: the Tent numbers are scaled into the box (`own-extremes`, the paper's words, is a further "
        "row); the "
        "adaptive factors replace the random ones (`scale` is a further row).",
        "The search starts from a population in a box whose upper corner is the paper's initial 50 s.",
    )

    def experiments(self, reduced: bool) -> list[Experiment]:
        """Return C's four methods (n = 100, T = 80, ST = 0.5), then equal evaluations."""
        generations = 2 if reduced else GENERATIONS
        methods = (
            *OWN,
            ("TADF-SSA, own extremes", "tadf-ssa@paper-tadf-ssa[tent_range=own-extremes]"),
            ("TADF-SSA, factors scale", "tadf-ssa@paper-tadf-ssa[factors=scale]"),
            ("TADF-SSA, scaled", "tadf-ssa@paper-tadf-ssa[encoding=scaled]"),
            ("SSA, debiased", "ssa-debiased[population=100]"),
            ("PSO", "pso@paper-a"),
            ("PSO, constriction", "pso-constriction"),
            ("DE", "de"),
            ("CMA-ES", "cmaes"),
            ("CMA-ES, scaled", "cmaes[encoding=scaled]"),
            ("random search", "random"),
        )
        return [
            *(
                Experiment(
                    PUBLISHED_PROTOCOL,
                    label,
                    solver,
                    generations_budget(solver, generations),
                    published=f"{BEST_OF_TEN[label]} s, best of 10",
                )
                for label, solver in OWN
            ),
            *equal_evaluations(methods, POPULATION * GENERATIONS, reduced),
            *(() if reduced else better_curves(((1, "free"), (3, "free")))),
        ]

    def story(self, records: Records) -> list[str]:
        """Return what came out."""
        columns = self._durations(records)
        ordered, _, tests = order_with_tests(columns)
        medians = ", ".join(f"{label} {number(quartiles(columns[label])[1])} s" for label in ordered)
        gradient = records.values("IPOPT", "duration", EQUAL_EVALUATIONS)
        seconds = records.raw("IPOPT", "seconds", EQUAL_EVALUATIONS)
        timing = self._timing(records)
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

    @staticmethod
    def _durations(records: Records) -> dict[str, Any]:
        return {label: records.values(label, "duration", PUBLISHED_PROTOCOL) for label, _ in OWN}

    def _timing(self, records: Records) -> list[dict[str, Any]]:
        """Return the times of both inverse solutions by form and number of points, measured once."""
        from ocp_traj.case import task_digest

        task = self.task()
        found = records.computed("inverse kinematics", lambda: {"rows": _time_paths(task)}, task_digest(task))
        return [
            {
                **row,
                "best_eight": min(row["eight"]),
                "best_one": min(row["one"]),
                "saving": 1 - min(row["one"]) / min(row["eight"]),
            }
            for row in found["rows"]
        ]

    def tables(self, records: Records) -> list[Table]:
        """Return the timings of inverse kinematics and the evenness of the random numbers."""
        timing = [
            (
                row["form"],
                f"{row['points']}",
                f"{1e3 * row['best_eight']:.3f} ({1e3 * quartiles(np.array(row['eight']))[1]:.3f})",
                f"{1e3 * row['best_one']:.3f} ({1e3 * quartiles(np.array(row['one']))[1]:.3f})",
                f"{100 * row['saving']:.1f} %",
            )
            for row in self._timing(records)
        ]
        evenness = [(name, f"{value:.1f}") for name, (_, value) in _histograms().items()]
        return [
            Table(
                "Eight branches against one",
                ("form", "points", "eight branches and filter, ms", "one domain, ms", "saved"),
                (("paper, MATLAB", "lost", "2.6149", "1.5752", f"{100 * SAVING:.2f} %"), *timing),
                "Least (median) of ten repetitions each; the least is disturbed least by what else the machine "
                "does, and the share saved is taken from it. The paper prints means of ten.",
            ),
            Table(
                "Tent chaos against pseudo-random numbers",
                (f"{NUMBERS} numbers", f"chi-square over {BINS} bins"),
                tuple(evenness),
                f"Independent uniform numbers give about {BINS - 1}; more is less even.",
            ),
        ]

    def claims(self, records: Records) -> list[Claim]:
        """Return C's claims."""
        columns = self._durations(records)
        generations = {label: records.raw(label, "generations", PUBLISHED_PROTOCOL) for label, _ in OWN}
        order = (TADF_SSA, ADF_SSA, SSA, T_SSA)
        faster = (TADF_SSA, ADF_SSA, T_SSA, SSA)
        best = "; ".join(f"{label} {number(float(columns[label][: self.runs].min()))} s" for label in columns)
        return [
            claim_order(
                "durations: TADF-SSA < ADF-SSA < SSA < T-SSA (8.99, 9.85, 10.83, 12.07 s)",
                "Fig. 7",
                {label: columns[label] for label in order},
                "s",
            ),
            Claim("best of ten runs 10.83, 12.07, 9.85, 8.99 s", "Fig. 7", best, "another case (stand-in)"),
            claim_order(
                "generations to convergence: TADF-SSA 18 < ADF-SSA 23 < T-SSA 34 < SSA 46",
                "Fig. 7",
                {label: generations[label] for label in faster},
                "generations",
            ),
            claim_order(
                "Tent chaos alone makes the result worse",
                "Fig. 7",
                {SSA: columns[SSA], T_SSA: columns[T_SSA]},
                "s",
            ),
            claim_order(
                "the adaptive factor alone improves",
                "section 5",
                {ADF_SSA: columns[ADF_SSA], SSA: columns[SSA]},
                "s",
            ),
            Claim(
                "the averages of ten runs float around the best results: stable",
                "Table 5 (lost), text",
                "medians and quartiles: "
                + "; ".join(f"{label} {spread_of(columns[label])} s" for label in columns)
                + f"; bests of ten: {best}",
                "no number to compare with",
            ),
            Claim(
                f"final {FINAL} s, the mean of five runs",
                "section 5",
                f"the best of ten runs of the same method is {BEST_OF_TEN[TADF_SSA]} s: a mean of five cannot be "
                "below it "
                "unless the runs are others",
                "contradiction inside the paper",
            ),
            Claim(
                f"82.68 % shorter than the initial {INITIAL:.0f} s",
                "section 5",
                f"printed numbers: {100 * (1 - FINAL / INITIAL):.2f} %; our TADF-SSA, median: "
                f"{100 * (1 - quartiles(columns[TADF_SSA])[1] / INITIAL):.2f} %",
                "arithmetic holds; the share measures the start",
            ),
            *self._timing_claims(records),
            *self._curve_claims(records),
            _evenness_claim(),
        ]

    def _timing_claims(self, records: Records) -> list[Claim]:
        rows = self._timing(records)
        plain = [row for row in rows if row["form"] == "python"]
        shares = ", ".join(f"{row['points']} points {100 * row['saving']:.1f} %" for row in plain)
        saved = [(row["points"], row["best_eight"] - row["best_one"]) for row in plain]
        absolute = ", ".join(f"{points} points {1e3 * value:.2f} ms" for points, value in saved)
        linear = saved[-1][1] / saved[0][1] / (saved[-1][0] / saved[0][0])
        return [
            Claim(
                "unique domains save 39.76 % of the inverse kinematics' time",
                "Fig. 6",
                "; ".join(
                    f"{row['form']}, {row['points']} points: {100 * row['saving']:.1f} %" for row in rows
                ),
                "holds: at least that"
                if all(row["saving"] >= SAVING for row in rows)
                else "depends on the form",
            ),
            Claim(
                "the saved proportion increases linearly with the number of points",
                "section 5",
                f"proportions: {shares}; saved times: {absolute}",
                "does not hold for the proportion; the saved time grows with the points, "
                f"at {linear:.2f} of the linear rate",
            ),
        ]

    def _curve_claims(self, records: Records) -> list[Claim]:
        rows = [row for label, _ in OWN for row in records.runs(label, PUBLISHED_PROTOCOL)]
        kept = sum(row["feasible"] for row in rows)
        return [
            Claim(
                "velocity, acceleration and jerk stay below their limits",
                "Fig. 8",
                f"{kept} of {len(rows)} runs keep every limit at every time",
                "holds" if kept == len(rows) else "does not hold for every run",
            ),
            Claim(
                "joint 6 does not move",
                "section 5",
                f"largest travel of joint 6 between the waypoints: {np.ptp(self.task().waypoints[:, 5]):.1e} rad",
                "holds" if np.ptp(self.task().waypoints[:, 5]) < 1e-6 else "does not hold",
            ),
        ]

    def figures(self, records: Records, folder: Path) -> list[Figure]:
        """Draw C's figures."""
        from ocp_traj.papers.figures import (
            best_motion,
            convergence_figure,
            lines_figure,
            motion_figure,
            tool_path_figure,
        )

        counts = {name: values for name, (values, _) in _histograms().items()}
        share, factors = _step_factors()
        python = next(
            row
            for row in self._timing(records)
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
                    [label for label, _ in OWN],
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


def _histograms() -> dict[str, tuple[Any, float]]:
    rng = np.random.default_rng(0)
    tent = draw_tent(1, NUMBERS, rng)[0]
    return {
        "Tent chaos": measure_uniformity(tent, BINS),
        "pseudo-random": measure_uniformity(rng.random(NUMBERS), BINS),
    }


def _evenness_claim() -> Claim:
    rng = np.random.default_rng(1)
    tent = np.array([measure_uniformity(draw_tent(1, NUMBERS, rng)[0], BINS)[1] for _ in range(200)])
    plain = np.array([measure_uniformity(rng.random(NUMBERS), BINS)[1] for _ in range(200)])
    return claim_order(
        "Tent chaos fills the bins more evenly than pseudo-random numbers (chi-square, 200 repetitions)",
        "Fig. 1",
        {"Tent chaos": tent, "pseudo-random": plain},
        "",
    )


def _step_factors() -> tuple[Any, dict[str, Any]]:
    from metaheuristics.improved_tent import TentSparrowSearch

    search = TentSparrowSearch()
    generations = np.arange(GENERATIONS + 1)
    return generations, {
        "beta": np.array([search.find_beta(t / GENERATIONS) for t in generations]),
        "K": np.array([search.find_scout_factor(t / GENERATIONS) for t in generations]),
    }


def _time_paths(task: Any) -> list[dict[str, Any]]:
    """Time both inverse solutions along the helix with more and more points."""
    from ocp_traj.robot.inverse_kinematics.domain_timing import measure_domain_timing
    from ocp_traj.transcription import initial_guess

    motion = initial_guess(task)
    rows = []
    for points in PATH_POINTS:
        positions = motion(np.linspace(0.0, motion.duration, points))
        poses = np.stack([task.robot.pose(q) for q in positions])
        for form in ("python", "vectorised"):
            timing = measure_domain_timing(
                task.robot, poses, positions[0], [6.0, 5.0, 4.0, 3.0, 2.0, 1.0], form
            )
            rows.append(
                {
                    "form": form,
                    "points": points,
                    "eight": timing.eight_branches.tolist(),
                    "one": timing.one_domain.tolist(),
                }
            )
    return rows
