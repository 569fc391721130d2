"""Paper A: the names of its methods and what it prints."""

from __future__ import annotations

ISSA, SSA, PSO = "ISSA of A", "SSA", "PSO"
