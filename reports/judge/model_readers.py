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

REFERENCE_READER = "mujoco"  # engine whose reader defines the format
# Options that a reader may ignore unnoticed if its default is the file's value.
OPTIONS = ("gravity", "timestep")


@dataclass(frozen=True)
class FileReading:
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


def file_readings(file: Path) -> tuple[FileReading, ...]:
    """Returns what each installed engine's reader takes from `file`, MuJoCo's first. Each other
    reader runs in a process of its own, since some readers crash on elements that they do not know.
    Raises ParameterError if MuJoCo refuses the file."""
    refusal, reference = fields_of(find_engine(REFERENCE_READER), file)
    if refusal:
        raise ParameterError("FILE", str(file), f"a MuJoCo model file ({refusal})")
    readings = [FileReading(REFERENCE_READER, read=fields_stated(reference))]
    for engine in engines().values():
        has_reader = engine.ability(ModelReader) is not None
        if engine.name != REFERENCE_READER and has_reader and installed(engine):
            readings.append(_isolated_reading(engine.name, file, reference))
    return tuple(readings)


def _isolated_reading(engine: str, file: Path, reference: ModelFields) -> FileReading:
    """Returns the reading of a file by an engine in a process of its own. `reference` are the
    fields as MuJoCo reads them."""
    try:
        with Workers(1) as workers:
            task = workers.submit(_engine_reading, engine, str(file))
            refusal, fields, ignored = task.result()
    except BrokenExecutor:
        return FileReading(engine, "its process crashes")
    if refusal:
        return FileReading(engine, refusal)
    return compared_reading(engine, reference, fields, ignored)


def compared_reading(
    engine: str,
    reference: ModelFields,
    fields: ModelFields,
    ignored: Collection[str] = (),
) -> FileReading:
    """Returns the fields that a reader takes from a file, and those it drops. `reference` are the
    fields as MuJoCo reads them, `fields` those of the other reader. The fields in `ignored` count
    as dropped: the reader does not read them, and its default happens to equal the file's value."""
    lost = dict.fromkeys(ignored, "its default is the same") | dropped(reference, fields)
    stated = fields_stated(reference)
    read = tuple(field for field in stated if field not in lost)
    stated_and_lost = {field: lost[field] for field in stated if field in lost}
    return FileReading(engine, "", read, stated_and_lost)


def ignored_options(reference: ModelFields, fields: ModelFields) -> tuple[str, ...]:
    """Returns the options that a reader takes from no file. `reference` and `fields` are a model
    with uncommon options, as MuJoCo and as that reader read it."""
    return tuple(
        option
        for option in OPTIONS
        if not equal(reference[option, ""], fields.get((option, "")))
    )


def _engine_reading(engine: str, file: str) -> tuple[str, ModelFields, tuple[str, ...]]:
    """Returns three things of one engine: the reason why its reader refuses a file, the fields that
    it reads, and the options that it always ignores."""
    refusal, fields = fields_of(find_engine(engine), Path(file))
    if refusal:
        return refusal, fields, ()
    with every_field() as model:
        _, reference = fields_of(find_engine(REFERENCE_READER), model)
        _, uncommon = fields_of(find_engine(engine), model)
    return "", fields, ignored_options(reference, uncommon)
