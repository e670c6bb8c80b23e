"""References of audits kept in files, so that the same motion is certified once."""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path

from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.reference import Certificate, certified
from plumbob.engines.own_motion import OwnModel, Script
from plumbob.engines.study.checkpoint import key_of
from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.provenance import result_versions


def kept_or_certified(
    folder: Path | None, model: OwnModel, script: Script, allowance: Allowance
) -> Certificate:
    """Returns the reference of a motion: from its file in `folder` if there is one, else certified
    now and kept there. The file's name is a hash of the model, the motion, the allowed time and all
    versions. Without a folder, and in the loop with a policy, nothing is kept."""
    if folder is None or script.loop is not None:
        return certified(model, script, allowance)
    motion = script.start, script.period, script.controls
    key = key_of(dict(model.fields), motion, allowance.seconds, dict(result_versions()))
    file = folder / f"{key}.json"
    kept = _read(file)
    if kept is None:
        kept = certified(model, script, allowance)
        _write(file, to_json(kept))
    return kept


def _read(file: Path) -> Certificate | None:
    """Returns the reference in a file; None if there is none, or if it is damaged."""
    try:
        digest, _, text = file.read_text("utf-8").partition("\n")
        return from_json(text, Certificate) if digest == _digest(text) else None
    except (OSError, ValueError):
        return None


def _write(file: Path, text: str) -> None:
    """Writes a text with its checksum, whole or not at all; a folder that cannot be written to
    keeps nothing."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=file.parent)
        with open(handle, "w", encoding="utf-8") as opened:
            opened.write(f"{_digest(text)}\n{text}")
        os.replace(name, file)
    except OSError:
        return


def _digest(text: str) -> str:
    """Returns the checksum of a text."""
    return hashlib.sha256(text.encode()).hexdigest()
