"""A model file without what can be left out of it: its own text, changed where it has to be.

MuJoCo's own writer rounds what a compiled model is written from, which moves it. Here attributes of
<geom> and <pair> are set in the user's text, an included file that has such an element takes the
place of its <include>, and options are added at the end, where the last ones count.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.parsers import expat

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.own_model.model import silent
from plumbob.engines.own_motion import Change

MARK = 1e6  # [m] a margin that no model has, and numbers from there on: an element is known by it
ATTRIBUTE = re.compile(rb"""(\s)([\w.:-]+)(\s*=\s*)("[^"]*"|'[^']*')""")
TAG = re.compile(rb"""<[\w.:-]+(?:\s+[\w.:-]+\s*=\s*(?:"[^"]*"|'[^']*'))*\s*/?>""")
Place = tuple[Path, int]  # a file, and where an element begins in it
Attributes = Mapping[str, str]


@dataclass
class _Element:
    """An element of a file's text: where its tag, what is in it, and all of it begins or ends."""

    name: str
    within: tuple[str, ...]  # names of the elements around it, outermost first
    begin: int
    tag_end: int
    close: int = 0
    end: int = 0


def write(source: Path, left_out: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Write the text of the model file `source` without these to `target`, and return those that
    its text can omit: geoms that one element makes with others have to stay. Raises ParameterError
    where nothing is left, or it cannot be written, or would not compile there."""
    part = target.with_name(f".{target.stem}-{os.getpid()}.xml")
    try:
        makers = _made_by_places(source, part)
        kept = tuple(c for change in left_out if (c := _in_text(change, makers)))
        if not kept:
            what = "omitted: what this motion does not need has no text of its own in the file"
            raise ParameterError("write trimmed", str(target), what)
        _compiled(part, _without(source, kept, makers))
        part.replace(target)
    except (OSError, ValueError, expat.ExpatError) as error:
        reason = " ".join(str(error).split())
        what = f"beside the model, where the files are that it names ({reason})"
        raise ParameterError("write trimmed", str(target), what) from None
    finally:
        part.unlink(missing_ok=True)
    return kept


def _compiled(path: Path, text: bytes) -> mujoco.MjModel:
    path.write_bytes(text)
    with silent():
        return mujoco.MjModel.from_xml_path(str(path))


def _made_by_places(source: Path, part: Path) -> Mapping[tuple[str, int], tuple[Place, int]]:
    """{(kind, number in the compiled model): the element that makes it, and how many it makes}, for
    geoms and pairs, found by a mark that survives."""
    places: list[Place] = []

    def marked(place: Place, element: _Element) -> Attributes:
        if not _is_editable(element):
            return {}
        places.append(place)
        return {"margin": f"{MARK + len(places) - 1:.0f}"}

    model = _compiled(part, _rewritten(source, source.parent, None, marked, lambda _: True)[0])
    makers = {}
    for kind in ("geom", "pair"):
        numbers = np.asarray(getattr(model, f"{kind}_margin")) - MARK
        for i, number in enumerate(numbers):
            if number >= 0:
                makers[kind, i] = (places[int(number)], int(np.count_nonzero(numbers == number)))
    return makers


def _is_editable(element: _Element) -> bool:
    if element.name == "geom":
        return "worldbody" in element.within and "composite" not in element.within
    return element.name == "pair" and "contact" in element.within


def _in_text(change: Change, makers: Mapping[tuple[str, int], tuple[Place, int]]) -> Change | None:
    """The part of a change that the text can be given: elements all of whose geoms are in it."""
    sets, before, after = [], 0, 0
    for field, indices, value in change.sets:
        kind = field.partition("_")[0]
        places = [makers[kind, i][0] for i in indices if (kind, i) in makers]
        some = tuple(
            i
            for i in indices
            if (kind, i) in makers and places.count(makers[kind, i][0]) == makers[kind, i][1]
        )
        before, after = before + len(indices), after + len(some)
        if some or not indices:
            sets.append((field, some, value))
    if not sets:
        return None
    name = change.name if before == after else f"{change.name} ({after} of {before} settings)"
    return replace(change, name=name, sets=tuple(sets))


def _without(
    source: Path, changes: Sequence[Change], makers: Mapping[tuple[str, int], tuple[Place, int]]
) -> bytes:
    """The text of the file with these changes."""
    edits: dict[Place, dict[str, str]] = {}
    option, flags = dict[str, str](), 0
    for field, indices, value in (setting for change in changes for setting in change.sets):
        kind, _, name = field.partition("_")
        for i in indices:
            edits.setdefault(makers[kind, i][0], {})[name] = f"{value:.12g}"
        if not indices and field == "disableflags":
            flags |= int(value)
        elif not indices:
            option[field] = f"{value:.12g}"
    files = {file for file, _ in edits}
    more = f"  <option{_written(option)}>{_flags(flags)}</option>\n".encode()
    return _rewritten(
        source,
        source.parent,
        None,
        lambda place, _: edits.get(place, {}),
        lambda named: bool(named & files),
        more if option or flags else b"",
    )[0]


def _written(attributes: Attributes) -> str:
    return "".join(f' {name}="{value}"' for name, value in attributes.items())


def _flags(bits: int) -> str:
    names = {
        name.removeprefix("mjDSBL_").lower(): "disable"
        for name, bit in mujoco.mjtDisableBit.__members__.items()
        if name.startswith("mjDSBL_") and bits & int(bit)
    }
    return f"<flag{_written(names)}/>" if names else ""


def _rewritten(
    file: Path,
    folder: Path,
    included: tuple[str, ...] | None,
    change: Callable[[Place, _Element], Attributes],
    inline: Callable[[set[Path]], bool],
    more: bytes = b"",
) -> tuple[bytes, set[Path]]:
    """The text of a file, or what takes the place of an <include> within the elements `included`,
    and all files of which it has the text. Attributes are set as `change` says; an include of the
    main file, in `folder`, stays unless `inline` of its files; `more` is added at the end."""
    text, files, parts = file.read_bytes(), {file}, list[bytes]()
    elements = _elements(text, included)
    root = elements[0]
    done = 0 if included is None else root.tag_end
    for element in elements[1:]:
        if element.begin < done:
            continue
        tag, end = text[element.begin : element.tag_end], element.tag_end
        if element.name == "include":
            named = _attributes(tag)["file"]
            other = next((p / named for p in (file.parent, folder) if (p / named).is_file()), None)
            if other is None:
                raise ValueError(f"{named} is not there")
            tag, others = _rewritten(other, folder, element.within, change, inline)
            if included is None and not inline(others):
                continue
            end, files = element.end, files | others
        else:
            tag = _set(tag, change((file, element.begin), element))
        parts += [text[done : element.begin], tag]
        done = end
    parts += [text[done : root.close], more]
    return b"".join((*parts, text[root.close :] if included is None else b"")), files


def _elements(text: bytes, included: tuple[str, ...] | None) -> list[_Element]:
    """All elements of a text in order; what is in the root of an included one is within others."""
    elements, open_ = list[_Element](), list[_Element]()
    parser = expat.ParserCreate()

    def begin(name: str, _: object) -> None:
        at = parser.CurrentByteIndex
        tag = TAG.match(text, at)
        if tag is None:
            raise ValueError(f"<{name}> ends nowhere")
        around = tuple(e.name for e in (open_ if included is None else open_[1:]))
        open_.append(_Element(name, (*(included or ()), *around), at, tag.end()))
        elements.append(open_[-1])

    def end(_: str) -> None:
        element = open_.pop()
        element.close = element.end = element.tag_end
        if not text[: element.tag_end].endswith(b"/>"):
            element.close = parser.CurrentByteIndex
            element.end = text.index(b">", element.close) + 1

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.Parse(text, True)
    return elements


def _attributes(tag: bytes) -> Attributes:
    return {name.decode(): value[1:-1].decode() for _, name, _, value in ATTRIBUTE.findall(tag)}


def _set(tag: bytes, attributes: Attributes) -> bytes:
    """A start tag with these attributes, in the place of those of the same names."""
    new = dict(attributes)

    def changed(match: re.Match[bytes]) -> bytes:
        space, name, equals, _ = match.groups()
        value = new.pop(name.decode(), None)
        return match[0] if value is None else b'%b%b%b"%b"' % (space, name, equals, value.encode())

    old = ATTRIBUTE.sub(changed, tag)
    end = -2 if old.endswith(b"/>") else -1
    return old[:end].rstrip() + _written(new).encode() + old[end:]
