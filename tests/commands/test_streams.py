"""Exit codes do not depend on what becomes of stdout and stderr, but for results that are lost."""

import subprocess
import sys

import pytest

LOST = "plumbob: stdout: No space left on device\n"
FAST = "solve linear-pendulum --times 0.1"
ENDS = {
    "a full disk": (f"{FAST} > /dev/full", 2, LOST),
    "the help on a full disk": ("list --help > /dev/full", 2, LOST),
    "a closed stdout": (
        "list >&-",
        2,
        "plumbob: stdout is closed: results have no place to go\n",
    ),
    "a full disk for errors": ("solve nothing 2> /dev/full", 2, ""),
    "a closed stderr": ("solve nothing 2>&-", 2, ""),
    "nobody reads": (f"{FAST} | true; exit ${{PIPESTATUS[0]}}", 0, ""),
    "little memory": (f"{FAST}", 3, "plumbob: out of memory\n"),
}


@pytest.mark.skipif(sys.platform != "linux", reason="/dev/full is Linux's")
@pytest.mark.parametrize("kind", ENDS)
def test_how_a_command_ends(kind):
    words, code, said = ENDS[kind]
    # too little for the libraries that numpy loads
    limit = "ulimit -v 100000; " if kind == "little memory" else ""
    # Buffered, as it is for a user: what cannot be written shows at the end.
    line = f"unset PYTHONUNBUFFERED; {limit}{sys.executable} -m plumbob {words}"
    done = subprocess.run(["bash", "-c", line], check=False, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (code, said)
    assert done.stdout == ""
