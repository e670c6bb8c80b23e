"""The commands that install optional packages, wherever plumbob itself was installed from."""

from __future__ import annotations

import re
from importlib import metadata


def install_command(extra: str) -> str:
    """Returns the command that installs the packages of an extra. It names the packages: plumbob
    itself is on no package index.

    >>> install_command("distributed").startswith("pip install 'dask[distributed]")
    True
    """
    try:
        requirements = metadata.requires("plumbob") or []
    except metadata.PackageNotFoundError:
        requirements = []
    of_extra = re.compile(rf"extra\s*==\s*[\"']{re.escape(extra)}[\"']")
    packages = [r.partition(";")[0].strip() for r in requirements if of_extra.search(r)]
    names = " ".join(f"'{package}'" for package in packages)
    return f"pip install {names}" if names else f"pip install '.[{extra}]' in plumbob's folder"
