"""Studies kept in a file: every run a row, so that an answer needs no new run.

An sqlite3 file, in one transaction a study: a study that was cut off leaves nothing behind.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from plumbob.analytic.errors.schemes import Scheme
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy, Trace
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import Controlled, Measurement, ObservedError, Prediction
from plumbob.engines.study.order import Order
from plumbob.engines.study.study import Study
from plumbob.models.scene import Observable, Scene

FILE = "studies.sqlite3"  # its name in a folder of results
_TABLES = """
create table if not exists study (
    id integer primary key, created text not null, command text not null, profile text not null,
    reference_step real, seconds text not null, versions text not null);
create table if not exists scene (study integer not null references study, body text not null);
create table if not exists method (study integer not null references study, body text not null);
create table if not exists convergence_study (
    study integer not null references study, scene text not null, method text not null,
    orders text not null, trace text not null, cost text not null, cut integer not null);
create table if not exists run (
    study integer not null references study, scene text not null, method text not null,
    step real not null, status text not null, body text not null);
create index if not exists run_of on run (study, scene, method);
"""


def save(study: Study, file: Path, created: str, command: str, versions: Mapping[str, str]) -> int:
    """Add a study to `file`, made if need be; returns its number. Raises ParameterError for a file
    that is no store."""
    with _opened(file) as store, store:
        number = store.execute(
            "insert into study (created, command, profile, reference_step, seconds, versions)"
            " values (?, ?, ?, ?, ?, ?)",
            (created, command, study.profile, study.reference_step, _text(study.seconds),
             _text(versions)),
        ).lastrowid  # fmt: skip
        assert number is not None
        store.executemany(
            "insert into scene values (?, ?)",
            [
                (number, _text({**asdict_of(s), "leading": asdict(study.leading(s.name))}))
                for s in study.scenes
            ],
        )
        store.executemany(
            "insert into method values (?, ?)",
            [(number, _text(asdict_of(m))) for m in study.methods],
        )
        for c in study.convergence:
            orders = _text(
                [c.order and asdict(c.order), c.predicted_order and asdict(c.predicted_order)]
            )
            cost = study.costs.get((c.scene, c.method))
            row: tuple[Any, ...] = (
                number,
                c.scene,
                c.method,
                orders,
                _text(c.trace and asdict(c.trace)),
            )
            row += (_text(cost and asdict(cost)), c.cut)
            store.execute("insert into convergence_study values (?, ?, ?, ?, ?, ?, ?)", row)
            store.executemany(
                "insert into run values (?, ?, ?, ?, ?, ?)",
                [(number, c.scene, c.method, m.step, m.status, _text(asdict_of(m)))
                 for m in c.measurements],
            )  # fmt: skip
    return number


def load(file: Path, number: int | None = None, scene: str | None = None) -> Study | None:
    """The study of that number, or the newest one; where a scene is given, what the newest study of
    it says of that scene; None where there is none. Raises ParameterError for a file that is no
    store."""
    if not file.exists():
        return None
    with _opened(file) as store:
        found = number or _newest(store, scene)
        head = store.execute(
            "select profile, reference_step, seconds from study where id = ?", (found,)
        ).fetchone()
        if head is None:
            return None
        bodies = [json.loads(b) for (b,) in _rows(store, "select body from scene", found)]
        bodies = [b for b in bodies if scene in (None, b["name"])]
        leads = {b["name"]: Observable(**b.pop("leading")) for b in bodies if "leading" in b}
        methods = [
            _method(json.loads(b)) for (b,) in _rows(store, "select body from method", found)
        ]
        methods = [_tupled(m) for m in methods]
        convergence, costs = [], {}
        query = "select scene, method, orders, trace, cost, cut from convergence_study"
        for name, method, orders, trace, cost, cut in _rows(store, query, found):
            if scene not in (None, name):
                continue
            runs = store.execute(
                "select body from run where study = ? and scene = ? and method = ? order by rowid",
                (found, name, method),
            )
            order, predicted = (o and _order(o) for o in json.loads(orders))
            kept = json.loads(trace)
            convergence.append(
                ConvergenceStudy(name, method, tuple(_measurement(json.loads(b)) for (b,) in runs), order,
                      predicted, kept and Trace(kept["step"], *(tuple(kept[k]) for k in
                                                              ("times", "values", "errors"))),
                      bool(cut))
            )  # fmt: skip
            if (price := json.loads(cost)) is not None:
                costs[name, method] = Cost(**price)
    return Study(head[0], tuple(map(_scene, bodies)), tuple(methods), tuple(convergence), costs,
                 float("nan") if head[1] is None else head[1], json.loads(head[2]),
                 leads)  # fmt: skip


@contextmanager
def _opened(file: Path) -> Iterator[sqlite3.Connection]:
    try:
        with closing(sqlite3.connect(file)) as store:
            store.executescript(_TABLES)
            yield store
    except sqlite3.DatabaseError as error:
        raise ParameterError("store", str(file), f"a file of stored studies ({error})") from None


def _newest(store: sqlite3.Connection, scene: str | None) -> int | None:
    if scene is None:
        row = store.execute("select max(id) from study").fetchone()
    else:
        row = store.execute("select max(study) from run where scene = ?", (scene,)).fetchone()
    return None if row is None else row[0]


def _rows(store: sqlite3.Connection, query: str, number: int | None) -> Iterator[tuple[Any, ...]]:
    yield from store.execute(f"{query} where study = ? order by rowid", (number,)).fetchall()


def asdict_of(item: Scene | Method | Measurement) -> dict[str, Any]:
    """A dataclass as plain data; `asdict` cannot copy read-only mappings."""

    def plain(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {key: plain(entry) for key, entry in value.items()}
        if isinstance(value, (tuple, list)):
            return [plain(entry) for entry in value]
        if hasattr(value, "__dataclass_fields__"):
            return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
        return value.item() if hasattr(value, "item") else value

    found: dict[str, Any] = plain(item)
    return found


def _text(value: Any) -> str:
    return json.dumps(value)


def _order(body: dict[str, Any]) -> Order:
    return Order(body["slope"], body["low"], body["high"], tuple(body["steps"]))


def _method(body: dict[str, Any]) -> Method:
    return Method(**{**body, "scheme": Scheme(**body["scheme"])})


def _tupled(method: Method) -> Method:
    def tupled(value: Any) -> Any:
        if isinstance(value, Mapping):
            return {name: tupled(entry) for name, entry in value.items()}
        return tuple(value) if isinstance(value, list) else value

    return replace(
        method, step_sizes=tuple(method.step_sizes), systems=tuple(method.systems),
        settings=tupled(method.settings),
    )  # fmt: skip


def _scene(body: dict[str, Any]) -> Scene:
    return Scene(**{**body, "steps": tuple(body["steps"])})


def _measurement(body: dict[str, Any]) -> Measurement:
    errors = {}
    for name, error in body["errors"].items():
        told = error["predicted"]
        if told is not None:
            told = Prediction(**{**told, "terms": {int(p): v for p, v in told["terms"].items()}})
        held = error.get("controlled") and Controlled(**error["controlled"])
        errors[name] = ObservedError(**{**error, "predicted": told, "controlled": held})
    return Measurement(**{**body, "errors": errors, "warnings": tuple(body["warnings"])})
