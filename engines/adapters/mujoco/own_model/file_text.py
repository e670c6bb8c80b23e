"""A model file with changes: the user's own text, with only the necessary edits.

MuJoCo's own writer rounds the numbers of a compiled model, which changes its motion, and drops
comments. Here attributes are set in the text of the user's elements. Options are set in the file's
last <option>, or added at the end, since the last ones count. An included file takes the place of
its <include> only if an element of it may have to change.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar
from xml.parsers.expat import ExpatError

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.options import collected, disabled
from plumbob.engines.adapters.mujoco.own_model.fields import field_texts
from plumbob.engines.adapters.mujoco.own_model.text_tags import (
    Tag,
    edited,
    inserted,
    tag_bytes,
    tags,
    with_includes,
)
from plumbob.engines.own_motion import Change, FileFix, FixPlace

# [m] a margin that no model has; the number of an element is added to it, and identifies the
# element
MARK = 1e6
WrittenPart = TypeVar("WrittenPart")
Makers = Mapping[tuple[str, int], int]
"""{(kind, number in the compiled model): number of the element that makes it}"""
BUILT_IN = 0.02  # [s] MuJoCo's time constant of an element that names none
REFSAFE_OFF = MappingProxyType({"refsafe": "disable"})
# Attributes whose first number is a time constant.
TIME_ATTRIBUTES = ("solref", "solreflimit", "solreffriction", "o_solref")
# {array of time constants of a compiled model: (element of a default class, its attribute)}. A pair
# without a time constant has the one of its geoms.
DEFAULT_ELEMENTS = MappingProxyType(
    {
        "geom_solref": ("geom", "solref"),
        "jnt_solref": ("joint", "solreflimit"),
        "dof_solref": ("joint", "solreffriction"),
        "eq_solref": ("equality", "solref"),
        "tendon_solref_lim": ("tendon", "solreflimit"),
        "tendon_solref_fri": ("tendon", "solreffriction"),
    }
)
# Fields of a compiled model that a fix may change.
FIXED_FIELDS = ("opt.timestep", "opt.integrator", "opt.disableflags", "opt.o_solref")


def write_without(source: Path, left_out: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Writes the model file `source` with the changes `left_out` to `target`. Returns the changes
    that the text of the file can express: a geom that shares an element with unchanged geoms stays
    as it is. Raises ParameterError if no change is left, or the file cannot be written or would not
    compile there."""

    def write(part: Path) -> tuple[Change, ...]:
        """Writes the file `part`, and returns the changes that it has."""
        text = with_includes(source, source.parent)
        makers = _makers(text, part)
        parts = (_part_in_text(change, makers) for change in left_out)
        kept = tuple(part for part in parts if part is not None)
        if not kept:
            what = "omitted: what this motion does not need has no text of its own in the file"
            raise ParameterError("write trimmed", str(target), what)
        _compiled(part, _text_without(text, kept, makers))
        return kept

    return _written("write trimmed", target, write)


def write_fixed(source: Path, fix: FileFix, target: Path) -> FixPlace:
    """Writes the model file `source` with another integrator, step and time constants to `target`.
    Returns the place of the options in the new file. Raises ParameterError if the file cannot be
    written, would not compile there, or would differ in more than the fix."""

    def write(part: Path) -> FixPlace:
        """Writes the file `part`, and returns the place of the options in it."""
        text = source.read_bytes()
        if fix.raised and any(tag.name == "include" for tag in tags(text)):
            text = with_includes(source, source.parent)
        with collected():
            before = mujoco.MjModel.from_xml_path(str(source))
        new_text, place = _fixed_text(text, fix)
        wrong = _differences(before, _compiled(part, new_text), fix)
        if wrong:
            what = (
                f"left out: the text of the file cannot be changed without {', '.join(wrong)}"
            )
            raise ParameterError("write fixed", str(target), what)
        return place

    return _written("write fixed", target, write)


