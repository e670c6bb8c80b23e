"""How a command line ends in a process of its own, which has loaded what this one has."""

import gc
import os
import signal
import sys
import tempfile
import traceback
from dataclasses import dataclass
from pathlib import Path

from plumbob.reports.cli import main


@dataclass(frozen=True)
class Ended:
    """How a command has ended: its exit code, -9 and the like where a signal ended it, what it
    printed, and the processor time [s] that it and its children used."""

    code: int
    out: str
    err: str
    seconds: float


def ended(words, folder, limit=0):
    """How the command line `words` ends in a folder; SIGKILL ends it after a `limit` [s] of wall
    time, if one is given."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = os.fork()
        if child == 0:
            _run(words, folder, limit, out.fileno(), err.fileno())
        _, status, used = os.wait4(child, 0)
        code = os.waitstatus_to_exitcode(status)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode("utf-8", "backslashreplace"))
    return Ended(code, *texts, used.ru_utime + used.ru_stime)


def _run(words, folder, limit, out, err):
    """In the child: the command, and never anything of what called it."""
    code = 99
    try:
        gc.freeze()
        sys.modules["__main__"].__spec__ = None  # its own processes need nothing of the tests
        vars(sys.modules["__main__"]).pop("__file__", None)
        os.setpgid(0, 0)
        os.dup2(out, 1)
        os.dup2(err, 2)
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 as long as it runs
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 likewise
        os.chdir(folder)
        (Path(folder).parent / "defects").mkdir(exist_ok=True)
        tempfile.tempdir = str(Path(folder).parent / "defects")  # where a traceback is left
        if limit:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(limit)
        try:
            code = main(words)
        except SystemExit as end:
            code = int(end.code or 0)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
