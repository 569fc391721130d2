"""Spread requests over worker processes; answers come back in any order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

from ocp_traj.comparison.runs.supervisor import run_in_worker_process, run_supervised
from ocp_traj.exceptions import InputError, UnavailableError

Request: TypeAlias = dict[str, Any]
Answer: TypeAlias = dict[str, Any]


def execute(
    requests: Sequence[Request], jobs: int = 1, dask: str | None = None
) -> Iterator[tuple[int, Answer]]:
    """Yield (place in `requests`, answer) as they finish.

    Parameters
    ----------
    requests
        See `ocp_traj.comparison.runs.supervisor.run_supervised`.
    jobs
        Worker processes on this machine (joblib's loky); 1 needs none.
    dask
        Address of a Dask scheduler whose workers are used instead.

    Raises
    ------
    UnavailableError
        Dask is asked for and not installed, or nobody answers at the address.
    """
    if jobs < 1:
        raise InputError(f"jobs is {jobs}, expected 1 or more")
    if not requests:
        return iter(())
    if dask is not None:
        return _execute_on_dask(requests, dask)
    if jobs == 1 or len(requests) == 1:
        return ((place, run_supervised(request)) for place, request in enumerate(requests))
    return _execute_on_loky(requests, min(jobs, len(requests)))


def _run_placed(place: int, request: Request) -> tuple[int, Answer]:
    return place, run_in_worker_process(request)


def _execute_on_loky(requests: Sequence[Request], jobs: int) -> Iterator[tuple[int, Answer]]:
    from joblib import Parallel, delayed

    # Few runs are handed out ahead: what a kill loses is what runs at that moment.
    parallel = Parallel(
        n_jobs=jobs, backend="loky", return_as="generator_unordered", batch_size=1, pre_dispatch="2*n_jobs"
    )
    return parallel(
        delayed(_run_placed)(place, request) for place, request in enumerate(requests)
    )


def _execute_on_dask(requests: Sequence[Request], address: str) -> Iterator[tuple[int, Answer]]:
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise UnavailableError(
            f"--dask needs the extra 'cluster' (pip install ocp-traj[cluster]): {error}"
        ) from error
    try:
        client: Any = Client(address, timeout=5)  # type: ignore[no-untyped-call,unused-ignore]
    except (OSError, ValueError) as error:
        raise UnavailableError(f"no Dask scheduler answers at {address!r}: {error}") from error
    with client:
        places = {
            client.submit(run_supervised, request, pure=False): place
            for place, request in enumerate(requests)
        }
        try:
            for future in as_completed(places):  # type: ignore[no-untyped-call,unused-ignore]
                if client.status != "running" or future.cancelled():
                    raise UnavailableError(
                        f"the Dask scheduler at {address!r} was lost; what is finished is kept, the same command goes "
                        "on from there"
                    )
                lost = future.exception()
                if lost is None:
                    answer = future.result()
                else:
                    answer = {
                        "status": "failed",
                        "reason": "crash",
                        "message": f"the Dask worker was lost: {lost}",
                    }
                yield places[future], answer
        finally:
            client.cancel(list(places))
