"""Where a page comes from: versions, machine, date, and the command that writes it again."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from types import MappingProxyType

from plumbob.engines.method import Engine, Method
from plumbob.engines.registry import engine_of
from plumbob.models.entry_points import plugin_versions as added_versions

DIGITS = ("numpy-quaddtype", "gmpy2")  # one of them computes with 34 digits
PACKAGES = ("numpy", "scipy", *DIGITS, "mujoco", "pymunk", "heyoka", "plotly")
PEERS = (
    "dartpy",
    "drake",
    "exudyn",
    "jax",
    "mujoco-mjx",
    "mujoco-warp",
    "newton",
    "pin",
    "pybullet",
)  # where installed
OF_ENGINES = MappingProxyType(
    {
        "drake": ("drake",),
        "mjx": ("mujoco", "mujoco-mjx", "jax"),
        "mjwarp": ("mujoco-warp", "mujoco", "warp-lang"),
        "newton": ("newton", "warp-lang"),
        "pinocchio": ("pin",),
    }
)
"""Distributions of engines whose package has another name."""
ABSENT = "not installed"


@dataclass(frozen=True)
class Provenance:
    """Provenance of a study: all that is needed to repeat it, or to doubt it."""

    versions: Mapping[str, str] = field(default_factory=dict)
    machine: Mapping[str, str] = field(default_factory=dict)
    date: str = ""  # UTC
    command: str = ""


def provenance(command: str) -> Provenance:
    """The provenance of what `command` measures now, on this machine."""
    versions = {"plumbob": _version("plumbob"), "Python": platform.python_version()}
    versions |= {package: _version(package) for package in PACKAGES}
    versions |= {package: now for package in PEERS if (now := _version(package)) != ABSENT}
    versions |= added_versions()
    date = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return Provenance(versions, machine(), date, command)


def versions_of(method: Method) -> Mapping[str, str]:
    """The versions that decide what a method's runs give, those of its engine among them."""
    packages = ("numpy", "scipy", *DIGITS, *packages_of(engine_of(method)))
    found = {"plumbob": _version("plumbob"), "Python": platform.python_version()}
    return found | {package: _version(package) for package in packages}


def packages_of(engine: Engine) -> Sequence[str]:
    """The distributions that an engine consists of."""
    return OF_ENGINES.get(engine.name, (engine.package,))


def version_of(engine: Engine) -> str:
    """The version of an engine's own package."""
    return _version(packages_of(engine)[0])


def changed_since(stored: Provenance) -> tuple[str, ...]:
    """Packages with another version here than in a stored study, as "mujoco 3.17.0, here
    3.18.0"."""
    return tuple(
        f"{package} {then}, here {now}"
        for package, then in stored.versions.items()
        if package not in ("plumbob", "Python", "plotly") and (now := _version(package)) != then
    )


def machine() -> Mapping[str, str]:
    """Processor, cores and operating system of this machine."""
    return {
        "processor": processor(),
        "cores": str(os.cpu_count()),
        "system": platform.platform(),
    }


def processor() -> str:
    """Model of the processor, as the operating system calls it."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine() or "unknown"


@cache  # a package that is loaded keeps its version, and to read one takes a millisecond
def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ABSENT
