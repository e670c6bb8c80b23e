"""A model file with changes: the user's own elements, with only the necessary edits.

MuJoCo's own writer rounds the numbers of a compiled model, which changes its motion. Here
attributes of the user's <geom> and <pair> elements are set, an included file takes the place of its
<include>, and options are added at the end, since the last ones count.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from itertools import chain
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.options import collected, disabled
from plumbob.engines.own_motion import Change

# [m] a margin that no model has; the number of an element is added to it, and identifies the
# element
MARK = 1e6
Makers = Mapping[tuple[str, int], int]
"""{(kind, number in the compiled model): number of the element that makes it}"""


def write_without(source: Path, left_out: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Writes the model file `source` with the changes `left_out` to `target`. Returns the changes
    that the text of the file can express: a geom that shares an element with unchanged geoms stays
    as it is. Raises ParameterError if no change is left, or the file cannot be written or would not
    compile there."""
    part = target.with_name(f".{target.stem}-{os.getpid()}.xml")
    try:
        root = _with_includes(source, source.parent)
        makers = _makers(root, part)
        parts = (_part_in_text(change, makers) for change in left_out)
        kept = tuple(part for part in parts if part is not None)
        if not kept:
            what = "omitted: what this motion does not need has no text of its own in the file"
            raise ParameterError("write trimmed", str(target), what)
        _compiled(part, _text_without(root, kept, makers))
        part.replace(target)
    except (OSError, ValueError, ElementTree.ParseError) as error:
        what = f"beside the model, where the files are that it names ({error})"
        raise ParameterError("write trimmed", str(target), what) from None
    finally:
        part.unlink(missing_ok=True)
    return kept


def _with_includes(file: Path, folder: Path) -> Element:
    """Returns the root of a file, with each <include> replaced by the elements of its file, which
    is next to it or in the `folder` of the main file."""
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
            parent[at : at + 1] = list(_with_includes(other, folder))
    return root


def _editable_elements(element: Element, within: tuple[str, ...] = ()) -> Iterator[Element]:
    """Yields the elements whose attributes may be set, in order."""
    for child in element:
        geom = child.tag == "geom" and "worldbody" in within and "composite" not in within
        if geom or (child.tag == "pair" and "contact" in within):
            yield child
        yield from _editable_elements(child, (*within, child.tag))


def _edited_text(
    root: Element, edits: Mapping[int, Mapping[str, str]], more: Element | None
) -> str:
    """Returns the text of a file after `edits` of the attributes of editable elements, by number,
    with `more` at the end."""
    root = deepcopy(root)
    for number, element in enumerate(_editable_elements(root)):
        element.attrib.update(edits.get(number, {}))
    if more is not None:
        root.append(more)
    return ElementTree.tostring(root, "unicode")


def _compiled(path: Path, text: str) -> mujoco.MjModel:
    """Returns the model of a text, which is written to a path."""
    path.write_text(text, "utf-8")
    with collected():
        return mujoco.MjModel.from_xml_path(str(path))


def _makers(root: Element, part: Path) -> Makers:
    """Returns the elements that make geoms and pairs. They are identified by a mark in the margin,
    which the compiler keeps."""
    marks = {k: {"margin": f"{MARK + k:.0f}"} for k, _ in enumerate(_editable_elements(root))}
    model = _compiled(part, _edited_text(root, marks, None))
    makers = {}
    for kind in ("geom", "pair"):
        numbers = np.asarray(getattr(model, f"{kind}_margin")) - MARK
        for i in np.flatnonzero(numbers >= 0).tolist():
            makers[kind, i] = int(numbers[i])
    return makers


def _part_in_text(change: Change, makers: Makers) -> Change | None:
    """Returns the part of a change that the text of the model file can express, or None. An
    element of the text, such as a default class, may make several geoms. The text can express a
    change only if it changes all geoms of an element. `makers` are {(kind, index): XML element}."""
    sets = []
    before = 0
    after = 0
    geoms_of_element = Counter(makers.values())
    for field, indices, value in change.sets:
        kind = field.partition("_")[0]
        maker_of = {i: makers[kind, i] for i in indices if (kind, i) in makers}
        changed = Counter(maker_of.values())
        included = tuple(
            i
            for i, element in maker_of.items()
            if changed[element] == geoms_of_element[element]
        )
        before = before + len(indices)
        after = after + len(included)
        if included or not indices:
            sets.append((field, included, value))
    if not sets:
        return None
    name = change.name if before == after else f"{change.name} ({after} of {before} settings)"
    return replace(change, name=name, sets=tuple(sets))


def _text_without(root: Element, changes: Sequence[Change], makers: Makers) -> str:
    """Returns the text of the file with these changes."""
    edits: dict[int, dict[str, str]] = {}
    option = Element("option")
    flags = 0
    for field, indices, value in chain.from_iterable(change.sets for change in changes):
        kind, _, name = field.partition("_")
        for i in indices:
            edits.setdefault(makers[kind, i], {})[name] = f"{value:.12g}"
        if not indices and field == "disableflags":
            flags |= int(value)
        elif not indices:
            option.set(field, f"{value:.12g}")
    if flags:
        option.append(Element("flag", dict.fromkeys(disabled(flags), "disable")))
    return _edited_text(root, edits, option if flags or option.attrib else None)
