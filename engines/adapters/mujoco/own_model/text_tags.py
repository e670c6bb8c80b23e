"""The tags in the text of a model file, and edits of the text that change nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from xml.parsers.expat import ParserCreate

ATTRIBUTE = re.compile(rb"""([^\s=<>"'/]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
START_TAG = re.compile(rb"""<[^\s/>]+(?:[^>"']|"[^"]*"|'[^']*')*>""")


@dataclass(frozen=True)
class Tag:
    """An element in the bytes of a file."""

    path: tuple[str, ...]  # names of the elements around it, the root first, and its own name
    attributes: Mapping[str, str]
    start: int  # place of its "<"
    inner: int  # place behind the ">" of its start tag
    close: int  # place of its end tag; of an element without an end tag, `inner`

    @property
    def name(self) -> str:
        """The name of the element."""
        return self.path[-1]


def tags(text: bytes) -> list[Tag]:
    """Returns the elements of a text in the order of their start tags, the root first. Raises
    ExpatError if the text is no XML."""
    parser = ParserCreate()
    elements: list[Tag] = []  # without their ends until their end tags are read
    open_numbers: list[int] = []

    def begin(name: str, attributes: Mapping[str, str]) -> None:
        """Notes a start tag."""
        path = elements[open_numbers[-1]].path if open_numbers else ()
        start = parser.CurrentByteIndex
        match = START_TAG.match(text, start)
        inner = match.end() if match else start
        open_numbers.append(len(elements))
        elements.append(Tag((*path, name), attributes, start, inner, close=inner))

    def end(name: str) -> None:
        """Notes an end tag."""
        number = open_numbers.pop()
        close = max(parser.CurrentByteIndex, elements[number].inner)
        elements[number] = replace(elements[number], close=close)

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.Parse(text, True)
    return elements


def edited(text: bytes, changes: Iterable[tuple[Tag, Mapping[str, str]]]) -> bytes:
    """Returns a text after attributes of some of its tags are set."""
    changes = [change for change in changes if change[1]]
    for tag, values in sorted(changes, key=lambda change: -change[0].start):
        new_tag = text[tag.start : tag.inner]
        for name, value in values.items():
            new_tag = _with_attribute(new_tag, name.encode(), value.encode())
        text = text[: tag.start] + new_tag + text[tag.inner :]
    return text


def _with_attribute(tag: bytes, name: bytes, value: bytes) -> bytes:
    """Returns a start tag with an attribute set; a new attribute becomes the last one."""
    head = re.match(rb"<[^\s/>]+", tag)
    assert head is not None
    for match in ATTRIBUTE.finditer(tag, head.end()):
        if match[1] == name:
            group = 2 if match[2] is not None else 3
            return tag[: match.start(group)] + value + tag[match.end(group) :]
    end = re.search(rb"\s*/?>\Z", tag)
    assert end is not None
    return tag[: end.start()] + b" " + name + b'="' + value + b'"' + tag[end.start() :]


def tag_bytes(name: str, attributes: Mapping[str, str], content: bytes = b"") -> bytes:
    """Returns the text of an element."""
    head = "".join([name, *(f' {key}="{value}"' for key, value in attributes.items())]).encode()
    if not content:
        return b"<" + head + b"/>"
    return b"<" + head + b">" + content + b"</" + name.encode() + b">"


def inserted(text: bytes, parent: Tag, element: bytes, first: bool = False) -> bytes:
    """Returns a text with an element in a line of its own, as the last of its parent, or as the
    first."""
    newline = b"\r\n" if b"\r\n" in text else b"\n"
    start_tag = text[parent.start : parent.inner]
    if start_tag.endswith(b"/>"):
        opened = start_tag[:-2].rstrip() + b">" + element + b"</" + parent.name.encode() + b">"
        return text[: parent.start] + opened + text[parent.inner :]
    if first:
        return text[: parent.inner] + newline + b"  " + element + text[parent.inner :]
    # The spaces before the parent's end tag belong to its line.
    head = text[: parent.close].rstrip(b" \t")
    tail = text[len(head) :]
    before = b"" if head.endswith(b"\n") else newline
    indent = text[len(head) : parent.close] + b"  "
    return head + before + indent + element + newline + tail


def with_includes(file: Path, folder: Path) -> bytes:
    """Returns the text of a file, with each <include> replaced by the content of its file, which is
    next to it or in the `folder` of the main file."""
    text = file.read_bytes()
    for tag in reversed(tags(text)):
        if tag.name != "include":
            continue
        named = tag.attributes["file"]
        places = [file.parent / named, folder / named]
        files = [place for place in places if place.is_file()]
        if not files:
            raise ValueError(f"{named} is not there")
        included = with_includes(files[0], folder)
        root = tags(included)[0]
        end = _end(text, tag)
        text = text[: tag.start] + included[root.inner : root.close].strip() + text[end:]
    return text


def _end(text: bytes, tag: Tag) -> int:
    """Returns the place behind an element, its end tag included."""
    if text[tag.start : tag.inner].endswith(b"/>"):
        return tag.inner
    return text.index(b">", tag.close) + 1
