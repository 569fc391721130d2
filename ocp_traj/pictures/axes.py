"""Ranges and ticks of axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array


@dataclass(frozen=True)
class Axis:
    """Maps data to [0, 1], linearly or by the logarithm."""

    lower: float
    upper: float
    log: bool = False

    def place(self, values: Array) -> Array:
        """Return where values lie, 0 at the lower end and 1 at the upper one."""
        if self.log:
            low, high = math.log10(self.lower), math.log10(self.upper)
            return np.asarray((np.log10(np.maximum(values, self.lower * 1e-3)) - low) / (high - low))
        return np.asarray((values - self.lower) / (self.upper - self.lower))

    def ticks(self, count: int = 5) -> list[tuple[float, str]]:
        """Return tick values with their labels."""
        if self.log:
            return _log_ticks(self.lower, self.upper, count)
        return _linear_ticks(self.lower, self.upper, count)


def fit_axis(values: Sequence[Array], log: bool = False, margin: float = 0.04) -> Axis:
    """Return an axis that holds all finite (and for logarithms positive) values."""
    joined = np.concatenate([np.ravel(entry) for entry in values]) if values else np.empty(0)
    usable = joined[np.isfinite(joined) & ((joined > 0) | (not log))]
    if usable.size == 0:
        return Axis(0.1, 10.0, True) if log else Axis(0.0, 1.0)
    low, high = float(usable.min()), float(usable.max())
    if log:
        ratio = max(high / low, 1.5) ** margin
        middle = math.sqrt(low * high)
        low, high = min(low, middle / 1.25), max(high, middle * 1.25)
        return Axis(low / ratio, high * ratio, True)
    spread = high - low
    if spread <= 1e-9 * max(abs(low), abs(high)):
        spread = max(abs(high), 1.0)
        low, high = low - spread / 2, high + spread / 2
        spread = high - low
    return Axis(low - margin * spread, high + margin * spread)


def _linear_ticks(lower: float, upper: float, count: int) -> list[tuple[float, str]]:
    raw = (upper - lower) / count
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * power for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * power >= raw * 0.75)
    first = math.ceil(lower / step - 1e-9)
    last = math.floor(upper / step + 1e-9)
    return [(number * step, format_tick(number * step, step)) for number in range(first, last + 1)]


def format_tick(value: float, step: float) -> str:
    """Return a value with the decimals its step needs."""
    if value == 0 or abs(value) < 1e-9 * step:
        return "0"
    if max(abs(value), step) >= 1e5 or step < 1e-4:
        return f"{value:.3g}"
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    if abs(step / 10.0**-decimals - 2.5) < 1e-6:
        decimals += 1
    return f"{value:.{decimals}f}"


def _log_ticks(lower: float, upper: float, count: int) -> list[tuple[float, str]]:
    first, last = math.ceil(math.log10(lower) - 1e-9), math.floor(math.log10(upper) + 1e-9)
    if last - first >= 1:
        stride = max(1, math.ceil((last - first + 1) / count))
        return [(10.0**power, _format_power(power)) for power in range(first, last + 1, stride)]
    candidates = [
        factor * 10.0**power
        for power in range(first - 2, last + 2)
        for factor in (1.0, 1.2, 1.5, 2.0, 3.0, 5.0, 7.0)
        if lower <= factor * 10.0**power <= upper
    ]
    return [(value, f"{value:.3g}") for value in candidates]


def _format_power(power: int) -> str:
    return f"{10.0**power:g}" if -3 <= power <= 4 else f"1e{power}"
