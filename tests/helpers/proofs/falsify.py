"""Ways to make the statement of a proof false, each a function (document, rng) that changes the document."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np

Change = Callable[[dict[str, Any], np.random.Generator], None]


def moved(text: str, by: float = 1e-5) -> str:
    """Return a number moved by a fraction of itself, or by that much if it is zero."""
    value = float.fromhex(text)
    return (value * (1.0 + by) if value else by).hex()


def scaled(rows: Any, factor: float) -> Any:
    """Return nested numbers times a factor."""
    return [scaled(row, factor) for row in rows] if isinstance(rows, list) else (float.fromhex(rows) * factor).hex()


def pick(document: dict[str, Any], rng: np.random.Generator) -> tuple[Any, int, int]:
    """Return the coefficients, a piece and a joint."""
    curve = document["motion"]["coefficients"]
    return curve, int(rng.integers(len(curve))), int(rng.integers(len(curve[0])))


def _coefficient(document: dict[str, Any], rng: np.random.Generator) -> None:
    curve, k, j = pick(document, rng)
    i = int(rng.integers(len(curve[k][j])))
    curve[k][j][i] = moved(curve[k][j][i], 10 ** rng.uniform(-6, -1))


def _breakpoint(document: dict[str, Any], rng: np.random.Generator) -> None:
    times = document["motion"]["breakpoints"]
    k = int(rng.integers(1, len(times)))
    if times[k] in document["motion"]["waypoint_times"]:
        passing = document["motion"]["waypoint_times"]
        passing[passing.index(times[k])] = moved(times[k])
    times[k] = moved(times[k])


def _passing(document: dict[str, Any], rng: np.random.Generator) -> None:
    times = document["motion"]["waypoint_times"]
    k = int(rng.integers(1, len(times)))
    times[k] = moved(times[k])


def _waypoint(document: dict[str, Any], rng: np.random.Generator) -> None:
    rows = document["task"]["waypoints"]
    w, j = int(rng.integers(len(rows))), int(rng.integers(len(rows[0])))
    rows[w][j] = moved(rows[w][j], 10 ** rng.uniform(-6, -2))


def _tolerance(document: dict[str, Any], rng: np.random.Generator) -> None:
    """Move a waypoint by more than the box that is put around it."""
    w = int(rng.integers(len(document["task"]["waypoints"])))
    point = document["task"]["waypoints"][w]
    document["task"]["tolerance"][w] = [(1e-3).hex()] * len(point)
    point[0] = (float.fromhex(point[0]) + 1.001e-3).hex()


def _swapped_pieces(document: dict[str, Any], rng: np.random.Generator) -> None:
    curve, k, _ = pick(document, rng)
    curve[k], curve[k - 1] = curve[k - 1], curve[k]


def _swapped_joints(document: dict[str, Any], rng: np.random.Generator) -> None:
    curve, k, j = pick(document, rng)
    curve[k][j], curve[k][j - 1] = curve[k][j - 1], curve[k][j]


def _split(document: dict[str, Any], k: int, before: float, change: Callable[[Any], None]) -> None:
    """Insert a short piece that ends where piece k begins, with changed coefficients."""
    motion = document["motion"]
    start = float.fromhex(motion["breakpoints"][k])
    motion["breakpoints"].insert(k, (start - before).hex())
    extra = copy.deepcopy(motion["coefficients"][k])
    change(extra)
    motion["coefficients"].insert(k, extra)


def _hidden_turn(document: dict[str, Any], rng: np.random.Generator) -> None:
    """Let the velocity jump forth and back within 1e-12 s."""
    _, k, j = pick(document, rng)

    def change(piece: Any) -> None:
        piece[j][1] = (float.fromhex(piece[j][1]) + 1e-5).hex()

    if k:
        _split(document, k, 1e-12, change)


def _many_steps(document: dict[str, Any], rng: np.random.Generator) -> None:
    """Forty pieces of 1e-9 s, each with a position 4e-12 rad away: allowed one by one, not together."""
    _, k, j = pick(document, rng)
    if not k:
        return
    for count in range(40):

        def change(piece: Any, size: float = 4e-12 * (-1) ** count) -> None:
            piece[j][0] = (float.fromhex(piece[j][0]) + size).hex()

        _split(document, k, 1e-9, change)


def _offset(document: dict[str, Any], rng: np.random.Generator) -> None:
    curve, k, j = pick(document, rng)
    curve[k][j][0] = (float.fromhex(curve[k][j][0]) + 1e-9).hex()


def _faster(document: dict[str, Any], rng: np.random.Generator) -> None:
    """Run the whole motion faster by 2e-5; the claim follows."""
    factor = 1.0 - 2e-5
    motion = document["motion"]
    for key in ("breakpoints", "waypoint_times"):
        motion[key] = scaled(motion[key], factor)
    motion["coefficients"] = [
        [[(float.fromhex(x) / factor**i).hex() for i, x in enumerate(c)] for c in piece]
        for piece in motion["coefficients"]
    ]
    length = float.fromhex(motion["breakpoints"][-1]) - float.fromhex(motion["breakpoints"][0])
    document["claim"]["duration"] = np.nextafter(length, np.inf).hex()


def _limit(name: str, least: float = 1e-5) -> Change:
    def change(document: dict[str, Any], rng: np.random.Generator) -> None:
        """Lower the limits of one gap."""
        rows = document["task"]["limits"].get(name)
        if rows is not None:
            g = int(rng.integers(len(rows)))
            rows[g] = scaled(rows[g], 1.0 - 10 ** rng.uniform(np.log10(least), -0.02))

    return change


def _boundary(name: str) -> Change:
    def change(document: dict[str, Any], rng: np.random.Generator) -> None:
        rows = document["task"]["boundary"][name]
        if rows is not None:
            side, j = int(rng.integers(2)), int(rng.integers(len(rows[0])))
            rows[side][j] = (float.fromhex(rows[side][j]) + 1e-3).hex()

    return change


def _robot(key: str, factor: float) -> Change:
    def change(document: dict[str, Any], rng: np.random.Generator) -> None:
        robot = document["task"]["robot"]
        if robot is None:
            return
        if key in robot:
            robot[key] = scaled(robot[key], factor)
        else:
            for link in robot["links"]:
                link[key] = scaled(link[key], factor)

    return change


def _claim(name: str) -> Change:
    def change(document: dict[str, Any], rng: np.random.Generator) -> None:
        costs = document["claim"]["costs"]
        if name == "duration":
            document["claim"]["duration"] = moved(document["claim"]["duration"], -(10 ** rng.uniform(-14, -1)))
        elif name in costs:
            costs[name] = moved(costs[name], -0.2)

    return change


def _bound_of_duration(document: dict[str, Any], rng: np.random.Generator) -> None:
    length = float.fromhex(document["claim"]["duration"])
    document["task"]["duration"] = [(0.0).hex(), (length * (1 - 1e-8)).hex()]


def _bound_of_a_gap(document: dict[str, Any], rng: np.random.Generator) -> None:
    times = [float.fromhex(t) for t in document["motion"]["waypoint_times"]]
    g = int(rng.integers(len(times) - 1))
    document["task"]["gap_durations"][g] = [((times[g + 1] - times[g]) * (1 + 1e-8)).hex(), "inf"]


KINDS: dict[str, Change] = {
    "coefficient": _coefficient,
    "breakpoint": _breakpoint,
    "waypoint time": _passing,
    "waypoint": _waypoint,
    "waypoint with tolerance": _tolerance,
    "pieces swapped": _swapped_pieces,
    "joints swapped": _swapped_joints,
    "hidden turn": _hidden_turn,
    "many steps": _many_steps,
    "piece shifted": _offset,
    "whole motion faster": _faster,
    "position limit": _limit("position", 0.05),
    "velocity limit": _limit("velocity"),
    "acceleration limit": _limit("acceleration"),
    "jerk limit": _limit("jerk", 0.5),
    "torque limit": _limit("torque", 0.3),
    "torque rate limit": _limit("torque_rate", 0.1),
    "start or end velocity": _boundary("velocity"),
    "start or end acceleration": _boundary("acceleration"),
    "masses": _robot("mass", 1.5),
    "first moments": _robot("first", 1.5),
    "second moments": _robot("second", 3.0),
    "armatures": _robot("armature", 30.0),
    "gravity": _robot("gravity", 1.3),
    "viscous friction": _robot("viscous", 30.0),
    "Coulomb friction": _robot("coulomb", 30.0),
    "claimed duration": _claim("duration"),
    "claimed energy": _claim("energy"),
    "claimed jerk cost": _claim("jerk"),
    "claimed acceleration cost": _claim("acceleration"),
    "bound of the duration": _bound_of_duration,
    "bound of a gap": _bound_of_a_gap,
}
"""By what is changed."""
