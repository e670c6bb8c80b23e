"""A headless Chromium on a local file: its document, its console messages and a picture."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import zlib
from dataclasses import dataclass
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
SECONDS = 120  # a loaded machine may take this long to start a browser


@dataclass(frozen=True)
class Seen:
    """A page as the browser has it: the document after its scripts ran, and the console."""

    document: str
    console: tuple[str, ...]


def chromium() -> str:
    """The browser's program; without one the test is skipped, and fails where CI is set."""
    for name in NAMES:
        if found := shutil.which(name):
            return found
    missing = "Chromium is missing (Debian: apt-get install chromium): the page was not looked at"
    if os.environ.get("CI"):
        pytest.fail(missing)
    pytest.skip(missing)


def look(page: Path, fragment: str, profile: Path) -> Seen:
    """Load `page` and let its scripts run; `profile` is a folder for the browser's own files."""
    done = _run(["--dump-dom", f"{page.as_uri()}{fragment}"], profile)
    return Seen(done.stdout, tuple(re.findall(r"CONSOLE[:(].*", done.stderr)))


def screenshot(page: Path, picture: Path, profile: Path) -> tuple[bytes, ...]:
    """The rows of a picture of the top of `page`, which is left as PNG in `picture`."""
    _run([f"--screenshot={picture}", page.as_uri()], profile)
    return rows(picture.read_bytes())


def rows(png: bytes) -> tuple[bytes, ...]:
    """The rows of a PNG with 8 bits a channel, still filtered: equal rows are equal where their
    neighbours are."""
    width, channels = int.from_bytes(png[16:20]), {2: 3, 6: 4}[png[25]]
    place, packed = 8, b""
    while place < len(png):
        size, kind = int.from_bytes(png[place : place + 4]), png[place + 4 : place + 8]
        if kind == b"IDAT":
            packed += png[place + 8 : place + 8 + size]
        place += 12 + size
    data, length = zlib.decompress(packed), 1 + width * channels
    return tuple(data[i : i + length] for i in range(0, len(data), length))


def _run(arguments: list[str], profile: Path) -> subprocess.CompletedProcess[str]:
    options = (
        *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
        *("--disable-background-networking", "--no-first-run", "--hide-scrollbars"),
        *("--enable-logging=stderr", "--window-size=1280,2000", "--virtual-time-budget=10000"),
        f"--user-data-dir={profile}",
    )
    command = [chromium(), *options, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=True)
