"""Studies kept in a file: every run a row, so that an answer, or a page, needs no new run.

An SQLite file, in one transaction a study. What is measured of a study that is not complete is kept
in the same file, by `plumbob.engines.study.unfinished`.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from plumbob.engines.method import Method, Trimming
from plumbob.engines.study.codec import from_json, packed, to_json, unpacked
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.cost import Cost, Key
from plumbob.engines.study.extra_runs import (
    ExtraConvergence,
    ExtraRun,
    Request,
    Result,
    TrimmingRun,
)
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.model_reading import ModelRead, ModelReading
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.results import Observables, Quantities, Study
from plumbob.engines.study.store_file import FILE, SCHEMA, reading, transaction, writing
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Scene

__all__ = ["FILE", "SCHEMA", "add", "load", "removed", "save", "scene_names", "studies_of"]
_TABLES = ("extra", "run", "convergence_study", "method", "scene")


@dataclass(frozen=True)
class _Head:
    """What a study says once."""

    profile: str
    reference_step: float
    seconds: dict[str, float]
    provenance: Provenance


def save(study: Study, file: Path) -> int:
    """Add a study to `file`, made if need be; returns its number. Raises ParameterError for a file
    that is no store, or one of another version."""
    with writing(file) as store, transaction(store):
        return add(store, study)


def add(
    store: sqlite3.Connection,
    study: Study,
    number: int | None = None,
    packed_extras: Mapping[Request, int] | None = None,
) -> int:
    """Add a study in an open transaction, under this number where one is given; returns its
    number. `packed_extras` are the rows of `piece_extra` that hold extra runs already."""
    head = _Head(study.profile, study.reference_step, dict(study.seconds), study.provenance)
    number = store.execute(
        "insert into study values (?, ?, ?, ?)",
        (number, study.provenance.date, study.profile, to_json(head)),
    ).lastrowid
    assert number is not None
    store.executemany(
        "insert into scene values (?, ?, ?, ?, ?)",
        [
            (
                number,
                s.name,
                to_json(s),
                to_json(study.observables(s.name)),
                to_json(study.quantities(s.name)),
            )
            for s in study.scenes
        ],
    )
    store.executemany(
        "insert into method values (?, ?)", [(number, to_json(m)) for m in study.methods]
    )
    for c in study.convergence:
        cost = study.costs.get((c.scene, c.method))
        store.execute(
            "insert into convergence_study values (?, ?, ?, ?, ?)",
            (number, c.scene, c.method, to_json(replace(c, measurements=())),
             None if cost is None else to_json(cost)),
        )  # fmt: skip
        store.executemany(
            "insert into run values (?, ?, ?, ?, ?, ?)",
            [(number, c.scene, c.method, m.step, m.status, to_json(m))
             for m in c.measurements],
        )  # fmt: skip
    there = packed_extras or {}
    for request, result in study.extras.items():
        if request in there:
            store.execute(
                "insert into extra select ?, kind, request, result, arrays from piece_extra "
                "where rowid = ?",
                (number, there[request]),
            )
        else:
            row = (number, *extra_row(request, result))
            store.execute("insert into extra values (?, ?, ?, ?, ?)", row)
    return number


def removed(store: sqlite3.Connection, number: int) -> None:
    """Take the study of that number out, in an open transaction."""
    for table in _TABLES:
        store.execute(f"delete from {table} where study = ?", (number,))
    store.execute("delete from study where id = ?", (number,))


def load(file: Path, number: int | None = None, scene: str | None = None) -> Study | None:
    """The study of that number, or the newest one; where a scene is given, what the newest study of
    it says of that scene, without extra runs; None where there is none. Raises ParameterError for
    a file that is no store, or one of another version."""
    if not os.path.lexists(file):
        return None
    with reading(file) as store:
        if (found := _newest(store, scene) if number is None else number) is None:
            return None
        body = store.execute("select body from study where id = ?", (found,)).fetchone()
        if body is None:
            return None
        head = from_json(body[0], _Head)
        only = "" if scene is None else " and scene = ?"
        where = (found,) if scene is None else (found, scene)
        scenes = [
            (
                from_json(text, Scene),
                from_json(observables, Observables),
                from_json(quantities, Quantities),
            )
            for text, observables, quantities in store.execute(
                "select body, observables, quantities from scene where study = ?"
                f"{only.replace('scene', 'name')} order by rowid",
                where,
            ).fetchall()
        ]
        query = "select body from method where study = ? order by rowid"
        methods = store.execute(query, (found,)).fetchall()
        convergence, costs = _convergence(store, only, where)
        extras = {} if scene is not None else _extras(store, found)
        study = Study(
            head.profile, tuple(s for s, _, _ in scenes),
            tuple(from_json(text, Method) for (text,) in methods), convergence, costs,
            head.reference_step, head.seconds, {s.name: names for s, names, _ in scenes},
            {s.name: about for s, _, about in scenes}, extras, head.provenance,
        )  # fmt: skip
        _whole(study)
        return study


def history(file: Path) -> dict[int, Provenance]:
    """How each study in `file` was made, by its number; raises as above."""
    if not os.path.lexists(file):
        return {}
    with reading(file) as store:
        found = store.execute("select id, body from study order by id").fetchall()
    return {number: from_json(body, _Head).provenance for number, body in found}


def studies_of(file: Path, scene: str) -> tuple[Study, ...]:
    """What every study in `file` says of a scene, the oldest first, without extra runs. Raises
    ParameterError for a file that is no store, or one of another version."""
    if not os.path.lexists(file):
        return ()
    query = "select distinct study from run where scene = ? order by study"
    with reading(file) as store:
        numbers = [number for (number,) in store.execute(query, (scene,))]
        if lost := set(numbers).difference(n for (n,) in store.execute("select id from study")):
            raise ValueError(f"runs of study {min(lost, key=str)}, which is not there")
    found = (load(file, number, scene) for number in numbers)
    return tuple(study for study in found if study is not None)


def scene_names(file: Path) -> tuple[str, ...]:
    """The scenes that studies in `file` ran, in the order of their names; raises as above."""
    if not os.path.lexists(file):
        return ()
    with reading(file) as store:
        return tuple(n for (n,) in store.execute("select distinct scene from run order by scene"))


def _whole(study: Study) -> None:
    """Raises ValueError where a run is of a scene or a method that the study does not hold, or a
    scene is without observables."""
    scenes, methods = {s.name for s in study.scenes}, {m.name for m in study.methods}
    for scene, names in study.observed.items():
        if not names:
            raise ValueError(f"no observables of {scene}")
    for c in study.convergence:
        for named, known in ((c.scene, scenes), (c.method, methods)):
            if named not in known:
                raise ValueError(f"runs of {named}, which the study lacks")


def _convergence(
    store: sqlite3.Connection, only: str, where: tuple[Any, ...]
) -> tuple[tuple[ConvergenceStudy, ...], dict[Key, Cost]]:
    runs: dict[Key, list[Measurement]] = {}
    query = f"select scene, method, body from run where study = ?{only} order by rowid"
    for scene, method, body in store.execute(query, where).fetchall():
        runs.setdefault((scene, method), []).append(from_json(body, Measurement))
    found, costs = [], {}
    query = "select scene, method, body, cost from convergence_study where study = ?"
    query += f"{only} order by rowid"
    for scene, method, body, cost in store.execute(query, where).fetchall():
        one = from_json(body, ConvergenceStudy)
        found.append(replace(one, measurements=tuple(runs.get((scene, method), ()))))
        if cost is not None:
            costs[scene, method] = from_json(cost, Cost)
    return tuple(found), costs


def extra_row(request: Request, result: Result) -> tuple[str, str, str | None, bytes | None]:
    """Kind and request of an extra run, its result as JSON, and arrays where it has any."""
    text, arrays = None, None
    if isinstance(result, Trajectory):
        text, arrays = packed(result)
    elif result is not None:
        text = to_json(result)
    return type(request).__name__, to_json(request), text, arrays


def _extras(store: sqlite3.Connection, number: int) -> dict[Request, Result]:
    query = "select kind, request, result, arrays from extra where study = ? order by rowid"
    return dict(extra_of(*row) for row in store.execute(query, (number,)).fetchall())


def extra_of(
    kind: str, request: str, text: str | None, arrays: bytes | None
) -> tuple[Request, Result]:
    """The extra run that `extra_row` made this row of; raises ValueError where it is none."""
    if kind == ExtraRun.__name__:
        return from_json(request, ExtraRun), unpacked(text, arrays or b"") if text else None
    if kind == ExtraConvergence.__name__:
        found = from_json(text, ConvergenceStudy) if text else None
        return from_json(request, ExtraConvergence), found
    if kind == ModelReading.__name__:
        return from_json(request, ModelReading), from_json(text, ModelRead) if text else None
    return from_json(request, TrimmingRun), from_json(text, Trimming) if text else None


def _newest(store: sqlite3.Connection, scene: str | None) -> int | None:
    if scene is None:
        row = store.execute("select max(id) from study").fetchone()
    else:
        row = store.execute("select max(study) from run where scene = ?", (scene,)).fetchone()
    return None if row is None else row[0]
