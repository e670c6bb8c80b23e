"""Units of parameters and of exactly known numbers, and meanings of parameters."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from plumbob.reports.view.tables import paragraphs


@cache
def parameter_units() -> Mapping[str, str]:
    """Returns the unit of each parameter and fact whose unit is listed, by name."""
    units = dict[str, str]()
    for line in paragraphs("units"):
        unit, _, names = line.partition(": ")
        units |= dict.fromkeys(names.split(", "), unit)
    return MappingProxyType(units)


@cache
def parameter_meanings() -> Mapping[str, str]:
    """Returns the meaning of each parameter of a scene, by name."""
    meanings = dict(line.split(": ", 1) for line in paragraphs("parameters"))
    return MappingProxyType(meanings)
