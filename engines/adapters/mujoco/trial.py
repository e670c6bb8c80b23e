"""Limits of memory and time for model files, whose short texts may describe huge models.

MuJoCo reads and compiles a file in one call, which no signal ends. Every file that the model file
names is therefore checked first: it must not be a pipe. A file with elements that stand for many is
first compiled in a process of its own, which can be ended.
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
from plumbob.models.border import regular_file

MEMORY = 4_000_000_000  # [bytes] memory that compiling may take beyond that of the process
SECONDS = 20  # [s] processor time for compiling; models of robots take less than 5 s
LARGEST_ASSET = 1_000_000_000  # [bytes] largest mesh, texture, ...
MANY = ("replicate", "composite", "flexcomp", "attach")  # elements that stand for many others
SIZES = ("nrow", "ncol", "width", "height")  # attributes: sides of textures and height fields
LARGE = 4096  # longest side that is compiled without a trial
FOLDERS = ("meshdir", "texturedir", "assetdir")  # attributes: folders of asset files


def checked(name: str, path: Path) -> str:
    """Returns the tag of the root element of a model file, which the argument `name` gave, if the
    file keeps the limits. Raises ParameterError, and exceptions of reading and compiling."""
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
                    regular_file(name, asset, LARGEST_ASSET)
    if any(map(_may_explode, elements)) and multiprocessing.parent_process() is None:
        with Workers(1) as workers:
            try:
                workers.submit(_compile_in_child, str(path)).result()
            except BrokenExecutor:
                raise ValueError(f"it takes more than {SECONDS} s to compile") from None
    return elements[0].tag


def _elements(file: Path, met: list[Path]) -> Iterator[Element]:
    """Yields the elements of a file and of the files that it includes. Files in `met` are not read
    again; each file that is read is added to `met`."""
    for element in ElementTree.parse(file).getroot().iter():
        yield element
        included = file.parent / element.get("file", "")
        if element.tag in ("include", "model") and included.is_file() and included not in met:
            met.append(included)
            yield from _elements(regular_file("include", included), met)


def _may_explode(element: Element) -> bool:
    """Whether an element may stand for far more than its text says."""
    sizes = (element.get(kind, "") for kind in SIZES)
    large = any(size.isdecimal() and int(size[:9]) > LARGE for size in sizes)
    return large or element.tag in MANY


def _compile_in_child(path: str) -> None:
    """Runs in a child process: compiles a file and evaluates its model once, within MEMORY. The
    system ends the child process after SECONDS of processor time. On Windows, which has no such
    limit, nothing is compiled. Raises the exceptions of compiling."""
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
    """Lets the block allocate at most MEMORY. Raises ValueError if the block needs more. If the
    process has a lower limit already, that limit stays, and MemoryError is raised."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    except (ImportError, OSError):  # other systems than Linux have no such limit
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_AS)
    limit = pages * resource.getpagesize() + MEMORY
    if before != resource.RLIM_INFINITY and before <= limit:
        yield
        return
    resource.setrlimit(resource.RLIMIT_AS, (limit, most))
    try:
        yield
    except MemoryError:
        raise ValueError(f"it takes more than {MEMORY / 1e9:g} GB of memory") from None
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, most))
