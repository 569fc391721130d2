"""What the variables of a condensed problem may mean; a new encoding is one file with a class, and one line here."""

from __future__ import annotations

from ocp_traj.exceptions import InputError
from ocp_traj.transcription.condensed.encodings.durations import Durations, LogDurations
from ocp_traj.transcription.condensed.encodings.encoding import Encoding
from ocp_traj.transcription.condensed.encodings.scaled import Scaled

ENCODINGS: dict[str, type[Encoding]] = {
    encoding.name: encoding for encoding in (Durations, LogDurations, Scaled)
}
"""Encodings by name."""


def find_encoding(encoding: str | type[Encoding]) -> type[Encoding]:
    """Return the encoding of that name, or the encoding itself.

    Parameters
    ----------
    encoding : str or Encoding class

    Returns
    -------
    Encoding class

    Raises
    ------
    InputError
        There is none; the message lists those there are.
    """
    if isinstance(encoding, type):
        return encoding
    if encoding not in ENCODINGS:
        raise InputError(f"encoding {encoding!r} is unknown, expected one of {', '.join(ENCODINGS)}")
    return ENCODINGS[encoding]


__all__ = ["ENCODINGS", "Encoding", "find_encoding"]
