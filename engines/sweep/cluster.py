"""A cluster's workers as an executor: Dask's scheduler, once its workers have the same versions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study.provenance import provenance

PATIENCE = 10.0  # [s] for a scheduler to answer, and for its first worker
UNLIKE = ("plotly",)  # packages whose versions do not matter for figures


@contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """The workers behind a scheduler's `address` (tcp://host:port), and how many they are. Raises
    ParameterError where none answers, or a worker has other versions than this process."""
    try:
        from distributed import Client
    except ImportError:
        wanted = "given where the extra is installed: pip install 'plumbob[distributed]'"
        raise ParameterError("scheduler", address, wanted) from None
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        why = " ".join(str(error).split())[:120]
        raise ParameterError(
            "scheduler", address, f"the address of one that runs ({why})"
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise ParameterError(
                "scheduler", address, "one with a worker; it has none"
            ) from None
        _of_these_versions(address, client.run(versions))
        # A task is tried again where its worker ends; that is the scheduler's work.
        yield client.get_executor(pure=False, retries=2), sum(client.nthreads().values())


def versions() -> Mapping[str, str]:
    """The versions that figures depend on, of this process."""
    return {n: v for n, v in provenance("").versions.items() if n not in UNLIKE}


def _of_these_versions(address: str, workers: Mapping[str, Mapping[str, str]]) -> None:
    """Raises ParameterError, naming them, where versions of a worker are others than here."""
    for name, version in versions().items():
        there = [theirs.get(name, "missing") for theirs in workers.values()]
        if other := sorted({*there} - {version}):
            wanted = f"one whose workers have {name} {version}, as here, not {', '.join(other)}"
            raise ParameterError("scheduler", address, wanted)
