"""The arm that every row is worked out for."""

from __future__ import annotations

from helpers.row_oracle import arm

__all__ = ["arm"]
