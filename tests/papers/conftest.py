"""Stores of these tests need not outlive a power failure: waiting for the disk is most of their time."""

from __future__ import annotations

from typing import Any

import pytest

from ocp_traj.comparison.runs.store import Store


@pytest.fixture(autouse=True)
def quick_store(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = Store.__init__

    def open_quickly(store: Store, *arguments: Any, **options: Any) -> None:
        opened(store, *arguments, **options)
        store._connection.executescript("PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY")

    monkeypatch.setattr(Store, "__init__", open_quickly)
