"""A picture of a model at a state, drawn without a screen by another process, where EGL is there.

`python -m` this module with a compiled model, a state and a picture to write draws it.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.reference import Array

WIDTH, HEIGHT = 480, 320  # [px]
DISTANCE = 2.8  # of the camera, over the reach of what moves
ELEVATION = -15.0  # [degrees]
PATIENCE = 60.0  # [s]


def picture(model: Any, state: Array) -> bytes | None:
    """A PNG of the compiled `model` at the generalised coordinates `state`; None where it cannot be
    drawn."""
    with tempfile.TemporaryDirectory() as folder:
        files = [str(Path(folder) / name) for name in ("model.mjb", "state.npy", "picture.png")]
        mujoco.mj_saveModel(model, files[0], None)
        np.save(files[1], state)
        try:
            subprocess.run(
                [sys.executable, "-m", __name__, *files],
                check=True,
                timeout=PATIENCE,
                env={**os.environ, "MUJOCO_GL": "egl"},
                capture_output=True,
            )
            return Path(files[2]).read_bytes()
        except (subprocess.SubprocessError, OSError):
            return None


def drawn(model: Any, state: Array) -> Array:
    """The picture as bytes of red, green and blue, shape (HEIGHT, WIDTH, 3)."""
    model.vis.global_.offwidth, model.vis.global_.offheight = WIDTH, HEIGHT
    data = mujoco.MjData(model)
    data.qpos[:] = state
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    mujoco.mjv_defaultFreeCamera(model, camera)
    moving = model.body_weldid[model.geom_bodyid] != 0
    if moving.any():
        places, sizes = data.geom_xpos[moving], model.geom_rbound[moving]
        camera.lookat[:] = centre = (places.max(axis=0) + places.min(axis=0)) / 2
        reach = float((np.linalg.norm(places - centre, axis=1) + sizes).max())
        camera.distance, camera.elevation = DISTANCE * reach, ELEVATION
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, camera)
        return np.asarray(renderer.render())


def png(pixels: Array) -> bytes:
    """A PNG of bytes of red, green and blue, shape (height, width, 3)."""

    def chunk(name: bytes, content: bytes) -> bytes:
        body = name + content
        return struct.pack(">I", len(content)) + body + struct.pack(">I", zlib.crc32(body))

    height, width, _ = pixels.shape
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    # Each row begins with its filter: none.
    rows = np.hstack([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)])
    parts = [(b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)


if __name__ == "__main__":
    given, where, target = sys.argv[1:]
    found = drawn(mujoco.MjModel.from_binary_path(given), np.load(where))
    Path(target).write_bytes(png(found))