def _written(name: str, target: Path, write: Callable[[Path], WrittenPart]) -> WrittenPart:
    """Returns the result of `write`, which writes a file beside `target`; that file then becomes
    `target`, whole or not at all. Raises ParameterError for the option `name`."""
    part = target.with_name(f".{target.stem}-{os.getpid()}{target.suffix}")
    try:
        result = write(part)
        if os.path.lexists(target):
            raise ParameterError(name, str(target), "a file that does not exist yet")
        part.replace(target)
    except (OSError, ValueError, ExpatError) as error:
        if isinstance(error, ParameterError):
            raise
        what = f"beside the model, where the files are that it names ({error})"
        raise ParameterError(name, str(target), what) from None
    finally:
        part.unlink(missing_ok=True)
    return result


def _compiled(path: Path, text: bytes) -> mujoco.MjModel:
    """Returns the model of a text, which is written to a path."""
    path.write_bytes(text)
    with collected():
        return mujoco.MjModel.from_xml_path(str(path))


def _editable(text: bytes) -> list[Tag]:
    """Returns the tags of the elements whose attributes may be set to leave something out."""
    return [
        tag
        for tag in tags(text)
        if (tag.name == "geom" and "worldbody" in tag.path and "composite" not in tag.path)
        or (tag.name == "pair" and "contact" in tag.path)
    ]


def _makers(text: bytes, part: Path) -> Makers:
    """Returns the elements that make geoms and pairs. They are identified by a mark in the margin,
    which the compiler keeps."""
    marks = [
        (tag, {"margin": f"{MARK + number:.0f}"}) for number, tag in enumerate(_editable(text))
    ]
    model = _compiled(part, edited(text, marks))
    makers = {}
    for kind in ("geom", "pair"):
        elements = np.asarray(getattr(model, f"{kind}_margin")) - MARK
        for index in np.flatnonzero(elements >= 0).tolist():
            makers[kind, index] = int(elements[index])
    return makers


def _part_in_text(change: Change, makers: Makers) -> Change | None:
    """Returns the part of a change that the text of the model file can express, or None. An
    element of the text, such as a default class, may make several geoms. The text can express a
    change only if it changes all geoms of an element."""
    sets = []
    geoms_of_element = Counter(makers.values())
    for field, indices, value in change.sets:
        kind = field.partition("_")[0]
        element_of = {
            index: makers[kind, index] for index in indices if (kind, index) in makers
        }
        changed = Counter(element_of.values())
        kept = tuple(
            index
            for index, element in element_of.items()
            if changed[element] == geoms_of_element[element]
        )
        if kept or not indices:
            sets.append((field, kept, value))
    if not sets:
        return None
    settings = sum(len(indices) for _, indices, _ in change.sets)
    kept_settings = sum(len(indices) for _, indices, _ in sets)
    name = change.name
    if kept_settings < settings:
        name = f"{name} ({kept_settings} of {settings} settings)"
    return replace(change, name=name, sets=tuple(sets))


def _text_without(text: bytes, changes: Sequence[Change], makers: Makers) -> bytes:
    """Returns the text of the file with these changes."""
    sets = list(chain.from_iterable(change.sets for change in changes))
    attributes: dict[int, dict[str, str]] = {}  # new attributes by the number of the element
    for field, indices, value in sets:
        kind, _, attribute = field.partition("_")
        for index in indices:
            attributes.setdefault(makers[kind, index], {})[attribute] = f"{value:.12g}"
    elements = _editable(text)
    text = edited(text, [(elements[number], new) for number, new in attributes.items()])
    option = _option_without(sets)
    return inserted(text, tags(text)[0], option) if option else text


def _option_without(sets: Sequence[tuple[str, tuple[int, ...], float]]) -> bytes:
    """Returns the <option> of those changes of fields that are options; empty if there are none."""
    options: dict[str, str] = {}
    flags = 0
    for field, indices, value in sets:
        if not indices and field == "disableflags":
            flags |= int(value)
        elif not indices:
            options[field] = f"{value:.12g}"
    flag = tag_bytes("flag", dict.fromkeys(disabled(flags), "disable")) if flags else b""
    return tag_bytes("option", options, flag) if flag or options else b""


