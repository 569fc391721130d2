"""Paper B: the names of its methods and what it prints."""

from __future__ import annotations

ISSA, SSA, PSO = "ISSA of B", "SSA", "PSO"
PUBLISHED_TOTALS = {ISSA: 3.17564, SSA: 3.33759, PSO: 3.77099}
"""Section 5, seconds; SSA's is called an average, the others are not said to be."""

UNOPTIMISED = 6.0
"""2 s a segment, section 5."""
