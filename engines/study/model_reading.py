"""Readings of a model (MJCF) that has a number of its own for every field, by engines' readers."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
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
  <actuator>
    <motor name="motor" joint="hinge" gear="7"/>
    <position name="servo" joint="hinge" kp="0.8" kv="0.09"/>
  </actuator>
</mujoco>
"""


# The fields of each kind of element: bodies, joints, geoms, actuators.
KINDS = (
    ("mass", "inertia"),
    ("armature", "damping", "stiffness", "frictionloss"),
    ("friction", "solref", "solimp"),
    ("gear", "kp", "kv"),
)
# An element without a name has its place in the file as its name: "joint 0 of body arm".
PLACE = re.compile(r"(body|joint|geom|pair|actuator) \d+( of body .+)?")
ByField = Mapping[str, tuple[float, ...]]
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
        fields = dict[tuple[str, str], tuple[float, ...]]()
        for field, name, values in rows:
            while (field, name) in fields:  # several elements may have one name in a reader
                name += "'"
            fields[field, name] = tuple(np.ravel(values).tolist())
        return "", fields
    except ParameterError as error:
        return error.requirement, {}
    except NotRead as error:
        return str(error), {}


def dropped(wanted: ModelFields, fields: ModelFields) -> dict[str, str]:
    """{field: what is there instead} of the numbers that a file states, as MuJoCo reads it, which
    another reader does not give; empty where it gives none of the field."""
    fields = with_places(wanted, fields)
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


def with_places(wanted: ModelFields, fields: ModelFields) -> ModelFields:
    """A reader's numbers under MuJoCo's names. An element that has no name in the file has its
    place as its name in MuJoCo, and any name in the reader."""
    places = dict[tuple[str, str], str]()
    for kind in KINDS:
        for name, place in _places(_elements(wanted, kind), _elements(fields, kind)).items():
            places |= {(field, name): place for field in kind}
    return {(f, places.get((f, name), name)): values for (f, name), values in fields.items()}


def _elements(fields: ModelFields, kind: Sequence[str]) -> Mapping[str, ByField]:
    """{name: {field: numbers}} of the elements that have fields of a `kind`."""
    elements = dict[str, dict[str, tuple[float, ...]]]()
    for (field, name), values in fields.items():
        if field in kind:
            elements.setdefault(name, {})[field] = values
    return elements


def _places(here: Mapping[str, ByField], there: Mapping[str, ByField]) -> Mapping[str, str]:
    """{name in a reader: place} of the elements of a kind that have no name in the file. `here` are
    MuJoCo's elements, `there` the reader's. Elements with the most numbers in common are matched
    first; if as many are left on both sides, the others are matched in order."""
    unnamed = [name for name in here if PLACE.fullmatch(name) and name not in there]
    unknown = [name for name in there if name not in here]

    def in_common(place: str, name: str) -> int:
        return sum(any(v) and equal(v, there[name].get(f)) for f, v in here[place].items())

    if len(unnamed) == len(unknown) and all(map(in_common, unnamed, unknown)):
        return dict(zip(unknown, unnamed, strict=True))  # quick, also for many elements
    places = dict[str, str]()
    pairs = product(unnamed, unknown)
    for place, name in sorted(pairs, key=lambda pair: in_common(*pair), reverse=True):
        if name not in places and place not in places.values() and in_common(place, name):
            places[name] = place
    left = [name for name in unknown if name not in places]
    missing = [place for place in unnamed if place not in places.values()]
    return places | dict(zip(left, missing, strict=True) if len(left) == len(missing) else ())


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
