"""Why there is no proof."""

from __future__ import annotations

from ocp_traj.exceptions import OcpTrajError


class NotProved(OcpTrajError):
    """A motion or a bound could not be proved: the message says what does not hold, or is not covered."""
