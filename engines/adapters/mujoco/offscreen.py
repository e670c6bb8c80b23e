"""Chooses the platform of OpenGL on which MuJoCo renders without a window, before MuJoCo is
imported."""

from __future__ import annotations

import os
import subprocess
import sys

from plumbob.engines.method import Unsupported

# Platforms of OpenGL without a window, each with its Debian packages.
PLATFORMS = (("egl", "libegl1 libgl1-mesa-dri"), ("osmesa", "libosmesa6"))
RENDERS_NOTHING = ("disable", "disabled", "off", "false", "0")  # values of MUJOCO_GL
PROBE_SECONDS = 60.0  # [s] longest time in which a platform shows that it works
RENDERER_TRIAL = (
    "import mujoco; mujoco.Renderer(mujoco.MjModel.from_xml_string('<mujoco/>'), 8, 8).close()"
)


def choose_platform() -> None:
    """Sets the platform of OpenGL on which MuJoCo renders without a window. MuJoCo must not be
    imported yet. Raises Unsupported, which says what is missing. A platform is tried in a process
    of its own, which a driver may end; only one can be loaded into a process."""
    chosen = os.environ.get("MUJOCO_GL", "")
    if chosen.lower() in RENDERS_NOTHING:
        raise Unsupported(f"nothing is rendered: the environment has MUJOCO_GL={chosen}")
    names = [chosen] if chosen else [name for name, _ in PLATFORMS]
    if not chosen and sys.platform != "linux":
        names = ["glfw"]
    for name in names:
        environment = {**os.environ, "MUJOCO_GL": name}
        try:
            probe = subprocess.run(
                [sys.executable, "-c", RENDERER_TRIAL],
                env=environment,
                capture_output=True,
                timeout=PROBE_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            continue
        if probe.returncode == 0:
            os.environ["MUJOCO_GL"] = name
            return
    needed = " or ".join(f"{name} ({packages})" for name, packages in PLATFORMS)
    raise Unsupported(
        f"no offscreen renderer works ({', '.join(names)}): it needs {needed}, here by their "
        "Debian packages"
    )
