"""What is false about a proof, measured without the checker: exact values at instants, torques by NumPy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

INSTANTS = 65
ORDERS = ("position", "velocity", "acceleration", "jerk")


def exact(value: Any) -> Any:
    """Return nested hexadecimal numbers as fractions, infinite ones as floats."""
    if isinstance(value, list):
        return [exact(entry) for entry in value]
    if isinstance(value, dict):
        return {key: exact(entry) for key, entry in value.items()}
    number = float.fromhex(value)
    return number if abs(number) == np.inf else Fraction(number)


def evaluate(c: list[Fraction], t: Fraction, order: int) -> Fraction:
    """Return a derivative at t, term by term."""
    total = Fraction(0)
    for power in range(order, len(c)):
        factor = 1
        for k in range(order):
            factor *= power - k
        total += factor * c[power] * t ** (power - order)
    return total


def falsehood(document: dict[str, Any]) -> str:
    """Return the first statement of a motion proof found false, or an empty string."""
    task, motion = document["task"], document["motion"]
    times, curve, passing = (exact(motion[key]) for key in ("breakpoints", "coefficients", "waypoint_times"))
    if any(a >= b for a, b in zip(times, times[1:])) or any(t not in times for t in passing):
        return "times"
    limits = {name: exact(rows) for name, rows in task["limits"].items()}
    gap_of = [max(g for g, t in enumerate(passing[:-1]) if t <= begin) for begin in times[:-1]]
    found = (
        _misses(task, times, curve, passing)
        or _jumps(limits, times, curve, gap_of)
        or _claims(document, times, curve)
        or _durations(task, times, passing)
        or _peaks(limits, times, curve, gap_of)
    )
    return found or (_torques(document, limits, times, curve, gap_of) if task["robot"] else "")


def _misses(task: dict[str, Any], times: Any, curve: Any, passing: Any) -> str:
    waypoints, tolerance = exact(task["waypoints"]), exact(task["tolerance"])
    for w, t in enumerate(passing):
        k = times.index(t)
        for j, target in enumerate(waypoints[w]):
            sides = [evaluate(curve[k][j], Fraction(0), 0)] if k < len(curve) else []
            sides += [evaluate(curve[k - 1][j], t - times[k - 1], 0)] if k else []
            if any(abs(q - target) - tolerance[w][j] > Fraction(1, 10**8) for q in sides):
                return "waypoint"
    if passing[0] != times[0] or passing[-1] != times[-1]:
        return "ends"
    for order, name in enumerate(ORDERS[1:], 1):
        rows = task["boundary"][name]
        for wanted, piece, t in zip(exact(rows) if rows else [], (0, -1), (Fraction(0), times[-1] - times[-2])):
            limit = exact(task["limits"].get(name, [[["inf"] * len(wanted)] * 2]))[piece]
            for j, value in enumerate(wanted):
                unit = max(abs(side[j]) for side in limit)  # the larger side: false by any reading
                if unit < np.inf and abs(evaluate(curve[piece][j], t, order) - value) > unit * Fraction(1, 10**8):
                    return f"boundary {name}"
    return ""


def _jumps(limits: Any, times: Any, curve: Any, gap_of: Any) -> str:
    allowed = (Fraction(1, 10**10), Fraction(1, 10**9), Fraction(1, 10**7))
    for order in range(3 if {"jerk", "torque_rate"} & set(limits) else 2):
        for j in range(len(curve[0])):
            total = Fraction(0)
            for k in range(len(curve) - 1):
                end = evaluate(curve[k][j], times[k + 1] - times[k], order)
                unit = Fraction(1)
                if order:
                    if ORDERS[order] not in limits:
                        continue
                    unit = max(abs(side[j]) for g in gap_of[k : k + 2] for side in limits[ORDERS[order]][g])
                total += abs(end - evaluate(curve[k + 1][j], Fraction(0), order)) / unit if unit < np.inf else 0
            if total > allowed[order]:
                return f"jumps of {ORDERS[order]}"
    return ""


def _peaks(limits: Any, times: Any, curve: Any, gap_of: Any) -> str:
    slack = 1 + Fraction(1, 10**6)
    for k, piece in enumerate(curve):
        h = times[k + 1] - times[k]
        for order, name in enumerate(ORDERS):
            for j, c in enumerate(piece) if name in limits else ():
                low, up = (side[j] for side in limits[name][gap_of[k]])
                if order == 0:
                    room = (up - low) / 10**6 if up - low < np.inf else Fraction(1, 10**8)
                    low, up = low - room, up + room
                else:
                    low, up = (side * slack if abs(side) < np.inf else side for side in (low, up))
                if any(not low <= evaluate(c, h * i / (INSTANTS - 1), order) <= up for i in range(INSTANTS)):
                    return name
    return ""


def _durations(task: dict[str, Any], times: Any, passing: Any) -> str:
    spans = [(passing[-1] - passing[0], exact(task["duration"]))]
    spans += [(b - a, rows) for a, b, rows in zip(passing, passing[1:], exact(task["gap_durations"]))]
    wide = Fraction(1, 10**9)
    wrong = any(h < low * (1 - wide) or (up < np.inf and h > up * (1 + wide)) for h, (low, up) in spans)
    return "duration" if wrong else ""


def _claims(document: dict[str, Any], times: Any, curve: Any) -> str:
    claim = exact(document["claim"])
    length = times[-1] - times[0]
    if claim["duration"] < length or claim["costs"].get("time", length) < length:
        return "claimed duration"
    for name, order in (("acceleration", 2), ("jerk", 3)):
        total = 0.0
        for k, piece in enumerate(curve):
            h = times[k + 1] - times[k]
            for c in piece:
                squares = [float(evaluate(c, h * i / 64, order)) ** 2 for i in range(65)]
                total += float(h) / 64 * (sum(squares) - 0.5 * (squares[0] + squares[-1]))
        if float(claim["costs"].get(name, np.inf)) < 0.95 * total:
            return f"claimed {name}"
    return ""


def torques(robot: dict[str, Any], q: Any, v: Any, a: Any) -> np.ndarray:
    """Return joint torques from a proof's links, by Newton's and Euler's laws in root axes."""
    links = robot["links"]
    keys = ("rotation", "translation", "mass", "first", "second", "armature")
    number = {key: [np.array(_floats(link[key])) for link in links] for key in keys}
    n, still = len(links), np.zeros(3)
    root = (np.eye(3), still, still, still, -np.array(_floats(robot["gravity"])))
    frames: list[Any] = []
    for i, link in enumerate(links):
        p = link["parent"] - 1
        rotation, origin, w, dw, acceleration = frames[p] if p >= 0 else root
        turned = rotation @ number["rotation"][i]
        lever = rotation @ number["translation"][i]
        axis = turned[:, 2]
        if link["prismatic"]:
            lever = lever + axis * q[i]
        base = acceleration + np.cross(dw, lever) + np.cross(w, np.cross(w, lever))
        if link["prismatic"]:
            base = base + 2 * np.cross(w, axis * v[i]) + axis * a[i]
        else:
            c, s = np.cos(q[i]), np.sin(q[i])
            turned = turned @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
            dw = dw + axis * a[i] + np.cross(w, axis * v[i])
            w = w + axis * v[i]
        frames.append((turned, origin + lever, w, dw, base))
    force, moment = np.zeros((n, 3)), np.zeros((n, 3))
    out = np.zeros(n)
    for i in reversed(range(n)):
        turned, origin, w, dw, base = frames[i]
        first, second = turned @ number["first"][i], turned @ number["second"][i] @ turned.T
        inertia = np.trace(second) * np.eye(3) - second
        force[i] += number["mass"][i] * base + np.cross(dw, first) + np.cross(w, np.cross(w, first))
        moment[i] += np.cross(first, base) + inertia @ dw + np.cross(w, inertia @ w)
        axis = turned[:, 2]
        out[i] = axis @ (force[i] if links[i]["prismatic"] else moment[i]) + number["armature"][i] * a[i]
        p = links[i]["parent"] - 1
        if p >= 0:
            force[p] += force[i]
            moment[p] += moment[i] + np.cross(origin - frames[p][1], force[i])
    return out + np.array(_floats(robot["viscous"])) * v


