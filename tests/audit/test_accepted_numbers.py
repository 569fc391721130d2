"""The page on what the audit accepts and the constants it quotes."""

from __future__ import annotations

import re
from pathlib import Path

from ocp_traj import trajectory_files
from ocp_traj.audit import tolerances

PAGE = Path(__file__).parents[2] / "docs" / "what-the-audit-accepts.md"


def test_the_page_quotes_every_constant_with_its_value() -> None:
    text = PAGE.read_text(encoding="utf-8")
    rows = re.findall(r"^\| [^|]* \| ([^|]*) \| `(\w+)` \|$", text, re.MULTILINE)
    quoted = {name: float(re.findall(r"\d+e-\d+", accepted)[0]) for accepted, name in rows}
    constants = {
        name: value for name, value in vars(tolerances).items() if name.isupper() and isinstance(value, float)
    }
    assert quoted == constants
    assert tuple(quoted[f"{name}_JUMPS"] for name in ("POSITION", "VELOCITY", "ACCELERATION")) == tolerances.JUMPS


def test_numbers_in_its_sentences_are_those_of_the_constants() -> None:
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    narrow = tolerances.POSITION_JUMPS / tolerances.RATIO_TOLERANCE
    for sentence in (
        f"may creep by {tolerances.POSITION_JUMPS:.0e}".replace("e-09", "e-9"),
        f"narrower than {narrow:.0e}".replace("e-03", "e-3"),
        f"to {trajectory_files.COLUMN_AGREEMENT:.0e} of the largest value".replace("e-06", "e-6"),
    ):
        assert sentence in text
