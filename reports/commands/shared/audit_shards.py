"""Shards of the audits of several models: the files in which they are stored, and their merging."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study.checkpoint import key_of, measured_shard
from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.shard import SHARD_FOLDERS, MeasuredShard, Shard, check_shards
from plumbob.models.border import regular_file
from plumbob.reports.commands.shared.several_audits import Row
from plumbob.reports.view.own_files import check_replaceable
from plumbob.reports.view.page import write_file

LARGEST_SHARD_FILE = 1_000_000_000  # [bytes] largest file with a shard of audits that is read


@dataclass(frozen=True)
class AuditShard:
    """The rows of a shard of several audits."""

    measured: MeasuredShard  # its keys are the paths of the models
    rows: tuple[Row, ...]


def shard_of_files(shard: Shard, files: Sequence[Path]) -> list[Path]:
    """Returns the model files that a shard audits. The larger a file, the longer its audit."""
    sizes = {str(file): file.stat().st_size if file.is_file() else 0 for file in files}
    own = shard.parts(sizes)
    return [file for file in files if str(file) in own]


def audit_shard_file(shard: Shard, out: str | None) -> Path:
    """Returns the file for a shard of audits in the folder --out. Raises ParameterError if there is
    no folder, or if another file is in the way."""
    if out is None:
        raise ParameterError("out", None, "given with --shard")
    file = Path(out) / f"audit-shard-{shard.number}-of-{shard.count}.json"
    check_replaceable("out", file)
    return file


def write_audit_shard(
    file: Path,
    shard: Shard,
    rows: Sequence[Row],
    files: Sequence[Path],
    options: Mapping[str, Any],
) -> None:
    """Writes the rows of a shard. `files` are the models of all shards, `options` all on which
    their audits depend."""
    contents = [(str(path), _hash(path)) for path in files]
    plan = key_of("audits", dict(options), contents)
    measured = measured_shard(shard, plan, (row.path for row in rows))
    write_file(to_json(AuditShard(measured, tuple(rows))), file.parent, file.name)


def _hash(path: Path) -> str:
    """Returns the hash of a file's bytes; empty if the file cannot be read."""
    try:
        regular_file("model", path)
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except (OSError, ParameterError):
        return ""


def audit_shards(folder: Path) -> Iterator[Path]:
    """Yields the files with shards of audits in a folder."""
    yield from sorted(folder.glob("audit-shard-*-of-*.json"))


def merged_audits(folders: Sequence[Path], out: Path) -> list[Row]:
    """Returns the rows of all shards of several audits, and copies the pages and the records of the
    audits into the folder `out`. Raises ParameterError if the shards do not make up one list of
    models."""
    shards = list[tuple[Path, AuditShard]]()
    for folder in folders:
        for file in audit_shards(folder):
            regular_file(SHARD_FOLDERS, file, LARGEST_SHARD_FILE)
            try:
                stored = from_json(file.read_text("utf-8"), AuditShard)
            except ValueError:
                expected = "as `plumbob audit --shard` wrote it"
                raise ParameterError(SHARD_FOLDERS, str(file), expected) from None
            shards.append((folder, stored))
    check_shards([(folder, stored.measured) for folder, stored in shards], key_of())
    rows = list[Row]()
    for folder, stored in shards:
        rows += stored.rows
        for name in _written_files(stored.rows):
            if (folder / name).is_file():
                check_replaceable("out", out / name)
                write_file((folder / name).read_text("utf-8"), out, name)
    return rows


def _written_files(rows: Sequence[Row]) -> Iterator[str]:
    """Yields the names of the pages of audits, and of the records beside them."""
    for row in rows:
        if row.page:
            page = Path(row.page).name
            yield page
            yield str(Path(page).with_suffix(".json"))
