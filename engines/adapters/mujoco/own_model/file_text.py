"""A model file without what can be left out of it: its own elements, changed where they have to be.

MuJoCo's own writer rounds what a compiled model is written from, which moves it. Here attributes of
<geom> and <pair> are set among the user's own, an included file takes the place of its <include>,
and options are added at the end, where the last ones count.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.options import collected, disabled
from plumbob.engines.own_motion import Change

# [m] a margin that no model has, and numbers from there on: an element is known by it
MARK = 1e6
Makers = Mapping[tuple[str, int], int]
"""{(kind, number in the compiled model): the element that makes it}"""


def write(source: Path, left_out: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Write the model file `source` without these to `target`, and return those that its text can
    omit: geoms that one element makes with others have to stay. Raises ParameterError where nothing
    is left, or it cannot be written, or would not compile there."""
    part = target.with_name(f".{target.stem}-{os.getpid()}.xml")
    try:
        root = _read(source, source.parent)
        makers = _makers(root, part)
        kept = tuple(c for change in left_out if (c := _in_text(change, makers)))
        if not kept:
            what = "omitted: what this motion does not need has no text of its own in the file"
            raise ParameterError("write trimmed", str(target), what)
        _compiled(part, _without(root, kept, makers))
        part.replace(target)
    except (OSError, ValueError, ElementTree.ParseError) as error:
        what = f"beside the model, where the files are that it names ({error})"
        raise ParameterError("write trimmed", str(target), what) from None
    finally:
        part.unlink(missing_ok=True)
    return kept


def _read(file: Path, folder: Path) -> Element:
    """The root of a file, each <include> replaced by the elements of its file, which is beside it
    or in the `folder` of the main one."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.parse(file, parser).getroot()
    for parent in list(root.iter()):
        for include in parent.findall("include"):
            named = include.attrib["file"]
            at = list(parent).index(include)
            other = next(
                (p / named for p in (file.parent, folder) if (p / named).is_file()), None
            )
            if other is None:
                raise ValueError(f"{named} is not there")
            parent[at : at + 1] = list(_read(other, folder))
    return root


def _editable(element: Element, within: tuple[str, ...] = ()) -> Iterator[Element]:
    """The elements whose attributes may be set, in order."""
    for child in element:
        geom = child.tag == "geom" and "worldbody" in within and "composite" not in within
        if geom or (child.tag == "pair" and "contact" in within):
            yield child
        yield from _editable(child, (*within, child.tag))


def _written(
    root: Element, edits: Mapping[int, Mapping[str, str]], more: Element | None
) -> str:
    """The text of a file whose editable elements have these attributes too, with `more` at the
    end."""
    root = deepcopy(root)
    for number, element in enumerate(_editable(root)):
        element.attrib.update(edits.get(number, {}))
    if more is not None:
        root.append(more)
    return ElementTree.tostring(root, "unicode")


def _compiled(path: Path, text: str) -> mujoco.MjModel:
    path.write_text(text, "utf-8")
    with collected():
        return mujoco.MjModel.from_xml_path(str(path))


def _makers(root: Element, part: Path) -> Makers:
    """The elements that make geoms and pairs, found by a mark that survives."""
    marks = {k: {"margin": f"{MARK + k:.0f}"} for k, _ in enumerate(_editable(root))}
    model = _compiled(part, _written(root, marks, None))
    makers = {}
    for kind in ("geom", "pair"):
        numbers = np.asarray(getattr(model, f"{kind}_margin")) - MARK
        for i in np.flatnonzero(numbers >= 0).tolist():
            makers[kind, i] = int(numbers[i])
    return makers


def _in_text(change: Change, makers: Makers) -> Change | None:
    """The part of a change that the text can be given: elements all of whose geoms are in it."""
    sets = []
    before = 0
    after = 0
    made = Counter(makers.values())
    for field, indices, value in change.sets:
        of = {i: makers[at] for i in indices if (at := (field.partition("_")[0], i)) in makers}
        changed = Counter(of.values())
        some = tuple(i for i, element in of.items() if changed[element] == made[element])
        before = before + len(indices)
        after = after + len(some)
        if some or not indices:
            sets.append((field, some, value))
    if not sets:
        return None
    name = change.name if before == after else f"{change.name} ({after} of {before} settings)"
    return replace(change, name=name, sets=tuple(sets))


def _without(root: Element, changes: Sequence[Change], makers: Makers) -> str:
    """The text of the file with these changes."""
    edits: dict[int, dict[str, str]] = {}
    option = Element("option")
    flags = 0
    for field, indices, value in (setting for change in changes for setting in change.sets):
        kind, _, name = field.partition("_")
        for i in indices:
            edits.setdefault(makers[kind, i], {})[name] = f"{value:.12g}"
        if not indices and field == "disableflags":
            flags |= int(value)
        elif not indices:
            option.set(field, f"{value:.12g}")
    if flags:
        option.append(Element("flag", dict.fromkeys(disabled(flags), "disable")))
    return _written(root, edits, option if flags or option.attrib else None)
