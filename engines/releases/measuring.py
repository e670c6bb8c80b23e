"""Measures scenes and model files with each of several releases of an engine. Each release runs in
a process of its own, which uses the release's overlay."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from plumbob.engines.releases.overlays import NotInstalled, Overlay, overlay
from plumbob.engines.study import store
from plumbob.engines.study.results import Study

LONGEST_RELEASE = 7200.0  # [s] longest wall time of what is measured with one release
POLLING = 0.1  # [s] time between two looks at the processes
AT_ONCE = 2  # number of releases that are measured at the same time
ANSWERED = (0, 1)  # exit codes of a command that has an answer
ASKED, AUDITS = "asked.json", "audits.json"  # files in the folder of a release


@dataclass(frozen=True)
class ReleaseQuestion:
    """The scenes and model files that are measured with each release of an engine."""

    distribution: str
    scenes: str = ""  # pattern of scenes; empty for none
    methods: str = ""  # pattern of methods
    models: tuple[str, ...] = ()  # paths of model files
    budget: float = 60.0  # [s] processor time for the audit of a model
    duration: float | None = None  # [s] duration of the audited motions
    plumbob: str = ""  # plumbob's version

    def commands(self, folder: Path, jobs: int) -> Iterator[tuple[list[str], str]]:
        """Gives the arguments of each plumbob command that answers the question, and the name of
        the file in `folder` for what the command prints. Each command runs `jobs` processes."""
        if self.scenes:
            chosen = ["--scenes", self.scenes, "--methods", self.methods]
            yield (
                ["validate", *chosen, "--jobs", str(jobs), "--out", str(folder)],
                "verdicts.txt",
            )
        if self.models:
            options = ["--json", "--budget", f"{self.budget:g}", "--jobs", str(jobs)]
            if self.duration is not None:
                options += ["--duration", f"{self.duration:g}"]
            yield ["audit", *self.models, *options], AUDITS


@dataclass(frozen=True)
class Release:
    """The results with one release."""

    version: str
    size: int = 0  # [bytes] size of its overlay
    study: Study | None = None
    audits: Sequence[Mapping[str, Any]] = ()
    why: str = ""  # why the release has no results; empty if it has


class _Running:
    """The processes that measure one release, one after the other."""

    def __init__(
        self, question: ReleaseQuestion, installed: Overlay, folder: Path, jobs: int
    ) -> None:
        self.question = question
        self.installed = installed
        self.folder = folder
        self.why = ""  # why a command has no answer
        self._ends = time.monotonic() + LONGEST_RELEASE
        self._waiting = list(question.commands(folder, jobs))
        self._process: subprocess.Popen[bytes] | None = None
        self._file = ""
        folder.mkdir(parents=True, exist_ok=True)

    def is_done(self) -> bool:
        """Starts the next command if none runs. Returns whether all commands have ended, or one
        has no answer."""
        if self._process is not None:
            code = self._process.poll()
            if code is None and time.monotonic() < self._ends:
                return False
            self._end(code)
        if self.why or not self._waiting:
            return True
        arguments, self._file = self._waiting.pop(0)
        with (
            open(self.folder / f"new-{self._file}", "wb") as out,
            open(self.folder / "messages.txt", "wb") as messages,
        ):
            # With -P, no file of the user's folder is imported in place of a package.
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "plumbob", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=messages,
                env=dict(self.installed.environment()),
            )
        return False

    def _end(self, code: int | None) -> None:
        """Keeps the output of the process that has ended with an exit code; None if the process ran
        out of time."""
        if code is None:
            self.stop()
            self.why = f"no answer within {LONGEST_RELEASE:g} s"
        elif code not in ANSWERED and not self._has_audits(code):
            text = (self.folder / "messages.txt").read_text("utf-8", "backslashreplace")
            lines = text.split("\n") if text.strip() else [f"exit code {code}"]
            last = next(line for line in reversed(lines) if line.strip())
            self.why = last.removeprefix("plumbob: ")
        if not self.why:
            (self.folder / f"new-{self._file}").replace(self.folder / self._file)
        self._process = None

    def _has_audits(self, code: int) -> bool:
        """Whether a command refused some model files (exit code 2) and audited the others."""
        return code == 2 and self._file == AUDITS and len(self.question.models) > 1

    def stop(self) -> None:
        """Kills the process, if one runs."""
        if self._process is not None and self._process.poll() is None:
            self._process.kill()
            self._process.wait()


def measured(
    question: ReleaseQuestion,
    versions: Sequence[str],
    folder: Path,
    cache: Path,
    jobs: int,
    show: Callable[[str, int, int], None],
) -> list[Release]:
    """Returns what is measured with each of the `versions`, in their order. Results are stored in
    `folder`; a release whose results for this question are there is not measured again. Overlays
    are stored in `cache`. `jobs` processes run at a time; `show` is called with the release
    that begins, the number of finished releases and the number of all."""
    done: dict[str, Release] = {}
    waiting = list(versions)
    jobs_each = max(1, jobs // AT_ONCE)
    with _stopped_at_the_end() as running:
        while len(done) < len(versions):
            while waiting and len(running) < min(AT_ONCE, jobs):
                version = waiting.pop(0)
                show(f"{question.distribution} {version}", len(done), len(versions))
                begun = _started(question, version, folder, cache, jobs_each)
                if isinstance(begun, Release):
                    done[version] = begun
                else:
                    running.append(begun)
            for run in [run for run in running if run.is_done()]:
                running.remove(run)
                done[run.installed.version] = _ended(run)
            time.sleep(POLLING if running else 0.0)
    return [done[version] for version in versions]


@contextmanager
def _stopped_at_the_end() -> Iterator[list[_Running]]:
    """Gives a list; kills the processes of everything that is in the list at the end."""
    running: list[_Running] = []
    try:
        yield running
    finally:
        for run in running:
            run.stop()


def _started(
    question: ReleaseQuestion, version: str, folder: Path, cache: Path, jobs: int
) -> Release | _Running:
    """Returns the results of a release if they are stored, or if the release cannot be installed;
    else what measures them."""
    place = folder / f"{question.distribution}-{version}"
    try:
        installed = overlay(cache, question.distribution, version)
    except NotInstalled as why:
        return Release(version, why=str(why))
    asked = place / ASKED
    if asked.is_file() and json.loads(asked.read_text("utf-8")) == _plain(question):
        return _stored(question, installed, place)
    asked.unlink(missing_ok=True)  # what is stored answers another question
    return _Running(question, installed, place, jobs)


def _ended(run: _Running) -> Release:
    """Marks what was measured with a release as whole, and returns it."""
    if run.why:
        return Release(run.installed.version, run.installed.size, why=run.why)
    asked = run.folder / ASKED
    asked.with_suffix(".new").write_text(json.dumps(_plain(run.question)), "utf-8")
    asked.with_suffix(".new").replace(asked)
    return _stored(run.question, run.installed, run.folder)


def _plain(question: ReleaseQuestion) -> Any:
    """Returns a question as JSON reads it."""
    return json.loads(json.dumps(asdict(question)))


def _stored(question: ReleaseQuestion, installed: Overlay, folder: Path) -> Release:
    """Returns what is stored in the folder of a release."""
    study = store.load(folder / store.FILE) if question.scenes else None
    audits = json.loads((folder / AUDITS).read_text("utf-8")) if question.models else []
    if isinstance(audits, dict):
        audits = [audits]
    if question.scenes and not (study and study.convergence):
        why = f"none of the methods {question.methods} is meant for {question.scenes}"
        return Release(installed.version, installed.size, why=why)
    return Release(installed.version, installed.size, study, audits)
