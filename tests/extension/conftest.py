"""Makes the quantities of one's own importable here and, through the search path, in child processes."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
