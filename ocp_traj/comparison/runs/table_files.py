"""All runs of a comparison as one table in a file."""

from __future__ import annotations

from pathlib import Path

from ocp_traj.comparison.runs.store import Store
from ocp_traj.exceptions import InputError, UnavailableError


def export_table(store: Store, path: Path, kind: str) -> None:
    """Write all runs as one table; `kind` is ``csv`` or ``parquet``.

    Raises
    ------
    InputError
        The file cannot be written.
    UnavailableError
        Parquet is asked for and pyarrow is not installed.
    """
    import pandas

    columns, values = store.table()
    frame = pandas.DataFrame.from_records(values, columns=columns)
    try:
        if kind == "csv":
            frame.to_csv(path, index=False)
        else:
            frame.to_parquet(path, index=False)
    except ImportError as error:
        raise UnavailableError(f"Parquet needs the package pyarrow: {error}") from error
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from None
