"""Durations themselves, or their logarithms."""

from __future__ import annotations

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.transcription.condensed.encodings.encoding import Encoding
from ocp_traj.transcription.nlp import Symbol


class Durations(Encoding):
    """x holds the durations of gaps themselves, s."""

    name = "durations"

    def from_durations(self, durations: Array) -> Array:
        """Return the durations."""
        return durations

    def to_durations(self, x: Array) -> Array:
        """Return the variables."""
        return x

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Return the variables."""
        return x


class LogDurations(Encoding):
    """x holds the natural logarithms of the durations of gaps: a factor of two is the same step everywhere."""

    name = "log-durations"

    def from_durations(self, durations: Array) -> Array:
        """Return the logarithms."""
        return np.log(durations)

    def to_durations(self, x: Array) -> Array:
        """Return the exponentials."""
        return np.exp(x)

    def symbolic_durations(self, x: Symbol) -> Symbol:
        """Return the exponentials."""
        return ca.exp(x)
