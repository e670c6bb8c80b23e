"""Readings of a model (MJCF) that has a number of its own for every field, by engines' readers."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import ModelFields, ModelReader
from plumbob.engines.method import Engine
from plumbob.engines.peer_model import NotRead
from plumbob.engines.registry import find_engine, installed
from plumbob.engines.study.provenance import version_of
from plumbob.engines.study.request import Request
from plumbob.models.entry_points import captured

EVERY_FIELD_TEXT = """\
<mujoco model="every-field">
  <option timestep="3e-3" gravity="0.3 -0.4 -1.62"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 0.1" friction="0.7 0.005 0.0001"/>
    <body name="arm" pos="0 0 1">
      <inertial pos="0 0 -0.5" mass="1.7" diaginertia="0.11 0.12 0.13"/>
      <joint name="hinge" type="hinge" axis="0 -1 0" damping="0.31" armature="0.21"
             frictionloss="0.05" stiffness="0.4"/>
      <geom name="bob" type="sphere" size="0.1" pos="0 0 -0.5" friction="0.6 0.005 0.0001"/>
    </body>
  </worldbody>
  <actuator><motor name="motor" joint="hinge" gear="7"/></actuator>
</mujoco>
"""


GRAVITY = "gravity"  # that a file states, none too
SAME, LEAST = 1e-5, 1e-12  # relative, absolute [SI]: what single precision and new frames leave


@dataclass(frozen=True)
class ModelRead:
    """The numbers that an engine took from a model file."""

    version: str  # of the engine
    refuses: str  # why it reads nothing, one line; else empty
    numbers: tuple[tuple[str, str, tuple[float, ...]], ...]
    """The field, the name of its body, joint, geom or actuator, and its values (SI)."""

    @property
    def fields(self) -> ModelFields:
        """The numbers by field and name."""
        return {(field, name): values for field, name, values in self.numbers}


@dataclass(frozen=True)
class ModelReading(Request[ModelRead]):
    """The model read by an engine's own reader."""

    engine: str


def read_model(reading: ModelReading) -> ModelRead | None:
    """The numbers that the engine takes from the model; None where it is not installed, or reads
    none."""
    engine = find_engine(reading.engine)
    if engine.ability(ModelReader) is None or not installed(engine):
        return None
    with every_field() as file:
        refuses, fields = fields_of(engine, file)
    numbers = tuple((*place, values) for place, values in fields.items())
    return ModelRead(version_of(engine), refuses, numbers)


def fields_of(engine: Engine, file: Path) -> tuple[str, ModelFields]:
    """Why an engine's reader refuses a file, or empty, and what it takes from it; what it prints is
    dropped."""
    reader = engine.ability(ModelReader)
    assert reader is not None
    try:
        with captured():
            rows = list(reader.read(file))
        return "", {(field, name): tuple(np.ravel(v).tolist()) for field, name, v in rows}
    except ParameterError as error:
        return error.requirement, {}
    except NotRead as error:
        return str(error), {}


def dropped(wanted: ModelFields, fields: ModelFields) -> dict[str, str]:
    """{field: what is there instead} of the numbers that a file states, as MuJoCo reads it, which
    another reader does not give; empty where it gives none of the field."""
    known = {field for field, _ in fields}
    lost = dict[str, str]()
    for (field, name), values in wanted.items():
        stated = any(values) or field == GRAVITY
        if field in lost or not stated or _has(fields, field, name, values):
            continue
        instead = fields.get((field, name))
        there = "nothing" if instead is None else _text(instead)
        said = f"{name}: {there} for {_text(values)}".removeprefix(": ")
        lost[field] = said if field in known else ""
    return lost


def fields_stated(wanted: ModelFields) -> tuple[str, ...]:
    """The fields in which a model has a number other than zero, and gravity, as MuJoCo reads it."""
    return tuple(
        dict.fromkeys(field for (field, _), v in wanted.items() if any(v) or field == GRAVITY)
    )


def _has(fields: ModelFields, field: str, name: str, values: tuple[float, ...]) -> bool:
    """Whether a reader gives these numbers; friction of any name where it does not know this one,
    for some give it to bodies in place of geoms."""
    if field == "friction" and (field, name) not in fields:
        return any(equal(values, other) for (of, _), other in fields.items() if of == field)
    return equal(values, fields.get((field, name)))


def equal(values: tuple[float, ...], other: tuple[float, ...] | None) -> bool:
    """Whether two readers have the same numbers."""
    if other is None or len(values) != len(other):
        return False
    allowed = max(SAME * max(map(abs, values), default=0.0), LEAST)
    pairs = zip(values, other, strict=True)
    return all(math.isclose(a, b, rel_tol=SAME, abs_tol=allowed) for a, b in pairs)


def _text(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.4g}" for value in values)


@contextmanager
def every_field() -> Iterator[Path]:
    """A file of the model."""
    with tempfile.TemporaryDirectory() as folder:
        (file := Path(folder) / "every-field.xml").write_text(EVERY_FIELD_TEXT, "utf-8")
        yield file
