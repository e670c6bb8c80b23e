"""Tests engines' readers of MJCF on a model in which every field has a different number."""

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
from plumbob.engines.peer_model import MechanismDiffers
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


# fields of each kind of element: bodies, joints, geoms, actuators
KINDS = (
    ("mass", "inertia"),
    ("armature", "damping", "stiffness", "frictionloss"),
    ("friction", "solref", "solimp"),
    ("gear", "kp", "kv"),
)
# name of an element that has none in the file: its place there, "joint 0 of body arm"
PLACE = re.compile(r"(body|joint|geom|pair|actuator) \d+( of body .+)?")
ByField = Mapping[str, tuple[float, ...]]
GRAVITY = "gravity"  # a field that a file states even if its numbers are zero
# relative and absolute [SI] difference of equal numbers, after single precision and other frames
RELATIVE_DIFFERENCE, ABSOLUTE_DIFFERENCE = 1e-5, 1e-12


@dataclass(frozen=True)
class ModelRead:
    """The numbers that an engine took from a model file."""

    version: str  # version of the engine
    refuses: str  # why the engine refuses the file, one line; empty if it does not
    numbers: tuple[tuple[str, str, tuple[float, ...]], ...]
    """The field, the name of its body, joint, geom or actuator, and its values (SI)."""

    @property
    def fields(self) -> ModelFields:
        """The numbers by field and name."""
        return {(field, name): values for field, name, values in self.numbers}


@dataclass(frozen=True)
class ModelReading(Request[ModelRead]):
    """A request for the model as an engine's reader reads it."""

    engine: str


def read_model(reading: ModelReading) -> ModelRead | None:
    """The numbers that the engine takes from the model; None if the engine is not installed or
    reads no model files."""
    engine = find_engine(reading.engine)
    if engine.ability(ModelReader) is None or not installed(engine):
        return None
    with every_field() as file:
        refuses, fields = fields_of(engine, file)
    numbers = tuple((*place, values) for place, values in fields.items())
    return ModelRead(version_of(engine), refuses, numbers)


def fields_of(engine: Engine, file: Path) -> tuple[str, ModelFields]:
    """The reason why an engine's reader refuses a file, empty if it does not, and the fields that
    the reader takes from the file. Printed output is dropped."""
    reader = engine.ability(ModelReader)
    assert reader is not None
    try:
        with captured():
            rows = list(reader.read(file))
        fields = dict[tuple[str, str], tuple[float, ...]]()
        for field, name, values in rows:
            while (field, name) in fields:  # a reader may give several elements the same name
                name += "'"
            fields[field, name] = tuple(np.ravel(values).tolist())
        return "", fields
    except ParameterError as error:
        return error.requirement, {}
    except MechanismDiffers as error:
        return str(error), {}


def dropped(wanted: ModelFields, fields: ModelFields) -> dict[str, str]:
    """{field: difference} of the fields that a file states and a reader does not give as MuJoCo
    does. `wanted` are MuJoCo's numbers, `fields` the reader's. A difference is a text such as
    "hinge: nothing for 0.31"; it is empty if the reader gives no number of the field at all."""
    fields = with_places(wanted, fields)
    known = {field for field, _ in fields}
    differences = dict[str, str]()
    for (field, name), values in wanted.items():
        stated = any(values) or field == GRAVITY
        if field in differences or not stated or _has(fields, field, name, values):
            continue
        read = fields.get((field, name))
        read_text = "nothing" if read is None else _text(read)
        difference = f"{name}: {read_text} for {_text(values)}".removeprefix(": ")
        differences[field] = difference if field in known else ""
    return differences


def with_places(wanted: ModelFields, fields: ModelFields) -> ModelFields:
    """A reader's numbers under MuJoCo's names. If an element has no name in the file, its name in
    MuJoCo is its place in the file, and its name in the reader may be any."""
    mujoco_name = dict[tuple[str, str], str]()
    for kind in KINDS:
        places = _places(_elements(wanted, kind), _elements(fields, kind))
        for name, place in places.items():
            mujoco_name |= {(field, name): place for field in kind}
    return {
        (field, mujoco_name.get((field, name), name)): values
        for (field, name), values in fields.items()
    }


def _elements(fields: ModelFields, kind: Sequence[str]) -> Mapping[str, ByField]:
    """{name of an element: {field: numbers}} of the elements with fields of a `kind`."""
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
        """The number of fields with equal numbers, not all zero."""
        return sum(
            any(values) and equal(values, there[name].get(field))
            for field, values in here[place].items()
        )

    if len(unnamed) == len(unknown) and all(map(in_common, unnamed, unknown)):
        return dict(zip(unknown, unnamed, strict=True))  # quick for models of many elements
    places = dict[str, str]()
    pairs = product(unnamed, unknown)
    for place, name in sorted(pairs, key=lambda pair: in_common(*pair), reverse=True):
        if name not in places and place not in places.values() and in_common(place, name):
            places[name] = place
    left = [name for name in unknown if name not in places]
    missing = [place for place in unnamed if place not in places.values()]
    return places | dict(zip(left, missing, strict=True) if len(left) == len(missing) else ())


def fields_stated(wanted: ModelFields) -> tuple[str, ...]:
    """The fields of a model, as MuJoCo reads it, that have a number other than zero; and
    gravity."""
    stated = [field for (field, _), values in wanted.items() if any(values) or field == GRAVITY]
    return tuple(dict.fromkeys(stated))


def _has(fields: ModelFields, field: str, name: str, values: tuple[float, ...]) -> bool:
    """Whether a reader gives an element these numbers. Friction counts under any name if the reader
    does not know the name: some readers give friction to bodies in place of geoms."""
    if field == "friction" and (field, name) not in fields:
        frictions = [numbers for (other, _), numbers in fields.items() if other == field]
        return any(equal(values, numbers) for numbers in frictions)
    return equal(values, fields.get((field, name)))


def equal(values: tuple[float, ...], other: tuple[float, ...] | None) -> bool:
    """Whether two readers have the same numbers, up to single precision."""
    if other is None or len(values) != len(other):
        return False
    allowed = max(RELATIVE_DIFFERENCE * max(map(abs, values), default=0.0), ABSOLUTE_DIFFERENCE)
    pairs = zip(values, other, strict=True)
    return all(
        math.isclose(a, b, rel_tol=RELATIVE_DIFFERENCE, abs_tol=allowed) for a, b in pairs
    )


def _text(values: tuple[float, ...]) -> str:
    """Numbers as a text with four digits each."""
    return " ".join(f"{value:.4g}" for value in values)


@contextmanager
def every_field() -> Iterator[Path]:
    """A temporary file with the model."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "every-field.xml"
        file.write_text(EVERY_FIELD_TEXT, "utf-8")
        yield file
