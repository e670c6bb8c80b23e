"""The workers of a Dask cluster as an executor, if they have the same versions as this process."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study.provenance import result_versions
from plumbob.models.extras import install_command

SCHEDULER_WAIT = 10.0  # [s] longest wait for a scheduler's answer, and for its first worker


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """The workers behind a scheduler's `address` (tcp://host:port), and their number. Raises
    ParameterError if no scheduler answers, or a worker has other versions than this process."""
    try:
        from distributed import Client
    except ImportError:
        wanted = f"given where Dask is installed: {install_command('distributed')}"
        raise ParameterError("scheduler", address, wanted) from None
    try:
        client = Client(address, timeout=SCHEDULER_WAIT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        why = " ".join(str(error).split())[:120]
        raise ParameterError(
            "scheduler", address, f"the address of one that runs ({why})"
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=SCHEDULER_WAIT)
        except TimeoutError:
            raise ParameterError(
                "scheduler", address, "one with a worker; it has none"
            ) from None
        _require_same_versions(address, client.run(result_versions))
        # The scheduler repeats a task whose worker has ended.
        yield client.get_executor(pure=False, retries=2), sum(client.nthreads().values())


def _require_same_versions(address: str, workers: Mapping[str, Mapping[str, str]]) -> None:
    """Raises ParameterError if a worker has other versions than this process, and names them."""
    for name, version in result_versions().items():
        worker_versions = {installed.get(name, "missing") for installed in workers.values()}
        others = ", ".join(sorted(worker_versions - {version}))
        if others:
            wanted = f"one whose workers have {name} {version}, as here, not {others}"
            raise ParameterError("scheduler", address, wanted)
