"""Jinja environments whose compiled templates are kept in the user's cache between processes."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import BytecodeCache, Environment
    from jinja2.bccache import Bucket


def environment(templates: Path, **options: Any) -> Environment:
    """An environment that reads the templates of a folder, with further options of jinja2's. The
    options are part of the name of what is kept: the same text is compiled otherwise with others.
    """
    import jinja2

    cache = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    names = "-".join(sorted(f"{name}={option}" for name, option in options.items()))
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(templates),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        bytecode_cache=_kept(cache / "plumbob" / "templates", f"{names}-%s"),
        **options,
    )


def _kept(folder: Path, pattern: str) -> BytecodeCache:
    """Compiled templates in a folder, each replaced whole; a folder that cannot be read or written
    costs time, and is no error."""
    from jinja2 import FileSystemBytecodeCache

    class Kept(FileSystemBytecodeCache):
        def load_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError):
                super().load_bytecode(bucket)

        def dump_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError):
                folder.mkdir(mode=0o700, parents=True, exist_ok=True)
                super().dump_bytecode(bucket)

    return Kept(str(folder), pattern)
