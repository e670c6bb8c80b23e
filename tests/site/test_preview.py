"""What is shown with a link to a site: words, an icon and a picture."""

from __future__ import annotations

import re
import struct
import zlib

import numpy as np

from plumbob.reports.view.content import Figure
from plumbob.reports.view.palette import RED
from plumbob.reports.view.site.preview import HEIGHT, MARGIN, WIDTH, preview
from plumbob.tests.support.page_document import site_files

CIRCLE = np.linspace(0.0, 2.0 * np.pi, 73)


def test_a_circle_is_drawn_where_it_is():
    trace = {"x": 3.0 * np.cos(CIRCLE), "y": 3.0 * np.sin(CIRCLE), "line": {"color": RED}}
    png = preview(Figure("", "", (trace,), {}))
    assert struct.unpack(">II", png[16:24]) == (WIDTH, HEIGHT)
    packed = png[png.index(b"IDAT") + 4 : png.index(b"IEND") - 8]
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(HEIGHT, 1 + 3 * WIDTH)
    pixels = rows[:, 1:].reshape(HEIGHT, WIDTH, 3)
    down, right = np.nonzero((pixels == tuple(bytes.fromhex(RED[1:]))).all(axis=2))
    radii = np.hypot(down - HEIGHT / 2, right - WIDTH / 2)
    assert np.abs(radii - (HEIGHT / 2 - MARGIN)).max() < 6.0
    assert len(radii) > 2 * np.pi * 275 * 8


def test_each_page_has_words_of_its_own_and_the_icon(index):
    shown = []
    for file in site_files(index):
        text = file.read_text("utf-8")
        title, words = re.findall(
            r'<meta property="og:(?:title|description)" content="([^"]+)">', text
        )
        assert f"<title>{title}</title>" in text
        assert f'<meta name="description" content="{words}">' in text
        (icon,) = re.findall(r'<link rel="icon" href="([^"]+)"', text)
        assert (file.parent / icon).is_file()
        for picture in re.findall(r'<meta property="og:image" content="([^"]+)">', text):
            assert (file.parent / picture).is_file()
        shown.append((title, words))
    assert len(set(shown)) == len(shown)
