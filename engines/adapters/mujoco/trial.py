"""Model files that may make far more than their text says: limits of memory and time, and a trial.

MuJoCo reads and compiles in one call, which no signal ends. Files that it names are not opened
where they are pipes, and elements that stand for many are compiled in a process of its own first.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import mujoco

from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.workers import Workers
from plumbob.models.border import regular

MEMORY = 4_000_000_000  # [bytes] that a model may take to compile, beside what there is
SECONDS = 20  # of processor time; the models of robots take less than 5
LARGEST_ASSET = 1_000_000_000  # [bytes] of a mesh, a texture, ...
MANY = ("replicate", "composite", "flexcomp", "attach")  # elements that stand for many
SIZES = ("nrow", "ncol", "width", "height")  # attributes of what is built in
LARGE = 4096  # of them: more is tried
FOLDERS = ("meshdir", "texturedir", "assetdir")


def checked(name: str, path: Path) -> str:
    """The kind of the root of a model file, given as the argument `name`, if it can be read within
    limits; raises ParameterError, and what reading and compiling raise."""
    elements = list(_elements(path, [path]))
    folders = {element.get(kind, "") for element in elements for kind in FOLDERS}
    names = {element.get(kind, "") for element in elements for kind in ("file", "filename")}
    for named in names - {""}:
        for folder in folders:
            for asset in (
                path.parent / folder / named,
                path.parent / folder / Path(named).name,
            ):
                if asset.exists():
                    regular(name, asset, LARGEST_ASSET)
    if any(map(_may_explode, elements)) and multiprocessing.parent_process() is None:
        with Workers(1) as workers:
            try:
                workers.submit(_compiled, str(path)).result()
            except BrokenExecutor:
                raise ValueError(f"it takes more than {SECONDS} s to compile") from None
    return elements[0].tag


def _elements(file: Path, met: list[Path]) -> Iterator[Element]:
    """The elements of a file, and of those that it includes, each of which is read once."""
    for element in ElementTree.parse(file).getroot().iter():
        yield element
        other = file.parent / element.get("file", "")
        if element.tag in ("include", "model") and other.is_file() and other not in met:
            met.append(other)
            yield from _elements(regular("include", other), met)


def _may_explode(element: Element) -> bool:
    sizes = (element.get(kind, "") for kind in SIZES)
    large = any(size.isdecimal() and int(size[:9]) > LARGE for size in sizes)
    return large or element.tag in MANY


def _compiled(path: str) -> None:
    """Compile a file and evaluate it once, in a process of its own, which ends with its time."""
    try:
        import resource
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    with limited_memory(), collected():
        model = mujoco.MjSpec.from_file(path).compile()
        mujoco.mj_forward(model, mujoco.MjData(model))


@contextmanager
def limited_memory() -> Iterator[None]:
    """Let the block allocate `MEMORY` at most; raises ValueError where that does not suffice, and
    MemoryError where a lower limit that was there does not."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    except (ImportError, OSError):  # no Linux: without a limit
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = pages * resource.getpagesize() + MEMORY
    if lower := before != resource.RLIM_INFINITY and before <= limit:
        limit = before
    resource.setrlimit(resource.RLIMIT_AS, (limit, most))
    try:
        yield
    except MemoryError:
        if lower:
            raise
        raise ValueError(f"it takes more than {MEMORY / 1e9:g} GB of memory") from None
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, most))