def _floats(value: Any) -> Any:
    return [_floats(entry) for entry in value] if isinstance(value, list) else float.fromhex(value)


def _torques(document: dict[str, Any], limits: Any, times: Any, curve: Any, gap_of: Any) -> str:
    """Torques (with friction) and rates (by differences) beyond limits, an energy above its claim."""
    robot, costs = document["task"]["robot"], exact(document["claim"]["costs"])
    coulomb = np.array(_floats(robot["coulomb"]))
    energy = 0.0
    for k, piece in enumerate(curve):
        h = times[k + 1] - times[k]
        grid = [h * i / 40 for i in range(41)]
        states = [[np.array([float(evaluate(c, t, order)) for c in piece]) for t in grid] for order in range(3)]
        smooth = np.array([torques(robot, *state) for state in zip(*states)])
        moving = np.array(states[1])
        total = smooth + coulomb * np.sign(moving)
        for name, values in (("torque", total), ("torque_rate", np.diff(smooth, axis=0) / (float(h) / 40))):
            if name in limits:
                low, up = np.array(limits[name][gap_of[k]], dtype=float)
                if (values > up * (1 + 1.5e-6)).any() or (values < low * (1 + 1.5e-6)).any():
                    return name
        weights = np.full(41, float(h) / 40)
        weights[[0, -1]] *= 0.5
        energy += float((weights[:, None] * np.abs(total * moving)).sum())
    return "claimed energy" if float(costs.get("energy", np.inf)) < energy * 0.95 else ""
