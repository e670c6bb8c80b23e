"""Which fields of a model file engines' own readers take over: read by the engines of the study,
and known of the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from plumbob.engines.study.extra_runs import Request, StudyPlan
from plumbob.engines.study.model_reading import EVERY_FIELD, ModelRead, ModelReading, readings
from plumbob.engines.study.results import Study
from plumbob.models.registry import find_system
from plumbob.reports.analyses.measurements import plan_of
from plumbob.reports.judge.model_readers import RULE, Reader, compared, fields_stated, ignored
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import plural

NAMES: Mapping[str, str] = MappingProxyType(
    {"mujoco": "MuJoCo", "dart": "DART", "drake": "Drake", "pinocchio": "Pinocchio",
     "pybullet": "PyBullet"}
)  # fmt: skip
READ, DROPPED = "read", "not read"


@dataclass(frozen=True)
class Known:
    """The fields that a version of an engine reads of a model that has every field."""

    version: str
    fields: tuple[str, ...]


KNOWN: Mapping[str, Known] = MappingProxyType(
    {
        "dart": Known("6.20.0", ("mass", "damping", "friction")),
        "drake": Known(
            "1.51.1",
            ("gravity", "mass", "inertia", "armature", "damping", "friction", "gear"),
        ),
        "pinocchio": Known("4.1.0", ("mass", "inertia", "armature", "damping", "frictionloss")),
        "pybullet": Known("3.2.7", ("mass", "friction")),
    }
)  # by reading, which a test repeats where they are installed


def requests(plan: StudyPlan) -> Sequence[Request]:
    """The models of the plan's systems, read by those of its engines that read any; none without
    MuJoCo, whose format it is."""
    engines = {method.engine for method in plan.methods}
    if RULE not in engines:
        return ()
    first = (RULE, *sorted(engines - {RULE}))
    names = dict.fromkeys(scene.system for scene in plan.scenes)
    return readings(first, [find_system(name) for name in names])


def finding(study: Study) -> Finding | None:
    """Which fields each reader takes over; None where MuJoCo read nothing."""
    readings = {
        request: study.reading(request)
        for request in requests(plan_of(study))
        if isinstance(request, ModelReading)
    }
    rule = readings.get(ModelReading(RULE, EVERY_FIELD))
    if rule is None or rule.refuses:
        return None
    readers = {
        request.engine: (read, _reader(request.engine, rule, read))
        for request, read in readings.items()
        if request.model == EVERY_FIELD and read is not None
    }
    others = {name: known for name, known in KNOWN.items() if name not in readers}
    return Finding(
        "model-readers",
        "Engines that read MJCF files drop fields of them without a word",
        "measured" if len(readers) > 1 else "known",
        _summary(rule, readers, others),
        (
            "Each reader was given the same file, with a number of its own in every field, and "
            "asked for what it then holds; a field counts as read where every number of it is "
            "MuJoCo's, to single precision. A body without its inertia turns at another rate, and "
            "a joint without its armature or damping is another joint: who simulates the same file "
            "in two engines and finds two motions has to look here first.",
            *_changed(readers),
            *_left_out(others),
        ),
        tuple(t for t in (_by_field(rule, readers, others), _by_model(readings)) if t),
        (),
        ("plumbob models check", "plumbob models check my.xml"),
    )


def _reader(engine: str, rule: ModelRead, read: ModelRead) -> Reader:
    if read.refuses:
        return Reader(engine, read.refuses)
    return compared(engine, rule.fields, read.fields, _never(rule, read))


def _summary(
    rule: ModelRead, readers: Mapping[str, tuple[ModelRead, Reader]], others: Mapping[str, Known]
) -> str:
    every = len(fields_stated(rule.fields))
    counts = [
        f"{NAMES.get(name, name)} {len(reader.read)}"
        for name, (_, reader) in readers.items()
        if name != RULE
    ]
    counts += [f"{NAMES[name]} {len(known.fields)}" for name, known in others.items()]
    return (
        "Before the same file goes into another engine, ask what that takes over (plumbob models "
        f"check FILE): of {every} fields that MuJoCo reads, {', '.join(counts)}."
    )


def _changed(readers: Mapping[str, tuple[ModelRead, Reader]]) -> tuple[str, ...]:
    """Fields that a reader reads and the known version did not, and the reverse."""
    lines = []
    for name, known in KNOWN.items():
        if name not in readers or readers[name][1].refuses:
            continue
        read, reader = readers[name]
        more = [field for field in reader.read if field not in known.fields]
        less = [field for field in known.fields if field not in reader.read]
        if more or less:
            changes = [f"also reads {', '.join(more)}"] * bool(more)
            changes += [f"no longer reads {', '.join(less)}"] * bool(less)
            lines.append(
                f"{NAMES[name]} {read.version} {' and '.join(changes)}, unlike {known.version}."
            )
    return tuple(lines)


def _left_out(others: Mapping[str, Known]) -> tuple[str, ...]:
    """Which engines the study did not read with."""
    if not others:
        return ()
    names = ", ".join(f"{NAMES[name]} {known.version}" for name, known in others.items())
    extras = ",".join(others)
    return (
        f"This study ran without {', '.join(NAMES[name] for name in others)}: not installed, or "
        f"none of their methods chosen. Their columns are what {names} are known to read. With "
        f"`pip install 'plumbob[{extras}]'` the same study reads with them.",
    )


def _by_field(
    rule: ModelRead, readers: Mapping[str, tuple[ModelRead, Reader]], others: Mapping[str, Known]
) -> Table:
    """Fields against readers."""
    heads = ["field", *(f"{NAMES.get(n, n)} {read.version}" for n, (read, _) in readers.items())]
    heads += [f"{NAMES[name]} {known.version}, known" for name, known in others.items()]
    rows = []
    for field in fields_stated(rule.fields):
        cells = [Cell(_said(reader, field)) for _, reader in readers.values()]
        cells += [Cell(READ if field in known.fields else DROPPED) for known in others.values()]
        rows.append(row(field, *cells))
    return Table(
        "What becomes of a model that has a number of its own in every field",
        tuple(heads),
        tuple(rows),
        "Where a field is not read: the name of the body or joint, what is there, and what the "
        "file says.",
    )


def _said(reader: Reader, field: str) -> str:
    if reader.refuses:
        return f"refused: {reader.refuses}"
    if field in reader.read:
        return READ
    why = (reader.dropped or {}).get(field, "")
    return f"{DROPPED}; {why}" if why else DROPPED


def _by_model(readings: Mapping[ModelReading, ModelRead | None]) -> Table | None:
    """plumbob's own models against readers: which of their fields each drops."""
    engines = tuple(dict.fromkeys(r.engine for r, read in readings.items() if read is not None))
    models = dict.fromkeys(r.model for r in readings if r.model != EVERY_FIELD)
    every = {engine: readings[ModelReading(engine, EVERY_FIELD)] for engine in engines}
    never = {engine: _never(every[RULE], every[engine]) for engine in engines}
    rows = []
    for model in models:
        rule = readings[ModelReading(RULE, model)]
        if rule is not None and not rule.refuses:
            cells = (
                Cell(_dropped(engine, rule, readings[ModelReading(engine, model)], never[engine]))
                for engine in engines
            )
            rows.append(row(Cell(model, "scene"), *cells))
    if not rows or len(engines) < 2:
        return None
    return Table(
        "Fields of plumbob's own models that are not read",
        ("model", *(NAMES.get(name, name) for name in engines)),
        tuple(rows),
        "A field that is zero in a model cannot be dropped and is not counted.",
    )


def _never(rule: ModelRead | None, read: ModelRead | None) -> tuple[str, ...]:
    """The options that a reader takes from no file."""
    if rule is None or read is None or read.refuses:
        return ()
    return ignored(rule.fields, read.fields)


def _dropped(engine: str, rule: ModelRead, read: ModelRead | None, never: tuple[str, ...]) -> str:
    """The fields of one model that a reader drops, as text."""
    if read is None:
        return "–"
    if read.refuses:
        return f"refused: {read.refuses}"
    dropped = compared(engine, rule.fields, read.fields, never).dropped or {}
    total = plural(len(fields_stated(rule.fields)), "field")
    return ", ".join(dropped) if dropped else f"none of {total}"
