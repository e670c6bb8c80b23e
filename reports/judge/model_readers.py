"""Which numbers of a model file (MJCF) engines' own readers take over, and which they drop, held to
what MuJoCo reads of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import ModelFields, ModelReader
from plumbob.engines.registry import engines, find_engine, installed
from plumbob.engines.study.model_reading import (
    dropped,
    equal,
    every_field,
    fields_of,
    fields_stated,
)
from plumbob.engines.workers import Workers

RULE = "mujoco"  # the reader whose format it is
# that a reader may seem to read where its default is the same
OPTIONS = ("gravity", "timestep")


@dataclass(frozen=True)
class Reader:
    """The fields that an engine's reader takes from a file."""

    engine: str
    refuses: str = ""  # why it reads nothing, one line
    read: tuple[str, ...] = ()  # fields that it takes over, of everything in the file
    dropped: Mapping[str, str] | None = None  # {field: what is there instead}

    def __str__(self) -> str:
        if self.refuses:
            return f"refuses the file: {self.refuses}"
        text = f"reads {', '.join(self.read) or 'nothing'}"
        if not self.dropped:
            return text
        lost = [f"{field} ({why})" if why else field for field, why in self.dropped.items()]
        return f"{text}; not {', '.join(lost)}"


def read_by(file: Path) -> tuple[Reader, ...]:
    """The readings of `file` by MuJoCo and every other installed engine with a reader, each in a
    process of its own, since some crash on what they do not know. Raises ParameterError."""
    rule, wanted = fields_of(find_engine(RULE), file)
    if rule:
        raise ParameterError("FILE", str(file), f"a MuJoCo model file ({rule})")
    readers = [Reader(RULE, read=fields_stated(wanted))]
    for engine in engines().values():
        if engine.name == RULE or engine.ability(ModelReader) is None or not installed(engine):
            continue
        try:
            with Workers(1) as workers:
                refuses, read, never = workers.submit(_seen, engine.name, str(file)).result()
        except BrokenExecutor:
            refuses = "its process ends"
            read = {}
            never = ()
        readers.append(
            Reader(engine.name, refuses)
            if refuses
            else compared(engine.name, wanted, read, never)
        )
    return tuple(readers)


def compared(
    engine: str, wanted: ModelFields, fields: ModelFields, ignored: Collection[str] = ()
) -> Reader:
    """Which of the numbers that a file states, as MuJoCo reads it, are among those that another
    reader gives, who has fields of its own in place of those `ignored`."""
    lost = dict.fromkeys(ignored, "its default is the same") | dropped(wanted, fields)
    stated = fields_stated(wanted)
    read = tuple(field for field in stated if field not in lost)
    return Reader(engine, "", read, {field: lost[field] for field in stated if field in lost})


def ignored(wanted: ModelFields, fields: ModelFields) -> tuple[str, ...]:
    """The options that a reader takes from no file, seen by a model with uncommon ones, as MuJoCo
    reads it and as that reader does."""
    return tuple(f for f in OPTIONS if not equal(wanted[f, ""], fields.get((f, ""))))


def _seen(engine: str, file: str) -> tuple[str, ModelFields, tuple[str, ...]]:
    """Why a reader refuses a file, the fields it takes from it, and those it always ignores."""
    refuses, read = fields_of(find_engine(engine), Path(file))
    if refuses:
        return refuses, read, ()
    with every_field() as model:
        both = (fields_of(find_engine(name), model)[1] for name in (RULE, engine))
        return "", read, ignored(*both)
