"""
A spline family of your own
===========================

A family says how its pieces follow from durations and knot positions. Written once, it works on numbers, on
whole populations and on CasADi symbols, so IPOPT and the population methods solve it as they solve those inside.
This one comes to rest at every waypoint: quintics with zero velocity and acceleration at both ends of each gap,
the simplest motion a controller can be given.
"""

import casadi as ca
import numpy as np

import ocp_traj as ot
from ocp_traj.spline import EndConditions, Family, Piece


class StopAndGo(Family):
    """Quintic pieces that start and end at rest; C2 everywhere."""

    name = "stop-and-go"
    degree = 5
    continuity = 2
    takes_virtual_knots = False

    def pieces(self, durations, positions, ends):
        """Return one quintic per gap: its states are q, h v, h^2 a at either end."""
        return [
            Piece(5, h, (start, 0.0 * start, 0.0 * start, end, 0.0 * end, 0.0 * end))
            for h, start, end in zip(durations, positions, positions[1:])
        ]


family = StopAndGo()
ends = EndConditions({1: 0.0, 2: 0.0}, {1: 0.0, 2: 0.0})
first, second = family.pieces([2.0, 1.0], [0.0, 1.0, 0.4], ends)
print("ascending coefficients of the first piece in t / h:", np.round(first.coefficients(), 12))
print("should be [0 0 0 10 -15 6]: the minimum-jerk polynomial")
np.testing.assert_allclose(np.array(first.coefficients(), dtype=float), [0, 0, 0, 10, -15, 6])

# %%
# The same lines on symbols.
h = ca.SX.sym("h", 2)
symbolic = family.pieces([h[0], h[1]], [ca.SX(0.0), ca.SX(1.0), ca.SX(0.4)], ends)
print("a symbolic coefficient:", symbolic[1].coefficients()[3])

# %%
# A task holds the family itself. The peak of each piece's velocity is 15/8 of the mean.
task = ot.TrajectoryTask(np.array([[0.0], [1.0], [0.4]]), ot.Limits(velocity=1.0), family=family)
for solver in ("ipopt", "cmaes[encoding=scaled]"):
    result = ot.solve(task, solver, seed=0, budget=None if solver == "ipopt" else 1000)
    print(f"{solver}: {result.duration:.6f} s, should be close to 3.000000 s; feasible: {result.feasible}")
    assert result.feasible and abs(result.duration - 15 / 8 * 1.6) < 1e-4
