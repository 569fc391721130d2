"""Which modules are changed, and which tests should notice."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def modules_in(*folders: str) -> list[str]:
    """Return the paths of all modules directly in some folders."""
    found = (path for folder in folders for path in sorted((ROOT / folder).glob("[!_]*.py")))
    return [str(path.relative_to(ROOT)) for path in found]


def tests_in(path: str, names: Iterable[str]) -> list[str]:
    """Return the identities of some tests of one file; `names` are without ``test_``."""
    return [f"{path}::test_{name}" for name in names]


LIFTED_FILES = modules_in("tests/transcription/lifted")
CONDENSED_FILES = [f"tests/transcription/condensed/test_{name}.py" for name in ("rows", "best_speed", "costs")]
LIMITS = "tests/limits/test_custom.py"
AUDIT = modules_in("tests/audit")
EXTRA_POINTS = "points_added_between_samples_have_right_derivatives_too"
SYMBOLS = "the_symbols_give_the_same_values_and_derivatives_as_the_ready_functions"

LIFTED = (
    *(path for path in LIFTED_FILES if not path.endswith("_derivatives.py")),
    LIMITS,
    *tests_in("tests/transcription/lifted/test_lifted_derivatives.py", (EXTRA_POINTS, SYMBOLS)),
)
CONDENSED = (
    *CONDENSED_FILES,
    LIMITS,
    "tests/transcription/condensed/test_extrema.py",
    *tests_in(
        "tests/transcription/condensed/test_condensed.py",
        (
            "waypoints_on_a_position_limit_break_nothing",
            "few_waypoints_agree_with_their_symbols",
            "virtual_knots_and_end_conditions_agree_with_their_symbols",
            "every_limit_is_broken_as_much_as_its_symbols_say[septic-per gap]",
            "a_candidate_is_judged_the_same_in_any_population",
            "evaluations_keep_their_numbers_when_others_follow",
            "all_limits_friction_and_custom_functions_together_agree_with_their_symbols",
            "a_wrong_encoding_or_extrema_is_refused",
        ),
    ),
    *tests_in(
        "tests/transcription/condensed/test_scaling.py",
        (
            "bounds_of_durations_limit_the_scale",
            "gravity_over_a_torque_limit_is_reported_at_any_speed",
            "a_joint_that_must_not_move_is_reported_at_any_speed",
            "what_does_not_scale_is_refused",
            "the_smallest_scale_is_feasible_and_a_smaller_one_is_not",
            "the_total_of_the_durations_does_not_matter",
        ),
    ),
)
ROWS = (*(path for path in LIFTED if "::" not in path), *CONDENSED_FILES)
TASK_MODULES = modules_in("ocp_traj/task") or ["ocp_traj/task.py"]
TASKS = (*modules_in("tests/task"), *ROWS, "tests/case/test_case_errors.py")
CASES = ("tests/case/test_case.py", "tests/case/test_case_errors.py")
ALGORITHMS = "tests/metaheuristics/algorithms"
UPDATE_RULES = f"{ALGORITHMS}/test_update_rules.py"
SPARROWS = [
    *(f"{ALGORITHMS}/test_{name}.py" for name in ("sparrow_search", "improved_sparrow_searches")),
    UPDATE_RULES,
]

AREAS: dict[str, dict[str, tuple[str, ...]]] = {
    "audit": dict.fromkeys(modules_in("ocp_traj/audit"), tuple(AUDIT)),
    "constraints": {
        **dict.fromkeys(modules_in("ocp_traj/transcription/lifted"), LIFTED),
        **dict.fromkeys(modules_in("ocp_traj/transcription/condensed"), CONDENSED),
        **dict.fromkeys(modules_in("ocp_traj/limits"), ROWS),
        "ocp_traj/solvers/gradient/refinement.py": ("tests/solvers/gradient/test_refinement.py",),
        "ocp_traj/transcription/nlp.py": (*CONDENSED_FILES, "tests/transcription/condensed/test_condensed.py"),
        **dict.fromkeys(TASK_MODULES, TASKS),
        "ocp_traj/case/limits.py": CASES,
    },
    "metaheuristics": {
        f"metaheuristics/algorithms/{name}.py": tuple(tests)
        for name, tests in {
            "particle_swarm": [f"{ALGORITHMS}/test_particle_swarm.py", UPDATE_RULES],
            "sparrow_search": SPARROWS,
            "elite_sparrow_search": SPARROWS,
            "levy_sparrow_search": SPARROWS,
            "tent_sparrow_search": SPARROWS,
        }.items()
    },
}
"""For every area its modules, each with the tests that should notice a change."""
