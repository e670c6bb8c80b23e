"""Comparison of engines' own readers of model files (MJCF) with MuJoCo's: which numbers of a file a
reader takes over, and which it drops."""

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

RULE = "mujoco"  # engine whose reader defines the format
# Options that a reader may ignore unnoticed if its default is the file's value.
OPTIONS = ("gravity", "timestep")


@dataclass(frozen=True)
class Reader:
    """The fields that an engine's reader takes from a file."""

    engine: str
    refuses: str = ""  # reason why the reader reads nothing, one line
    read: tuple[str, ...] = ()  # fields of the file that the reader takes over
    # {field that the reader drops: the value that it has instead}
    dropped: Mapping[str, str] | None = None

    def __str__(self) -> str:
        """One line of text: the fields that are read, and the fields that are not."""
        if self.refuses:
            return f"refuses the file: {self.refuses}"
        text = f"reads {', '.join(self.read) or 'nothing'}"
        if not self.dropped:
            return text
        lost = [f"{field} ({why})" if why else field for field, why in self.dropped.items()]
        return f"{text}; not {', '.join(lost)}"


def read_by(file: Path) -> tuple[Reader, ...]:
    """Returns what each installed engine's reader takes from `file`, MuJoCo's first. Each other
    reader runs in a process of its own, since some readers crash on elements that they do not know.
    Raises ParameterError if MuJoCo refuses the file."""
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
    """Returns the fields that a reader takes from a file, and those it drops. `wanted` are the
    fields as MuJoCo reads them, `fields` those of the other reader. The reader has constants of its
    own for the fields in `ignored`."""
    lost = dict.fromkeys(ignored, "its default is the same") | dropped(wanted, fields)
    stated = fields_stated(wanted)
    read = tuple(field for field in stated if field not in lost)
    return Reader(engine, "", read, {field: lost[field] for field in stated if field in lost})


def ignored(wanted: ModelFields, fields: ModelFields) -> tuple[str, ...]:
    """Returns the options that a reader takes from no file. `wanted` and `fields` are a model with
    uncommon options, as MuJoCo and as that reader read it."""
    return tuple(f for f in OPTIONS if not equal(wanted[f, ""], fields.get((f, ""))))


def _seen(engine: str, file: str) -> tuple[str, ModelFields, tuple[str, ...]]:
    """Returns three things of one engine: the reason why its reader refuses a file, the fields that
    it reads, and the options that it always ignores."""
    refuses, read = fields_of(find_engine(engine), Path(file))
    if refuses:
        return refuses, read, ()
    with every_field() as model:
        both = (fields_of(find_engine(name), model)[1] for name in (RULE, engine))
        return "", read, ignored(*both)
