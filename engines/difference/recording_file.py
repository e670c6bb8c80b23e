"""Files of recorded motions: .npz with an array for each part, .csv with a column for each number,
.json with a list for each part."""

from __future__ import annotations

import io
import json
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.difference.recording import BARE_COLUMNS, PARTS
from plumbob.models.border import must_be, regular_file

SUFFIXES = (".npz", ".csv", ".json")
# [bytes] of a file, and of its arrays when unpacked: an hour of a humanoid at 100 Hz takes half
LARGEST_RECORDING = 200_000_000
# [bytes] of a .csv or .json file, which takes several times that to read
LARGEST_TEXT = 100_000_000
COLUMN = re.compile(rf"\W*({'|'.join(PARTS)})[^\w]*_?(\d*)\W*", re.ASCII)


def read_recording(name: str, file: Path) -> Mapping[str, Any]:
    """Returns the arrays of a recorded motion by their names, from the file that the argument
    `name` gave. A .csv file without a head has one array, BARE_COLUMNS. Raises ParameterError."""
    expected = f"a {', '.join(SUFFIXES)} file of a recorded motion"
    if file.suffix not in SUFFIXES:
        raise ParameterError(name, str(file), expected)
    binary = file.suffix == ".npz"
    regular_file(name, file, LARGEST_RECORDING if binary else LARGEST_TEXT)
    with must_be(expected, name, str(file)), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy warns of a file without rows
        if binary:
            return _packed_parts(file)
        if file.suffix == ".json":
            parts = json.loads(file.read_text("utf-8"))
            if not isinstance(parts, dict):
                raise ValueError("an object with a list for each part")
            return {part: parts[part] for part in PARTS if part in parts}
        return _columns(file)


def packed_array(file: Path, name: str, most: int) -> Array:
    """Returns the array `name` of a .npz file as floats. Raises ValueError if it is not an array of
    numbers of at most `most` bytes."""
    with ZipFile(file) as arrays, arrays.open(f"{name}.npy") as packed:
        content = packed.read(most + 1)
    if len(content) > most:
        raise ValueError(f"more than {most} bytes when unpacked")
    try:
        values = np.load(io.BytesIO(content), allow_pickle=False)
    except MemoryError:
        raise ValueError("its header states more numbers than there are") from None
    return np.asarray(values).astype(float, casting="same_kind")


def _packed_parts(file: Path) -> Mapping[str, Array]:
    """Returns the parts of a recording in a .npz file."""
    with ZipFile(file) as arrays:
        names = {Path(name).stem for name in arrays.namelist()}
    parts: dict[str, Array] = {}
    for part in PARTS:
        if part in names:
            used = sum(values.nbytes for values in parts.values())
            parts[part] = packed_array(file, part, LARGEST_RECORDING - used)
    return parts


def _columns(file: Path) -> Mapping[str, Array]:
    """Returns the columns of a .csv file by the parts in its head (`time,qpos_0,qpos_1,...`); a
    file without a head has one array, BARE_COLUMNS."""
    with file.open(encoding="utf-8") as opened:
        head = opened.readline(LARGEST_TEXT).split(",")
    try:
        float(head[0])
    except ValueError:
        pass
    else:
        return {BARE_COLUMNS: np.loadtxt(file, delimiter=",", ndmin=2)}
    places: dict[str, dict[int, int]] = {}
    for column, text in enumerate(head):
        match = COLUMN.fullmatch(text.strip())
        if match:
            numbers = places.setdefault(match[1], {})
            if numbers.setdefault(int(match[2] or 0), column) != column:
                raise ValueError(f"two columns {text.strip()}")
    values = np.loadtxt(file, delimiter=",", ndmin=2, skiprows=1)
    return {
        part: values[:, [numbers[number] for number in sorted(numbers)]]
        for part, numbers in places.items()
    }
