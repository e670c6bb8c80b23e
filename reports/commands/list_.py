"""plumbob list: the names of systems, scenes, methods, models, schemas and columns."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from plumbob.engines.registry import engines, installed
from plumbob.models.registry import systems
from plumbob.reports.columns.columns import table_schemas

KINDS = ("systems", "scenes", "methods", "models", "schemas", "columns")
# Folder of the schemas of what the commands print with --json.
SCHEMAS = Path(__file__).parents[1] / "templates" / "schemas"


def command(chosen: argparse.Namespace) -> int:
    """Prints names, one a line, with a description of each."""
    kinds = [chosen.kind] if chosen.kind else KINDS
    indent = "  " if len(kinds) > 1 else ""
    for kind in kinds:
        if len(kinds) > 1:
            print(f"{kind}:")
        rows = _rows(kind)
        width = max((len(name) for name, _ in rows), default=0)
        for name, description in rows:
            print(f"{indent}{name:<{width}}  {description}".rstrip())
    return 0


def _rows(kind: str) -> list[tuple[str, str]]:
    """Returns the name and the description of everything of a `kind`."""
    if kind == "systems":
        return [(name, system.title) for name, system in systems().items()]
    if kind == "scenes":
        scenes = chain.from_iterable(system.scenes for system in systems().values())
        return [(scene.name, scene.summary) for scene in scenes]
    if kind == "models":
        # The system of a plug-in may have no model.
        files = {system.mjcf for system in systems().values() if system.mjcf.is_file()}
        return [(path.stem, str(path)) for path in sorted(files)]
    if kind == "schemas":
        return [(path.stem, str(path)) for path in sorted(SCHEMAS.iterdir())]
    if kind == "columns":
        return list(_columns())
    rows = []
    for engine in engines().values():
        missing = "" if installed(engine) else f" ({engine.package} is not installed)"
        for method in engine.methods:
            order = f"order {method.order}" if method.order else "adaptive, step is rtol"
            rows.append((method.name, f"{method.scheme}, {order}{missing}"))
    return rows


def _columns() -> Iterator[tuple[str, str]]:
    """Yields the name and the description of each table of results, and of each of its columns."""
    for table, schema in table_schemas().items():
        yield table, f"a row: {schema['about']}"
        for name, (kind, unit, meaning) in schema["columns"].items():
            yield f"{table}.{name}", f"{kind}{f' [{unit}]' if unit else ''}: {meaning}"
