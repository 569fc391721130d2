"""Makes the fake runners importable here and, through the search path, in the child processes."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
