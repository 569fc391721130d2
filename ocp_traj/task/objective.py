"""What a motion costs, and how long it may take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ocp_traj.arrays import ArrayLike
from ocp_traj.exceptions import TaskError
from ocp_traj.quantities import COSTS
from ocp_traj.task.checks import expand_interval, numbers
from ocp_traj.task.custom import CustomObjective


@dataclass(frozen=True)
class Motor:
    """DC motors behind the joints, for the copper-loss objective.

    The current of joint i is tau_i / (gear_ratio_i torque_constant_i); the loss is resistance_i current_i^2.

    Parameters
    ----------
    torque_constant : (n,) N m/A
    resistance : (n,) ohm
    gear_ratio : (n,)
    """

    torque_constant: ArrayLike
    resistance: ArrayLike
    gear_ratio: ArrayLike = 1.0


@dataclass(frozen=True)
class Objective:
    """Weights (>= 0) of the cost terms, and bounds on durations.

    Parameters
    ----------
    time : per second of total duration
    energy : per joule of integral sum |tau qdot| dt
    energy_without_regeneration : per joule of integral sum max(tau qdot, 0) dt
    torque : per integral of sum (tau / torque limit)^2 dt
    acceleration, jerk : per integral of the sum of squares
    motor_loss : per joule of copper loss, see `Motor`
    duration : (2,) bounds of the total duration, s; equal bounds fix it
    gap_durations : (G, 2) bounds of the duration of each gap, s
    motor : Motor, optional
        Needed by `motor_loss`.
    custom : tuple of CustomObjective
    others : mapping
        Weights of further costs by the name of their row in `ocp_traj.quantities.COSTS`.
    """

    time: float = 0.0
    energy: float = 0.0
    energy_without_regeneration: float = 0.0
    torque: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    motor_loss: float = 0.0
    duration: ArrayLike = (0.0, np.inf)
    gap_durations: ArrayLike | None = None
    motor: Motor | None = None
    custom: tuple[CustomObjective, ...] = ()
    others: Mapping[str, float] = field(default_factory=dict)

    def weight(self, name: str) -> float:
        """Return the weight of one cost."""
        return getattr(self, name, self.others.get(name, 0.0))

    @property
    def names(self) -> list[str]:
        """Names of the costs: those that have a field, and those of `others`."""
        return [name for name in COSTS if name in self.__dataclass_fields__ or name in self.others]

    @property
    def weights(self) -> dict[str, float]:
        """Weights that are not zero, by name."""
        return {name: self.weight(name) for name in self.names if self.weight(name) > 0}

    def with_weights(self, weights: Mapping[str, float]) -> Objective:
        """Return a copy with these weights alone, and without a user's own costs."""
        known = {name: weights.get(name, 0.0) for name in COSTS if name in self.__dataclass_fields__}
        others = {name: weight for name, weight in weights.items() if name not in known}
        return replace(self, custom=(), others=others, **known)  # type: ignore[arg-type]

    @property
    def needs_torque(self) -> bool:
        """True when a term with torques has weight."""
        return any(COSTS[name].needs_inertia for name in self.weights) or bool(self.custom)

    def expanded(self, gaps: int) -> Objective:
        """Return the objective with checked weights and array bounds; time gets weight 1 when nothing has any."""
        for name in self.others:
            if name not in COSTS or name in self.__dataclass_fields__:
                expected = ", ".join(sorted(set(COSTS) - set(self.__dataclass_fields__))) or "none"
                raise TaskError(f"objective.{name}", f"is no further cost, those known are: {expected}")
        for name in self.names:
            weight = self.weight(name)
            if not (np.isfinite(numbers(f"objective.{name}", weight)) and weight >= 0):
                raise TaskError(
                    f"objective.{name}", f"{weight} is not a weight, expected a number of 0 or more"
                )
        duration = expand_interval("objective.bounds.duration", self.duration, (2,))
        gap = np.tile([0.0, np.inf], (gaps, 1)) if self.gap_durations is None else self.gap_durations
        gap_durations = expand_interval("objective.bounds.gap_durations", gap, (gaps, 2))
        if self.motor_loss > 0 and self.motor is None:
            raise TaskError("objective.motor_loss", "needs the motors' parameters in robot.motor")
        time = self.time if self.weights or self.custom else 1.0
        return replace(self, time=time, duration=duration, gap_durations=gap_durations)
