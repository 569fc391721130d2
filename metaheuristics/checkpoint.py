"""Runs on disk: everything needed to go on exactly where a run was, in one npz file without pickle."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from metaheuristics.optimizer import Optimizer, State
from metaheuristics.problem import Problem
from metaheuristics.recorder import Recorder

FORMAT = 1


@dataclass(frozen=True)
class Checkpoint:
    """Where and how often a run is written down.

    Parameters
    ----------
    path
        The npz file. If it exists, the run goes on from it; otherwise it starts.
    every
        Generations between two writings.

    Raises
    ------
    ValueError
        If `every` is below 1.
    """

    path: Path
    every: int = 20

    def __init__(self, path: Path | str, every: int = 20) -> None:
        if every < 1:
            raise ValueError(f"A checkpoint every {every} generations was asked for, expected at least 1.")
        object.__setattr__(self, "path", Path(path))
        object.__setattr__(self, "every", every)


@dataclass(eq=False)
class Snapshot:
    """What a checkpoint holds: the state of the search, its book-keeping and the time already spent."""

    state: State
    recorder: Recorder
    seconds: float


def save(path: Path, snapshot: Snapshot, rng: np.random.Generator, digest: str) -> None:
    """Write a run to a file, replacing the old one in a single step.

    Parameters
    ----------
    path
        The npz file.
    snapshot
        The run at the end of a generation.
    rng
        Its generator, whose state is stored.
    digest
        Of problem and settings, from `make_digest`.
    """
    arrays: dict[str, Any] = {f"recorder.{key}": value for key, value in snapshot.recorder.pack().items()}
    scalars = _pack(snapshot.state, "state", arrays)
    header = {
        "format": FORMAT,
        "digest": digest,
        "seconds": snapshot.seconds,
        "generator": _to_json(rng.bit_generator.state),
        "scalars": scalars,
    }
    temporary = path.with_name(path.name + ".partial")
    with temporary.open("wb") as stream:
        np.savez(stream, header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **arrays)
    os.replace(temporary, path)


def load(path: Path, template: State, rng: np.random.Generator, digest: str) -> Snapshot:
    """Read a run, and put its generator into the state it had.

    Parameters
    ----------
    path
        The npz file.
    template
        A fresh state of the same optimiser on the same problem; its structure guides the reading.
    rng
        Generator of the same kind; its state is overwritten.
    digest
        Of problem and settings, from `make_digest`.

    Raises
    ------
    ValueError
        If the file belongs to another problem, other settings or another kind of generator.
    """
    with np.load(path, allow_pickle=False) as stored:
        arrays = {key: stored[key] for key in stored.files}
    header = json.loads(arrays.pop("header").tobytes().decode())
    if header["format"] != FORMAT or header["digest"] != digest:
        raise ValueError(
            f"The checkpoint {path} belongs to another problem, optimiser or constraint handling."
        )
    generator = header["generator"]
    if generator["bit_generator"] != rng.bit_generator.state["bit_generator"]:
        raise ValueError(
            f"The checkpoint {path} was made with {generator['bit_generator']}, "
            f"given is {rng.bit_generator.state['bit_generator']}."
        )
    rng.bit_generator.state = generator
    recorder = {
        key[len("recorder.") :]: value for key, value in arrays.items() if key.startswith("recorder.")
    }
    state = _unpack(template, "state", arrays, header["scalars"])
    return Snapshot(state, Recorder.unpack(recorder), float(header["seconds"]))


def make_digest(problem: Problem, optimizer: Optimizer[Any], ordering: object) -> str:
    """Return a fingerprint of the problem's name and box, the settings and the constraint rule."""
    content = hashlib.sha256(f"{problem.name}|{optimizer!r}|{ordering!r}".encode())
    content.update(problem.lower.tobytes())
    content.update(problem.upper.tobytes())
    return content.hexdigest()


def _pack(value: Any, prefix: str, arrays: dict[str, Any]) -> dict[str, Any]:
    """Return the scalars of nested members by dotted name, and add the arrays to `arrays`."""
    scalars: dict[str, Any] = {}
    members = (
        value
        if isinstance(value, dict)
        else {entry.name: getattr(value, entry.name) for entry in fields(value)}
    )
    for key, item in members.items():
        name = f"{prefix}.{key}"
        if is_dataclass(item) or isinstance(item, dict):
            scalars.update(_pack(item, name, arrays))
        elif isinstance(item, np.ndarray):
            arrays[name] = item
        elif isinstance(item, np.generic):
            scalars[name] = item.item()
        elif item is None or isinstance(item, (bool, int, float, str)):
            scalars[name] = item
        else:
            raise TypeError(f"{name} is a {type(item).__name__}: this optimiser cannot be checkpointed.")
    return scalars


def _unpack(template: Any, prefix: str, arrays: dict[str, Any], scalars: dict[str, Any]) -> Any:
    """Return the template, a dataclass or a flat dictionary, with all its members read back."""
    if isinstance(template, dict):
        members = {name[len(prefix) + 1 :] for name in (*arrays, *scalars) if name.startswith(prefix + ".")}
    else:
        members = {entry.name for entry in fields(template)}
    changes: dict[str, Any] = {}
    for key in members:
        name = f"{prefix}.{key}"
        if name in arrays:
            changes[key] = arrays[name]
        elif name in scalars:
            changes[key] = scalars[name]
        else:
            changes[key] = _unpack(getattr(template, key), name, arrays, scalars)
    return changes if isinstance(template, dict) else replace(template, **changes)


def _to_json(value: Any) -> Any:
    """Return a generator's state with its arrays as lists."""
    if isinstance(value, dict):
        return {key: _to_json(item) for key, item in value.items()}
    return value.tolist() if isinstance(value, np.ndarray) else value
