"""Checks on parameters; an error names the parameter, its value and the requirement."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

SUCH = "such that "  # beginning of a requirement that is a condition on several parameters
MOST_SHOWN = 200  # largest number of characters of a value in a message
MAX_LISTED_NAMES = 8  # largest number of names that a message lists in full


class ParameterError(ValueError):
    """Raised for a parameter that the equations do not allow; the text is one line."""

    def __init__(self, name: str, value: object, requirement: str) -> None:
        requirement = " ".join(requirement.split())
        super().__init__(f"{name} = {_shown(value)}: must be {requirement}")
        self.name, self.value, self.requirement = name, value, requirement

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.name, self.value, self.requirement)

    def due_to(self, changes: Mapping[str, Any], names: Iterable[str] = ()) -> ParameterError:
        """Returns this error, or an error that names the changed parameters.

        If this error names a changed parameter or one of `names`, it is returned. If it names a
        quantity that is computed from the parameters, the result names the `changes` instead.
        """
        names_a_parameter = {"set", *changes, *names} & set(self.name.split(", "))
        if not changes or names_a_parameter:
            return self
        condition = f"{self.name} is {self.requirement}, not {_shown(self.value)}"
        if self.requirement.startswith(SUCH):
            condition = self.requirement.removeprefix(SUCH)
        return changed_beyond(changes, f"{SUCH}{condition}")


def changed_beyond(changes: Mapping[str, Any], requirement: str) -> ParameterError:
    """Returns the error for one or more changed parameters that do not meet a requirement."""
    if len(changes) == 1:
        return ParameterError(*next(iter(changes.items())), requirement)
    return ParameterError("set", dict(changes), requirement)


def _shown(value: object) -> str:
    """Returns a value as text for a message, cut to MOST_SHOWN characters."""
    text = repr(value)
    return text if len(text) <= MOST_SHOWN else f"{text[: MOST_SHOWN - 3]}..."


def finite(name: str, value: Any) -> float:
    """Returns `value` as a finite float; raises ParameterError with the `name` otherwise."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value):
        raise ParameterError(name, value, "a finite number")
    return float(value)


def positive(name: str, value: Any) -> float:
    """Returns `value` as a finite float above zero; raises ParameterError otherwise."""
    number = finite(name, value)
    if number <= 0.0:
        raise ParameterError(name, value, "greater than 0")
    return number


def non_negative(name: str, value: Any) -> float:
    """Returns `value` as a finite float of zero or more; raises ParameterError otherwise."""
    number = finite(name, value)
    if number < 0.0:
        raise ParameterError(name, value, "0 or greater")
    return number


def check_fields(
    problem: Any,
    positives: Collection[str] = (),
    non_negatives: Collection[str] = (),
    others: Collection[str] = (),
) -> None:
    """Raises ParameterError for the first field of a dataclass `problem` with a wrong value.

    Fields must be finite numbers: above zero for `positives`, zero or more for `non_negatives`.
    `others` are not checked.
    """
    for field in fields(problem):
        name = field.name
        if name in others:
            continue
        value = getattr(problem, name)
        if name in positives:
            positive(name, value)
        elif name in non_negatives:
            non_negative(name, value)
        else:
            finite(name, value)


def numbers(name: str, value: Any, shape: tuple[int, ...], requirement: str) -> Any:
    """Returns `value`, nested sequences of finite numbers, as nested tuples of a `shape`.

    Raises ParameterError with the `name` if the shape is different. If a number is not finite, the
    error names its row.
    """

    def checked(row: str, part: Any, part_shape: tuple[int, ...]) -> Any:
        """Returns a `part` of the value as nested tuples. `row` is its name in a message."""
        if not part_shape:
            return finite(row, part)
        count, *inner_shape = part_shape
        items = tuple(part) if isinstance(part, Iterable) else ()
        if len(items) != count:
            raise ParameterError(name, value, requirement)
        checked_items = []
        for i, item in enumerate(items):
            item_name = f"{row}[{i}]" if inner_shape else row
            checked_items.append(checked(item_name, item, tuple(inner_shape)))
        return tuple(checked_items)

    return checked(name, value, shape)


def counting(name: str, value: Any) -> int:
    """Returns `value` as a whole number of 1 or more; raises ParameterError otherwise."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ParameterError(name, value, "a whole number, 1 or greater")
    return value


def known(parameters: Mapping[str, Any], names: Iterable[str]) -> None:
    """Raises ParameterError for the first name in `parameters` that is not one of `names`."""
    allowed = sorted(names)
    for name, value in parameters.items():
        if name not in allowed:
            raise ParameterError(name, value, f"one of the names {', '.join(allowed)}")


def nearest(name: str, names: Sequence[str], more: str = "...") -> str:
    """Returns known `names` in one line, for a message about an unknown `name`.

    The line has all names if there are at most MAX_LISTED_NAMES; else the most similar names, and
    the text `more`."""
    import difflib

    if len(names) <= MAX_LISTED_NAMES:
        return ", ".join(names)
    similar = (
        difflib.get_close_matches(name, names, n=3, cutoff=0.4) or names[:MAX_LISTED_NAMES]
    )
    return ", ".join([*similar, more])
