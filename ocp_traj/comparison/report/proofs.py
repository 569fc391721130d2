"""Proofs of a comparison's best motions, in ``DIR/proofs``: made on request, marked in the report where they hold."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from ocp_traj.case import task_from_json
from ocp_traj.comparison.report.judging import Judgement, judge
from ocp_traj.comparison.runs.store import Store, StoredRun
from ocp_traj.exceptions import InputError, OcpTrajError
from ocp_traj.proofs import NotAProof, Refused, check_file, prove, write_proof
from ocp_traj.proofs.resolve import hexadecimal
from ocp_traj.trajectory_files import from_json


def prove_best(folder: Path) -> list[str]:
    """Prove the best motion of every solver on every problem of the newest plan; return why some are not proved.

    What is proved already is kept.

    Parameters
    ----------
    folder : pathlib.Path
        A comparison.

    Raises
    ------
    InputError
        The folder holds no comparison, or cannot be written.
    """
    reasons = []
    with Store(folder) as store:
        wanted = store.problems()
        rows = [row for row in store.rows() if (row.case_digest, row.settings_digest) in wanted]
        done = proved_runs(store, judgement := judge(rows, store.cases()))
        for label, row in _best(judgement):
            if row.trajectory_file in done:
                continue
            try:
                _prove(store, row)
            except OcpTrajError as reason:
                reasons.append(f"{label}: not proved: {reason}")
    return reasons


def _best(judgement: Judgement) -> Iterator[tuple[str, StoredRun]]:
    for problem in judgement.problems:
        for solver in judgement.solvers:
            group = judgement.group(problem, solver)
            if group is not None and group.best is not None:
                yield f"{problem.label}, {solver}", group.best


def _prove(store: Store, row: StoredRun) -> None:
    curve = store.trajectory(row)
    if curve is None or curve.get("task") is None:
        raise InputError("the stored motion carries no task")
    task = task_from_json(curve["task"], str(row.trajectory_file))
    document = prove(task, from_json(curve, str(row.trajectory_file)))
    path = _proof_path(store, row)
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{path.parent} cannot be made: {error.strerror or error}") from None
    write_proof(document, path)


def _proof_path(store: Store, row: StoredRun) -> Path:
    name = str(row.trajectory_file).removesuffix(".spline.json")
    return store.folder / "proofs" / f"{name}.proof.json"


def proved_runs(store: Store, judgement: Judgement) -> frozenset[str]:
    """Return the trajectory files of the best runs with a proof that holds and is about that very curve."""
    return frozenset(str(row.trajectory_file) for _, row in _best(judgement) if _holds(store, row))


def _holds(store: Store, row: StoredRun) -> bool:
    path = _proof_path(store, row)
    if not path.is_file():
        return False
    try:
        if check_file(str(path)).kind != "motion":
            return False
        motion, curve = json.loads(path.read_text(encoding="utf-8"))["motion"], store.trajectory(row) or {}
        return all(motion[key] == hexadecimal(curve[key]) for key in ("breakpoints", "coefficients"))
    except (NotAProof, Refused, InputError, OSError, KeyError):  # damaged, or another one's
        return False
