"""plumbob releases: which release of an engine changed the results of scenes or of your models."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import engines
from plumbob.engines.study.provenance import packages_of
from plumbob.models.registry import matching_scenes
from plumbob.reports.commands.arguments import values

if TYPE_CHECKING:
    from plumbob.engines.method import Engine
    from plumbob.engines.releases.measuring import Release, ReleaseQuestion
    from plumbob.engines.study.scheduler import Progress
    from plumbob.reports.judge.release_changes import FirstChange, ReleaseChange

RELEASES_PAGE = "releases.html"
MOVED, INCOMPLETE = 1, 3


def command(chosen: argparse.Namespace) -> int:
    """Measures the releases that are not stored yet, prints what moved between them and writes the
    page. Returns 1 if a result moved beyond --fail-above, else 3 if a release has no results."""
    from plumbob.engines.releases.overlays import cache_folder, chosen_versions
    from plumbob.reports.commands.arguments.console import note, progress, writable_folder
    from plumbob.reports.view.own_files import check_replaceable

    engine, distribution = _engine(chosen.engine)
    question = _question(chosen, engine, distribution)
    out = Path(chosen.out)
    check_replaceable("out", out / RELEASES_PAGE)
    versions, offline = chosen_versions(chosen.versions, question.distribution, cache_folder())
    writable_folder("out", out)
    if offline:
        note(offline)
    with progress() as show:
        releases, first = _measured(chosen, question, versions, show)
    return _show(chosen, releases, first)


def _engine(name: str) -> tuple[Engine, str]:
    """Returns the engine that a user names, by its own name or by that of a package, and the
    package whose releases are meant. Raises ParameterError."""
    every = engines()
    if name in every:
        engine = every[name]
        others = [packages_of(other)[0] for other in every.values() if other is not engine]
        packages = packages_of(engine)
        return engine, next((each for each in packages if each not in others), packages[0])
    for engine in every.values():
        if name in packages_of(engine):
            return engine, name
    raise ParameterError("engine", name, f"one of {', '.join(every)}, or the name of a package")


def _question(chosen: argparse.Namespace, engine: Engine, distribution: str) -> ReleaseQuestion:
    """Returns what is measured with each release: the subjects that are files are models, the
    others are patterns of scenes; without a subject all scenes. Raises ParameterError."""
    from plumbob.engines.releases.measuring import ReleaseQuestion

    models = [text for text in chosen.subject if Path(text).is_file()]
    patterns = [text for text in chosen.subject if text not in models]
    if not chosen.subject:
        patterns = ["*"]
    for pattern in patterns:
        if pattern.endswith((".xml", ".urdf", ".mjb")):
            raise ParameterError("subject", pattern, "an existing model file, or a scene")
        matching_scenes(pattern)
    if models and engine.name != "mujoco":
        raise ParameterError("subject", models[0], "a scene: model files are for MuJoCo")
    return ReleaseQuestion(
        distribution=distribution,
        scenes=",".join(patterns),
        methods=chosen.methods or f"{engine.name}/*",
        models=tuple(os.path.abspath(model) for model in models),
        budget=chosen.budget,
        duration=chosen.duration,
        plumbob=plumbob.__version__,
    )


def _measured(
    chosen: argparse.Namespace,
    question: ReleaseQuestion,
    versions: Sequence[str],
    show: Progress,
) -> tuple[list[Release], FirstChange | None]:
    """Returns what was measured with the releases, old to new; with --bisect with those that tell
    the first release that differs, and that release."""
    from plumbob.engines.releases.measuring import measured
    from plumbob.engines.releases.overlays import cache_folder
    from plumbob.reports.judge.release_changes import first_change

    jobs = chosen.jobs or os.cpu_count() or 1
    places = (Path(chosen.out), cache_folder())
    if not chosen.bisect:
        return measured(question, versions, *places, jobs, show), None
    done: dict[str, Release] = {}

    def measure(number: int) -> Release:
        """Returns what is measured with the release of a number."""
        version = versions[number]
        done[version] = measured(question, [version], *places, jobs, show)[0]
        return done[version]

    first = first_change(versions, measure, chosen.above or 0.0)
    return [done[version] for version in versions if version in done], first


def _show(
    chosen: argparse.Namespace, releases: Sequence[Release], first: FirstChange | None
) -> int:
    """Prints what moved and writes the page; returns the exit code."""
    from plumbob.reports.judge.release_changes import release_changes
    from plumbob.reports.view.releases import release_rows, write_releases

    with_results = [release for release in releases if not release.why]
    changes: list[ReleaseChange] = []
    for old, new in pairwise(with_results):
        changes += release_changes(old, new)
    limit = 0.0 if chosen.above is None else chosen.above
    moved = [change for change in changes if change.is_beyond(limit)]
    rows = release_rows(releases)
    page = write_releases(
        Path(chosen.out), RELEASES_PAGE, releases, rows, changes, moved, chosen.line
    )
    record = {
        "releases": [
            {"version": release.version, "bytes": release.size, "why": release.why}
            for release in releases
        ],
        "rows": rows,
        "changes": changes,
        "first": first,
        "page": str(page),
    }
    values.show(
        chosen,
        record,
        "releases",
        releases=releases,
        rows=rows,
        moved=moved,
        explained=[change for change in changes if change.explains],
        first=first,
        above=chosen.above,
        page=page,
    )
    if chosen.above is not None and (first.outcome != "none" if first else moved):
        return MOVED
    return INCOMPLETE if any(release.why for release in releases) else 0
