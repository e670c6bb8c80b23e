"""A figure's curves as a PNG, which sites that show a link's picture ask for: no axes, no words."""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbob.reports.view.content import Figure
from plumbob.reports.view.palette import GREY

WIDTH, HEIGHT, MARGIN = 1200, 630, 40  # [px]
PEN = 4  # radius of a line's points [px]


def preview(figure: Figure) -> bytes:
    """The curves of a figure whose axes have one scale, around its origin."""
    image = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    curves = [np.array([trace["x"], trace["y"]], float) for trace in figure.traces]
    size = max(float(np.abs(curve).max()) for curve in curves) or 1.0
    scale = (HEIGHT / 2 - MARGIN) / size
    for axis in (np.array([[-size, size], [0, 0]]), np.array([[0, 0], [-size, size]])):
        _draw(image, axis * scale, "#d0d0d0", 0)
    for trace, curve in zip(figure.traces, curves, strict=True):
        _draw(image, curve * scale, trace["line"].get("color", GREY), PEN)
    return _png(image)


def _draw(image: NDArray[np.uint8], points: NDArray[Any], colour: str, pen: int) -> None:
    """Draw lines between points [px] from the middle, each place a disc of radius `pen` [px]."""
    lengths = np.hypot(*np.diff(points))
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.linspace(0.0, along[-1], int(along[-1]) + 2)
    across, up = (np.interp(places, along, values) for values in points)
    offsets = np.mgrid[-pen : pen + 1, -pen : pen + 1].reshape(2, -1)
    down, right = offsets[:, np.hypot(*offsets) <= pen + 0.5]
    rows = np.rint(HEIGHT / 2 - up).astype(int)[:, None] + down
    columns = np.rint(WIDTH / 2 + across).astype(int)[:, None] + right
    image[rows, columns] = tuple(bytes.fromhex(colour[1:]))


def _png(image: NDArray[np.uint8]) -> bytes:
    """An image of 8 bits a colour as PNG (ISO/IEC 15948), each row unfiltered."""
    height, width, _ = image.shape
    rows = np.pad(image.reshape(height, -1), ((0, 0), (1, 0)))
    parts = (
        (b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows.tobytes())),
        (b"IEND", b""),
    )
    chunks = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
