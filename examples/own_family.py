"""
A spline family of your own
===========================

A family says how its pieces follow from durations and knot positions. Written once, it works on numbers, on
whole populations and on CasADi symbols. This one comes to rest at every waypoint: quintics with zero velocity
and acceleration at both ends of each gap, the simplest motion a controller can be given.
"""

import casadi as ca
import numpy as np

from ocp_traj.spline import EndConditions, Family, Piece


class StopAndGo(Family):
    """Quintic pieces that start and end at rest; C2 everywhere."""

    name = "stop-and-go"
    degree = 5
    continuity = 2
    takes_virtual_knots = False

    def pieces(self, durations, positions, ends):
        """Return one quintic a gap: its states are q, h v, h^2 a at either end."""
        return [
            Piece(5, h, (start, 0.0 * start, 0.0 * start, end, 0.0 * end, 0.0 * end))
            for h, start, end in zip(durations, positions, positions[1:])
        ]


family = StopAndGo()
ends = EndConditions({1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0})
first, second = family.pieces([2.0, 1.0], [0.0, 1.0, 0.4], ends)
print("ascending coefficients of the first piece in t / h:", np.round(first.coefficients(), 12))
print("should be [0 0 0 10 -15 6]: the minimum-jerk polynomial")

# %%
# The same lines on a population of three candidates ...
durations = [np.array([[1.0], [2.0], [3.0]]), np.array([[1.0], [1.0], [1.0]])]
batch = family.pieces(durations, [np.zeros((3, 2)), np.ones((3, 2)), np.zeros((3, 2))], ends)
print("a population's coefficients have the shape", np.shape(batch[0].coefficients()[3]))

# ... and on symbols.
h = ca.SX.sym("h", 2)
symbolic = family.pieces([h[0], h[1]], [ca.SX(0.0), ca.SX(1.0), ca.SX(0.4)], ends)
print("a symbolic coefficient:", symbolic[1].coefficients()[3])

np.testing.assert_allclose(np.array(first.coefficients(), dtype=float), [0, 0, 0, 10, -15, 6])
