"""Overlays: folders that hold one release of an engine each. A process that puts an overlay before
the installed packages uses the overlay's release; the user's environment stays as it is."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import InvalidSpecifier, SpecifierSet
from packaging.version import InvalidVersion, Version

from plumbob.analytic.parameters import ParameterError

INSTALLING = 900.0  # [s] longest wall time for the installation of one package
LISTING = 120.0  # [s] longest wall time for the list of releases
MAX_ROUNDS = 10  # largest number of rounds in which missing requirements are installed
MAX_VERSIONS = 60  # largest number of releases of one question
VERSION_FORM = "a condition such as >=3.10, or versions such as 3.15.0,3.16.0"


class NotInstalled(Exception):
    """Raised if a release cannot be installed; the text is the reason, in one line."""


@dataclass(frozen=True)
class Overlay:
    """A release of an engine in a folder of its own."""

    version: str
    folder: Path
    size: int  # [bytes] size of all files in the folder

    def environment(self) -> Mapping[str, str]:
        """Returns the environment variables of a process that uses this release."""
        paths = [str(self.folder), os.environ.get("PYTHONPATH", "")]
        return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}


def cache_folder() -> Path:
    """Returns the folder of all overlays."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "plumbob" / "releases"


def cached_versions(cache: Path, distribution: str) -> list[str]:
    """Returns the releases of a distribution that have overlays in the folder `cache`, old to
    new."""
    start = f"{distribution}-"
    names = [path.name.removeprefix(start) for path in cache.glob(f"{start}[0-9]*")]
    return sorted(names, key=Version)


def released_versions(distribution: str) -> list[str]:
    """Returns the releases of a distribution that can be installed here, old to new. Raises
    NotInstalled if no index of packages can be asked."""
    if importlib.util.find_spec("pip") is None:
        raise NotInstalled("only pip lists releases, and pip is not installed")
    asked = [sys.executable, "-m", "pip", "index", "versions", distribution]
    text = _output(asked, LISTING)
    listed = re.search(r"Available versions: (.*)", text)
    if listed is None:
        raise NotInstalled(f"no releases of {distribution} are listed")
    return sorted(listed[1].split(", "), key=Version)


def chosen_versions(text: str, distribution: str, cache: Path) -> tuple[list[str], str]:
    """Returns the releases, old to new, that a condition or a list of versions means, and a note if
    no index could be asked: then only releases with an overlay are meant. Raises ParameterError."""
    if not text.strip():
        raise ParameterError("versions", text, VERSION_FORM)
    named = _named_versions(text)
    if named:
        return named, ""
    try:
        condition = SpecifierSet(text)
    except InvalidSpecifier:
        raise ParameterError("versions", text, VERSION_FORM) from None
    note = ""
    try:
        available = released_versions(distribution)
    except NotInstalled as why:
        available = cached_versions(cache, distribution)
        note = f"{why}: only releases that were installed before are measured"
    chosen = [version for version in available if condition.contains(version)]
    if not 1 <= len(chosen) <= MAX_VERSIONS:
        expected = f"a condition that 1 to {MAX_VERSIONS} releases of {distribution} meet"
        raise ParameterError("versions", text, f"{expected}, not {len(chosen)}")
    return chosen, note


def _named_versions(text: str) -> list[str]:
    """Returns the versions in a list with commas, old to new; empty if the text is no such list."""
    try:
        versions = {Version(part.strip()) for part in text.split(",")}
    except InvalidVersion:
        return []
    return [str(version) for version in sorted(versions)]


def overlay(cache: Path, distribution: str, version: str) -> Overlay:
    """Returns the overlay of a release. It is installed if it is not in the folder `cache`, whole
    or not at all. Raises NotInstalled."""
    folder = cache / f"{distribution}-{version}"
    if not folder.is_dir():
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".new-", dir=cache) as new:
            _install_with_requirements(Path(new, "overlay"), distribution, version)
            try:
                Path(new, "overlay").rename(folder)
            except OSError:
                if not folder.is_dir():  # else another process has installed the same release
                    raise
    files = [path for path in folder.rglob("*") if path.is_file()]
    return Overlay(version, folder, sum(path.stat().st_size for path in files))


def _install_with_requirements(folder: Path, distribution: str, version: str) -> None:
    """Installs a release into a folder, and of its requirements those that neither the folder nor
    the present environment meets. Raises NotInstalled."""
    wanted = [f"{distribution}=={version}"]
    for number in range(MAX_ROUNDS):
        # Packages that share a folder are only installed whole by one call of pip.
        place = folder.with_name(f"round-{number}")
        _install(place, wanted)
        missing = dict.fromkeys(_missing_requirements(place))
        if not missing:
            place.rename(folder)
            return
        wanted += missing
    raise NotInstalled(f"{distribution} {version} requires more and more packages: {wanted}")


def _install(folder: Path, requirements: Sequence[str]) -> None:
    """Installs wheels into a folder, without their requirements. Raises NotInstalled."""
    options = ["--no-deps", "--only-binary", ":all:", "--target", str(folder), *requirements]
    if importlib.util.find_spec("pip") is not None:
        _output([sys.executable, "-m", "pip", "install", "--quiet", *options], INSTALLING)
    elif uv := shutil.which("uv"):
        python = ["--python", sys.executable]
        _output([uv, "pip", "install", "--quiet", *python, *options], INSTALLING)
    else:
        raise NotInstalled("neither pip nor uv is installed")


def _missing_requirements(folder: Path) -> Iterator[str]:
    """Gives the requirements of the packages in a folder that neither the folder nor the present
    environment meets."""
    inside = {
        package.name.lower().replace("_", "-")
        for package in metadata.distributions(path=[str(folder)])
    }
    for package in metadata.distributions(path=[str(folder)]):
        for text in package.requires or ():
            requirement = Requirement(text)
            name = requirement.name.lower().replace("_", "-")
            applies = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
            if applies and name not in inside and not _installed_here(requirement):
                yield f"{requirement.name}{requirement.specifier}"


def _installed_here(requirement: Requirement) -> bool:
    """Whether the present environment meets a requirement."""
    try:
        version = metadata.version(requirement.name)
    except metadata.PackageNotFoundError:
        return False
    return requirement.specifier.contains(version, prereleases=True)


def _output(command: Sequence[str], seconds: float) -> str:
    """Returns what a command prints. Raises NotInstalled with the command's last line if the
    command fails or takes longer than `seconds` [s]."""
    try:
        ended = subprocess.run(
            command,
            capture_output=True,
            stdin=subprocess.DEVNULL,
            timeout=seconds,
            encoding="utf-8",
            errors="backslashreplace",
        )
    except subprocess.TimeoutExpired:
        raise NotInstalled(f"{command[-1]}: not done within {seconds:g} s") from None
    if ended.returncode:
        lines = [line for line in ended.stderr.splitlines() if line.startswith("ERROR")]
        last = (lines or ended.stderr.splitlines() or ["no reason given"])[-1]
        raise NotInstalled(" ".join(last.removeprefix("ERROR: ").split()))
    return ended.stdout
