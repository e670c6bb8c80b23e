"""What is expensive to make, made once a run of pytest for all of its processes."""

import io
import os
import pickle
import time
from pathlib import Path

from plumbob.models.registry import find_system
from plumbob.models.scene import System

# in the environment of a process that conftest.py has let share
FOLDER = "PLUMBOB_TESTS_SHARED"
PAUSE, PATIENCE = 0.1, 600.0  # [s] between two looks at what another process makes, and in all


class _ByName(pickle.Pickler):
    """Systems, which hold functions without a name, are found again by their own."""

    def reducer_override(self, value):
        """How a system is found again."""
        return (find_system, (value.name,)) if isinstance(value, System) else NotImplemented


def share(folder):
    """Let this process share by a folder of its run."""
    folder.mkdir(exist_ok=True)
    os.environ[FOLDER] = f"{os.getpid()}:{folder}"


def shared(name, make):
    """What `make` makes, in this process or before in another of this run, under `name`."""
    owner, _, folder = os.environ.get(FOLDER, "").partition(":")
    if owner != str(os.getpid()):  # one that a test began makes its own
        return make()
    file = Path(folder) / f"{name}.pickle"
    begun = time.monotonic()
    lock = file.with_suffix(".lock")
    while not file.is_file():
        try:
            lock.mkdir()
        except FileExistsError:
            if time.monotonic() - begun > PATIENCE:
                return make()
            time.sleep(PAUSE)
            continue
        try:
            if not file.is_file():
                return _kept(make(), file)
        finally:
            lock.rmdir()
    found = pickle.loads(file.read_bytes())
    return found


def _kept(found, file):
    packed = io.BytesIO()
    _ByName(packed, pickle.HIGHEST_PROTOCOL).dump(found)
    unfinished = file.with_suffix(".part")
    unfinished.write_bytes(packed.getvalue())
    unfinished.replace(file)
    return found
