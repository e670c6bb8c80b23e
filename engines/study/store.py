"""Studies kept in a file: every run a row, so that an answer, or a page, needs no new run.

An sqlite3 file, in one transaction a study: a study that was cut off leaves nothing behind.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
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
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.results import Observables, Quantities, Study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Scene

FILE = "studies.sqlite3"  # its name in a folder of results
SCHEMA = 4  # of the tables and of the JSON in them; 3 had no quantities of interest
_TABLES = """
create table if not exists study (
    id integer primary key, created text not null, profile text not null, body text not null);
create table if not exists scene (
    study integer not null references study, name text not null, body text not null,
    observables text not null, quantities text not null);
create table if not exists method (study integer not null references study, body text not null);
create table if not exists convergence_study (
    study integer not null references study, scene text not null, method text not null,
    body text not null, cost text);
create table if not exists run (
    study integer not null references study, scene text not null, method text not null,
    step real not null, status text not null, body text not null);
create table if not exists extra (
    study integer not null references study, kind text not null, request text not null,
    result text, arrays blob);
create index if not exists run_of on run (study, scene, method);
"""


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
    head = _Head(study.profile, study.reference_step, dict(study.seconds), study.provenance)
    with _opened(file) as store, store:
        number = store.execute(
            "insert into study (created, profile, body) values (?, ?, ?)",
            (study.provenance.date, study.profile, to_json(head)),
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
        store.executemany(
            "insert into extra values (?, ?, ?, ?, ?)",
            [(number, *_extra_row(*extra)) for extra in study.extras.items()],
        )
    return number


def load(file: Path, number: int | None = None, scene: str | None = None) -> Study | None:
    """The study of that number, or the newest one; where a scene is given, what the newest study of
    it says of that scene, without extra runs; None where there is none. Raises ParameterError for
    a file that is no store, or one of another version."""
    if not file.exists():
        return None
    with _opened(file) as store:
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
    if not file.exists():
        return {}
    with _opened(file) as store:
        found = store.execute("select id, body from study order by id").fetchall()
    return {number: from_json(body, _Head).provenance for number, body in found}


def studies_of(file: Path, scene: str) -> tuple[Study, ...]:
    """What every study in `file` says of a scene, the oldest first, without extra runs. Raises
    ParameterError for a file that is no store, or one of another version."""
    if not file.exists():
        return ()
    query = "select distinct study from run where scene = ? order by study"
    with _opened(file) as store:
        numbers = [number for (number,) in store.execute(query, (scene,))]
    found = (load(file, number, scene) for number in numbers)
    return tuple(study for study in found if study is not None)


def scene_names(file: Path) -> tuple[str, ...]:
    """The scenes that studies in `file` ran, in the order of their names; raises as above."""
    if not file.exists():
        return ()
    with _opened(file) as store:
        return tuple(n for (n,) in store.execute("select distinct scene from run order by scene"))


def usable(file: Path) -> None:
    """Raises ParameterError where no study can be added to `file`: it is no store, or one of
    another version."""
    if file.exists():
        with _opened(file):
            pass


def _whole(study: Study) -> None:
    """Raises ValueError where a run is of a scene or a method that the study does not hold."""
    scenes, methods = {s.name for s in study.scenes}, {m.name for m in study.methods}
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


def _extra_row(request: Request, result: Result) -> tuple[str, str, str | None, bytes | None]:
    """Kind and request of an extra run, its result as JSON, and arrays where it has any."""
    text, arrays = None, None
    if isinstance(result, Trajectory):
        text, arrays = packed(result)
    elif result is not None:
        text = to_json(result)
    return type(request).__name__, to_json(request), text, arrays


def _extras(store: sqlite3.Connection, number: int) -> dict[Request, Result]:
    query = "select kind, request, result, arrays from extra where study = ? order by rowid"
    found: dict[Request, Result] = {}
    for kind, request, text, arrays in store.execute(query, (number,)).fetchall():
        if kind == ExtraRun.__name__:
            found[from_json(request, ExtraRun)] = text and unpacked(text, arrays)
        elif kind == ExtraConvergence.__name__:
            asked = from_json(request, ExtraConvergence)
            found[asked] = text and from_json(text, ConvergenceStudy)
        else:
            found[from_json(request, TrimmingRun)] = text and from_json(text, Trimming)
    return found


@contextmanager
def _opened(file: Path) -> Iterator[sqlite3.Connection]:
    # Rows are fetched before they are read: a cursor left half-way by an error would keep a lock.
    try:
        if file.exists() and not file.is_file():
            raise ValueError("no regular file")
        with closing(sqlite3.connect(file)) as store:
            _of_this_schema(store, file)
            yield store
    except (sqlite3.DatabaseError, ValueError) as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError("store", str(file), f"a file of stored studies ({error})") from None


def _of_this_schema(store: sqlite3.Connection, file: Path) -> None:
    """Make the tables of a new file; raises ParameterError for a file of another schema."""
    (schema,) = store.execute("pragma user_version").fetchone()
    if not schema:  # a new file, or one from before schemas had numbers
        old = store.execute("select 1 from sqlite_master where name = 'study'").fetchone()
        schema = 1 if old else SCHEMA
    if schema != SCHEMA:
        which = "an older" if schema < SCHEMA else "a newer"
        raise ParameterError(
            "store", str(file),
            f"written by this version of plumbob (schema {SCHEMA}), and is by {which} one (schema "
            f"{schema}): take another folder with --out, or measure again",
        )  # fmt: skip
    store.executescript(f"{_TABLES} pragma user_version = {SCHEMA};")


def _newest(store: sqlite3.Connection, scene: str | None) -> int | None:
    if scene is None:
        row = store.execute("select max(id) from study").fetchone()
    else:
        row = store.execute("select max(study) from run where scene = ?", (scene,)).fetchone()
    return None if row is None else row[0]
