"""Files and folders that commands write have the permissions that the user's umask leaves."""

import os

import pytest

from plumbob.reports.cli import main

SMALL = ("--scenes", "linear-pendulum/overdamped", "--methods", "ode/rk4", "--jobs", "1")
COMMANDS = {  # what each writes, in the working folder
    ("validate", *SMALL, "--junitxml", "junit.xml"): ("plumbob-out/index.html", "junit.xml"),
    ("report", "plumbob-out", "--single", "one.html"): ("one.html",),
    ("report", "plumbob-out", "--publish", "site"): ("site/index.html", "site/pages/page.js"),
    ("compare", "plumbob-out", "plumbob-out", "--page", "changed.html"): ("changed.html",),
    ("solve", "cone-pendulum", "--figures", "figures.html"): ("figures.html",),
    ("models", "export", "models"): ("models/cone_pendulum/cone_pendulum.xml",),
    (
        "sweep",
        "linear-pendulum/overdamped",
        "ode/rk4",
        "--vary",
        "theta=0.1:0.2:2",
        "--step",
        "1e-2",
        "--out",
        "swept",
        "--csv",
        "swept.csv",
        "--jobs",
        "1",
    ): ("swept.csv",),
}
STORES = (".sqlite3", ".lock", "-shm", "-wal")  # SQLite gives others no right to write


@pytest.fixture(params=[0o077, 0o027, 0o002], ids=oct)
def mask(request):
    """A umask of this process, for one test."""
    before = os.umask(request.param)
    yield request.param
    os.umask(before)


@pytest.mark.long(keep=1)
def test_umask_is_followed(mask, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.chmod(0o755)
    for words, files in COMMANDS.items():
        assert main(words) == 0
        assert all((tmp_path / file).is_file() for file in files)
    written = [path for path in tmp_path.rglob("*") if not path.name.endswith(STORES)]
    assert any(path.is_dir() and path.name == "pages" for path in written)
    permissions = {path: path.stat().st_mode & 0o777 for path in written}
    allowed = {path: (0o777 if path.is_dir() else 0o666) & ~mask for path in written}
    assert permissions == allowed
    stores = [path for path in tmp_path.rglob("*") if path.name.endswith(STORES)]
    assert stores
    assert not any(path.stat().st_mode & 0o777 & mask for path in stores)
