"""The provenance of a page: versions, machine, date, and the command that writes it again."""

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

DIGITS = ("numpy-quaddtype", "gmpy2")  # packages for 34 digits, of which one is used
PACKAGES = ("numpy", "scipy", *DIGITS, "mujoco", "pymunk", "heyoka", "plotly")
# where installed
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
)
OF_ENGINES = MappingProxyType(
    {
        "drake": ("drake",),
        "mjx": ("mujoco", "mujoco-mjx", "jax"),
        "mjwarp": ("mujoco-warp", "mujoco", "warp-lang"),
        "newton": ("newton", "warp-lang"),
        "pinocchio": ("pin",),
    }
)
"""Distributions of engines whose distribution has another name than their package."""
NOT_INSTALLED = "not installed"
UNLIKE = ("plotly",)  # packages whose versions do not change results


@dataclass(frozen=True)
class Provenance:
    """Everything that is needed to repeat a study, or to doubt it."""

    versions: Mapping[str, str] = field(default_factory=dict)
    machine: Mapping[str, str] = field(default_factory=dict)
    date: str = ""  # UTC
    command: str = ""


def provenance(command: str) -> Provenance:
    """The provenance of a study that `command` measures now, on this machine."""
    versions = {"plumbob": _version("plumbob"), "Python": platform.python_version()}
    versions |= {package: _version(package) for package in PACKAGES}
    peers = {package: _version(package) for package in PEERS}
    versions |= {
        package: version for package, version in peers.items() if version != NOT_INSTALLED
    }
    versions |= added_versions()
    date = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return Provenance(versions, machine(), date, command)


def result_versions() -> Mapping[str, str]:
    """The versions of all packages of this process on which results depend."""
    versions = provenance("").versions
    return {name: version for name, version in versions.items() if name not in UNLIKE}


def versions_of(method: Method) -> Mapping[str, str]:
    """The versions on which the results of a method depend, its engine's among them."""
    packages = ("numpy", "scipy", *DIGITS, *packages_of(engine_of(method)))
    found = {"plumbob": _version("plumbob"), "Python": platform.python_version()}
    return found | {package: _version(package) for package in packages}


def packages_of(engine: Engine) -> Sequence[str]:
    """The names of the distributions of which an engine consists."""
    return OF_ENGINES.get(engine.name, (engine.package,))


def version_of(engine: Engine) -> str:
    """The version of an engine's first distribution."""
    return _version(packages_of(engine)[0])


def changed_since(stored: Provenance) -> tuple[str, ...]:
    """Lines such as "mujoco 3.17.0, here 3.18.0" for packages that have another version here than
    in a stored study."""
    lines = []
    for package, then in stored.versions.items():
        now = _version(package)
        if package not in ("plumbob", "Python", "plotly") and now != then:
            lines.append(f"{package} {then}, here {now}")
    return tuple(lines)


def machine() -> Mapping[str, str]:
    """The processor, its cores and the operating system of this machine."""
    return {
        "processor": processor(),
        "cores": str(os.cpu_count()),
        "system": platform.platform(),
    }


def processor() -> str:
    """The model of the processor, as the operating system names it."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine() or "unknown"


@cache  # reading a version takes a millisecond, and it does not change while a process runs
def _version(package: str) -> str:
    """The version of a distribution; NOT_INSTALLED if it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return NOT_INSTALLED
