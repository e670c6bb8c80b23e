"""Studies kept in a file: every run a row, so that an answer, or a page, needs no new run.

An SQLite file, in one transaction a study. What is measured of a study that is not complete is kept
in the same file, by `plumbob.engines.study.unfinished`. Each study has checksums: of each scene, of
its extra runs, and one of the rest and of those checksums. What they do not fit is not read:
whatever has damaged a file, nothing else has to notice it.
"""

from __future__ import annotations

import hashlib
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

__all__ = [
    "FILE", "SCHEMA", "add", "load", "removed", "save", "scene_names", "seal", "studies_of",
]  # fmt: skip
_TABLES = ("extra", "run", "convergence_study", "method", "scene", "checksum")
# Rows that a checksum is of: those of a scene, of extra runs, and of the rest.
_OF_SCENE = (
    "select * from scene where study = ? and name = ?",
    "select * from convergence_study where study = ? and scene = ? order by rowid",
    "select * from run where study = ? and scene = ? order by rowid",
)
_OF_EXTRAS = ("select * from extra where study = ? order by rowid",)
_OF_THE_REST = (
    "select * from study where id = ?",
    "select * from method where study = ? order by rowid",
    "select scene, part, digest from checksum where study = ? and part <> 'study' order by rowid",
)


@dataclass(frozen=True)
class _Head:
    """What a study says once."""

    profile: str
    reference_step: float
    seconds: dict[str, float]
    provenance: Provenance
    seed: int


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
    head = _Head(
        study.profile, study.reference_step, dict(study.seconds), study.provenance, study.seed
    )
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
    seal(store, number)
    return number


def seal(store: sqlite3.Connection, number: int) -> None:
    """Write the checksums of a study, in an open transaction, in place of those there were."""
    store.execute("delete from checksum where study = ?", (number,))
    names = store.execute("select name from scene where study = ? order by rowid", (number,))
    parts = [("scene", name) for (name,) in names.fetchall()]
    for part, scene in (*parts, ("extra runs", ""), ("study", "")):
        row = (number, part, scene, _digest(store, number, part, scene))
        store.execute("insert into checksum values (?, ?, ?, ?)", row)


def _digest(store: sqlite3.Connection, number: int, part: str, scene: str) -> str:
    """A hash of every row of a part of a study, as it is stored."""
    queries = {"scene": _OF_SCENE, "extra runs": _OF_EXTRAS, "study": _OF_THE_REST}[part]
    where = (number, scene) if part == "scene" else (number,)
    found = hashlib.sha256()
    for query in queries:
        for row in store.execute(query, where).fetchall():
            for value in row:
                held = value if isinstance(value, bytes) else str(value).encode()
                found.update(f"{type(value).__name__} {len(held)} ".encode())
                found.update(held)
    return found.hexdigest()


def _intact(store: sqlite3.Connection, number: int, *parts: tuple[str, str]) -> None:
    """Raises ValueError where one of these parts of a study is not as it was stored."""
    query = "select part, scene, digest from checksum where study = ?"
    rows = store.execute(query, (number,)).fetchall()
    held = {(part, scene): digest for part, scene, digest in rows}
    for part, scene in parts:
        if held.get((part, scene)) != _digest(store, number, part, scene):
            of = f", {scene or part}," if part != "study" else ""
            raise ValueError(f"study {number}{of} is not as it was stored")


def _numbers(store: sqlite3.Connection, scene: str | None = None) -> list[int]:
    """The studies, or those of a scene, the oldest first; raises ValueError for a damaged one."""
    query = "select id from study union select study from checksum order by 1"
    every = [number for (number,) in store.execute(query).fetchall()]
    for number in every:
        _intact(store, number, ("study", ""))
    if scene is None:
        return every
    query = "select study from checksum where part = 'scene' and scene = ? order by study"
    return [number for (number,) in store.execute(query, (scene,)).fetchall()]


def removed(store: sqlite3.Connection, number: int) -> None:
    """Take the study of that number out, in an open transaction."""
    for table in _TABLES:
        store.execute(f"delete from {table} where study = ?", (number,))
    store.execute("delete from study where id = ?", (number,))


def load(file: Path, number: int | None = None) -> Study | None:
    """The study of that number, or the newest one; None where there is none. Raises ParameterError
    for a file that is no store, is damaged, or is of another version."""
    if not os.path.lexists(file):
        return None
    with reading(file) as store:
        numbers = _numbers(store)
        found = numbers[-1:] if number is None else [n for n in numbers if n == number]
        return _loaded(store, found[0]) if found else None


def _loaded(store: sqlite3.Connection, number: int, scene: str | None = None) -> Study:
    """A study, or what it says of one scene, without extra runs."""
    query = "select part, scene from checksum where study = ? and part <> 'study'"
    parts = store.execute(query, (number,)).fetchall()
    _intact(store, number, *(p for p in parts if scene is None or p == ("scene", scene)))
    (body,) = store.execute("select body from study where id = ?", (number,)).fetchone()
    head = from_json(body, _Head)
    only = "" if scene is None else " and scene = ?"
    where = (number,) if scene is None else (number, scene)
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
    methods = store.execute(query, (number,)).fetchall()
    convergence, costs = _convergence(store, only, where)
    extras = {} if scene is not None else _extras(store, number)
    return Study(
        head.profile, tuple(s for s, _, _ in scenes),
        tuple(from_json(text, Method) for (text,) in methods), convergence, costs,
        head.reference_step, head.seconds, {s.name: names for s, names, _ in scenes},
        {s.name: about for s, _, about in scenes}, extras, head.provenance, head.seed,
    )  # fmt: skip


def history(file: Path) -> dict[int, Provenance]:
    """How each study in `file` was made, by its number; raises as above."""
    if not os.path.lexists(file):
        return {}
    with reading(file) as store:
        _numbers(store)
        found = store.execute("select id, body from study order by id").fetchall()
        return {number: from_json(body, _Head).provenance for number, body in found}


def studies_of(file: Path, scene: str) -> tuple[Study, ...]:
    """What every study in `file` that ran a scene says of it, the oldest first, without extra runs;
    raises as above."""
    if not os.path.lexists(file):
        return ()
    with reading(file) as store:
        found = [_loaded(store, number, scene) for number in _numbers(store, scene)]
    return tuple(s for s in found if any(c.measurements for c in s.convergence))


def scene_names(file: Path) -> tuple[str, ...]:
    """The scenes of studies in `file`, in the order of their names; raises as above."""
    if not os.path.lexists(file):
        return ()
    query = "select distinct scene from checksum where part = 'scene' order by scene"
    with reading(file) as store:
        _numbers(store)
        return tuple(name for (name,) in store.execute(query).fetchall())


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