def _fixed_text(text: bytes, fix: FileFix) -> tuple[bytes, FixPlace]:
    """Returns the text of a file after a fix, and the place of the options in it."""
    text = _with_raised(text, fix)
    elements = tags(text)
    # An included file may have options: options in front of its <include> do not count.
    last_include = max((tag.start for tag in elements if tag.name == "include"), default=0)
    options = [
        tag
        for tag in elements
        if tag.path[-2:] == ("mujoco", "option") and tag.start > last_include
    ]
    if options:
        edits = [
            (_last_with(options, name), {name: value}) for name, value in fix.options.items()
        ]
        text = edited(text, _joined(edits))
        return _with_refsafe_off(text) if fix.unguarded else text, "own option"
    flag = tag_bytes("flag", REFSAFE_OFF) if fix.unguarded else b""
    option = tag_bytes("option", fix.options, flag)
    parents = [tag for tag in elements if tag.path in (("mujoco",), ("robot", "mujoco"))]
    if parents:
        return inserted(text, parents[-1], option), "new option"
    return inserted(text, elements[0], tag_bytes("mujoco", {}, option)), "new mujoco"


def _with_refsafe_off(text: bytes) -> bytes:
    """Returns a text with refsafe disabled in its last <option>."""
    options = [tag for tag in tags(text) if "option" in tag.path]
    if options[-1].name == "flag":
        return edited(text, [(options[-1], REFSAFE_OFF)])
    return inserted(text, options[-1], tag_bytes("flag", REFSAFE_OFF))


def _last_with(options: Sequence[Tag], name: str) -> Tag:
    """Returns the last of some tags that has an attribute; if none has it, the last tag."""
    return next((tag for tag in reversed(options) if name in tag.attributes), options[-1])


def _joined(edits: Sequence[tuple[Tag, dict[str, str]]]) -> list[tuple[Tag, dict[str, str]]]:
    """Returns edits of tags with the edits of one tag joined."""
    values: dict[int, dict[str, str]] = {}
    for tag, new in edits:
        values.setdefault(tag.start, {}).update(new)
    return [(tag, values.pop(tag.start)) for tag, _ in edits if tag.start in values]


def _with_raised(text: bytes, fix: FileFix) -> bytes:
    """Returns the text of a file in which no time constant of contacts, limits and the like is
    shorter than the fix raises them to."""
    if not fix.raised:
        return text
    edits = [(tag, _raised_attributes(tag, fix.raised_to)) for tag in tags(text)]
    text = edited(text, edits)
    root = tags(text)[0]
    if fix.raised_to <= BUILT_IN or root.name == "robot":
        return text
    by_element: dict[str, dict[str, str]] = {}
    for element, name in map(DEFAULT_ELEMENTS.get, fix.raised, repeat(("", ""))):
        by_element.setdefault(element, {})[name] = f"{fix.raised_to:.12g} 1"
    content = b"".join(tag_bytes(name, values) for name, values in by_element.items() if name)
    # Classes take over what stands before them: the new defaults come first.
    return inserted(text, root, tag_bytes("default", {}, content), first=True)


def _raised_attributes(tag: Tag, least: float) -> dict[str, str]:
    """Returns the attributes of a tag whose time constants are shorter than `least` [s], raised to
    it."""
    raised = {}
    for name in TIME_ATTRIBUTES:
        first, *others = tag.attributes.get(name, "0").split() or ["0"]
        if 0.0 < float(first) < least:
            raised[name] = " ".join([f"{least:.12g}", *others])
    return raised


def _differences(before: Any, after: Any, fix: FileFix) -> list[str]:
    """Returns the fields of the compiled model `after` that differ from those of `before` in more
    than the fix."""
    old, new = field_texts(before), field_texts(after)
    times = [name for name in old if "solref" in name and not name.startswith("opt.")]
    allowed = {*FIXED_FIELDS, *times}
    wrong = [name for name in {**old, **new} if old.get(name) != new.get(name)]
    wrong = [name for name in wrong if name not in allowed]
    for name in times:
        raised = np.array(getattr(before, name))
        short = (raised[:, 0] > 0.0) & (raised[:, 0] < fix.raised_to)
        raised[short, 0] = fix.raised_to
        written = getattr(after, name)
        same = (written == getattr(before, name)).all(axis=1)
        if name in fix.raised:
            same &= ~short
        if not (same | np.isclose(written, raised, rtol=1e-9, atol=0.0).all(axis=1)).all():
            wrong.append(name)
    return wrong
