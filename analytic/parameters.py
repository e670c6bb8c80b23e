"""Checks on parameters: errors name the parameter, its value and what it must be."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields
from typing import Any

SUCH = "such that "
MOST_SHOWN = 200  # characters of a value in a message
FEW = 8  # names that a message lists


class ParameterError(ValueError):
    """A parameter outside what the equations allow; its text is one line."""

    def __init__(self, name: str, value: object, requirement: str) -> None:
        requirement = " ".join(requirement.split())
        super().__init__(f"{name} = {_shown(value)}: must be {requirement}")
        self.name, self.value, self.requirement = name, value, requirement

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.name, self.value, self.requirement)

    def due_to(self, changes: Mapping[str, Any], names: Iterable[str] = ()) -> ParameterError:
        """The same error; where it names a quantity computed from the parameters, neither one of
        those that were changed nor another of `names`, one that names the changes."""
        if not changes or {"set", *changes, *names} & set(self.name.split(", ")):
            return self
        required = f"{self.name} is {self.requirement}, not {_shown(self.value)}"
        if self.requirement.startswith(SUCH):
            required = self.requirement.removeprefix(SUCH)
        return changed_beyond(changes, f"{SUCH}{required}")


def changed_beyond(changes: Mapping[str, Any], requirement: str) -> ParameterError:
    """The error of one or more changed parameters that do not meet a requirement."""
    if len(changes) == 1:
        return ParameterError(*next(iter(changes.items())), requirement)
    return ParameterError("set", dict(changes), requirement)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= MOST_SHOWN else f"{text[: MOST_SHOWN - 3]}..."


def finite(name: str, value: Any) -> float:
    """Return `value` as a finite float, or raise ParameterError naming it."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not math.isfinite(value)
    ):
        raise ParameterError(name, value, "a finite number")
    return float(value)


def positive(name: str, value: Any) -> float:
    """Return `value` as a finite float above zero, or raise ParameterError naming it."""
    if (number := finite(name, value)) <= 0.0:
        raise ParameterError(name, value, "greater than 0")
    return number


def non_negative(name: str, value: Any) -> float:
    """Return `value` as a finite float of zero or more, or raise ParameterError naming it."""
    if (number := finite(name, value)) < 0.0:
        raise ParameterError(name, value, "0 or greater")
    return number


def check_fields(
    problem: Any,
    positives: Collection[str] = (),
    non_negatives: Collection[str] = (),
    others: Collection[str] = (),
) -> None:
    """Raise ParameterError for the first field of a dataclass `problem` that is not a finite
    number, positive or non-negative as it must be; not for `others`."""
    for field in fields(problem):
        if (name := field.name) not in others:
            least = non_negative if name in non_negatives else finite
            (positive if name in positives else least)(name, getattr(problem, name))


def numbers(name: str, value: Any, shape: tuple[int, ...], requirement: str) -> Any:
    """Return `value`, nested sequences of finite numbers of a `shape`, as tuples, or raise
    ParameterError naming it, or the row of it with a number that is not finite."""

    def checked(row: str, part: Any, left: tuple[int, ...]) -> Any:
        if not left:
            return finite(row, part)
        items = tuple(part) if isinstance(part, Iterable) else ()
        if len(items) != left[0]:
            raise ParameterError(name, value, requirement)
        names = [f"{row}[{i}]" if left[1:] else row for i in range(left[0])]
        return tuple(checked(*pair, left[1:]) for pair in zip(names, items, strict=True))

    return checked(name, value, shape)


def counting(name: str, value: Any) -> int:
    """Return `value` as a whole number of 1 or more, or raise ParameterError naming it."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ParameterError(name, value, "a whole number, 1 or greater")
    return value


def known(parameters: Mapping[str, Any], names: Iterable[str]) -> None:
    """Raise ParameterError for the first name in `parameters` that is not one of `names`."""
    allowed = sorted(names)
    for name, value in parameters.items():
        if name not in allowed:
            raise ParameterError(name, value, f"one of the names {', '.join(allowed)}")


def nearest(name: str, names: Sequence[str], more: str = "...") -> str:
    """The `names` in one line for a message about an unknown `name`: all of them if they are FEW,
    else the nearest ones and a text that says where `more` are."""
    import difflib

    if len(names) <= FEW:
        return ", ".join(names)
    near = difflib.get_close_matches(name, names, n=3, cutoff=0.4) or names[:FEW]
    return ", ".join([*near, more])
