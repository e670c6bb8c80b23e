"""What is measured of a study that is not complete: each piece claimed, and kept at once.

A piece is known by the hash of what defines it. Several processes may measure one study: each
claims what it begins. A claim ends with its process, since that holds a lock on a byte of its own
in a file beside the store, which the system takes back whatever ends the process.
"""

from __future__ import annotations

import hashlib
import json
import os
import random
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from sqlite3 import Connection, DatabaseError
from typing import Any, Literal, Protocol

from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.extra_runs import Request, Result
from plumbob.engines.study.results import Study
from plumbob.engines.study.store import add, extra_of, extra_row, removed
from plumbob.engines.study.store_file import decoding, transaction, writing

SOURCES = ("analytic", "models", "engines")  # folders whose files decide what is measured
COSTS = 0  # the byte that the process holds that measures costs; those of processes follow
LAST = 2**31
PAUSE = 0.2  # [s] between two looks at what another process does
Claim = Literal["ours", "theirs", "there", "cut off"]


@dataclass(frozen=True)
class Piece:
    """What a piece of a study gave: a convergence study, extra runs, a cost with the reference
    step's [ns] beside it; or the reason for which it was given up."""

    convergence: ConvergenceStudy | None = None
    extras: Mapping[Request, Result] | None = None
    cost: Cost | None = None
    reference_step: float = float("nan")
    lost: str = ""
    seconds: float = 0.0


class Pieces(Protocol):
    """Where the pieces of a study are kept, by their hash."""

    def begin(self, plan: str, keys: Sequence[str]) -> None:
        """Begin, or go on with, the study of this plan, which consists of these pieces and costs
        that follow from them."""

    def there(self, keys: Sequence[str]) -> dict[str, Piece]:
        """Those of the pieces that are there."""

    def claim(self, key: str, label: str) -> Claim:
        """Whose the piece is: ours from now on, that of another process which measures it, there
        already, or ours after a process has ended that measured it."""

    def keep(self, key: str, piece: Piece) -> None:
        """Keep a piece."""

    def keep_all(self, pieces: Mapping[str, tuple[str, Piece]]) -> None:
        """Claim and keep pieces, by key with the label of each, in one go."""

    def alone(self) -> AbstractContextManager[None]:
        """No other process that measures into the same store measures costs meanwhile."""

    def waits(self, what: str) -> None:
        """Another process is waited for, which does this."""


class Unkept:
    """Pieces that are kept nowhere: those of a study that one process makes in one go."""

    def begin(self, plan: str, keys: Sequence[str]) -> None:
        """Nothing is there to go on with."""

    def there(self, keys: Sequence[str]) -> dict[str, Piece]:
        """Nothing."""
        return {}

    def claim(self, key: str, label: str) -> Claim:
        """Always ours."""
        return "ours"

    def keep(self, key: str, piece: Piece) -> None:
        """Nothing is kept."""

    def keep_all(self, pieces: Mapping[str, tuple[str, Piece]]) -> None:
        """Nothing is kept."""

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Nobody else is known."""
        yield

    def waits(self, what: str) -> None:
        """Nobody else is known."""


class Unfinished:
    """The study that is measured into an open store."""

    def __init__(
        self, store: Connection, locks: Locks, fresh: bool, note: Callable[[str], None]
    ) -> None:
        self._store, self._locks, self._fresh, self._note = store, locks, fresh, note
        self._number = 0
        self._waited = False

    def begin(self, plan: str, keys: Sequence[str]) -> None:
        """Begin, or go on with, the study of this plan."""
        query = "select id from unfinished where plan = ? and not complete order by id desc limit 1"
        with transaction(self._store):
            found = self._store.execute(query, (plan,)).fetchone()
            if found and self._fresh:
                self._forget(found[0])
            if found and not self._fresh:
                self._number = found[0]
                self._try_again()
            else:
                self._number = self._new(plan)
        query = "select key from piece where unfinished = ? and state = 'done'"
        done = {key for (key,) in self._store.execute(query, (self._number,)).fetchall()}
        if count := len(done.intersection(keys)):
            more = f", and {rest} costs" if (rest := len(done) - count) else ""
            self._note(f"goes on: {count} of {len(keys)} pieces are there{more}")

    def _new(self, plan: str) -> int:
        now = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
        statement = "insert into unfinished (plan, created, complete) values (?, ?, 0)"
        number = self._store.execute(statement, (plan, now)).lastrowid
        assert number is not None
        return number

    def _forget(self, number: int) -> None:
        """Drop an unfinished study that no other process measures."""
        query = "select distinct owner from piece where unfinished = ? and state = 'claimed'"
        owners = self._store.execute(query, (number,)).fetchall()
        if not any(self._locks.held(owner) for (owner,) in owners):
            self._store.execute("update unfinished set complete = 1 where id = ?", (number,))

    def _dropped(self, number: int) -> None:
        for table in ("piece", "piece_extra"):
            self._store.execute(f"delete from {table} where unfinished = ?", (number,))

    def _try_again(self) -> None:
        """Pieces that an earlier process has given up are open again."""
        query = "select key, owner from piece where unfinished = ? and state = 'lost'"
        for key, owner in self._store.execute(query, (self._number,)).fetchall():
            if owner == self._locks.own or not self._locks.held(owner):
                self._store.execute(
                    "delete from piece where unfinished = ? and key = ?", (self._number, key)
                )

    def there(self, keys: Sequence[str]) -> dict[str, Piece]:
        """Those of the pieces that are there, given up ones among them."""
        query = "select key, state, seconds, body from piece where unfinished = ?"
        rows = self._store.execute(query, (self._number,)).fetchall()
        wanted, found = set(keys), {}
        for key, state, seconds, body in rows:
            if key in wanted and state != "claimed":
                lost = body if state == "lost" else ""
                found[key] = self._piece(key, None if lost else body, lost, seconds)
        return found

    def _piece(self, key: str, body: str | None, lost: str, seconds: float) -> Piece:
        query = "select kind, request, result, arrays from piece_extra "
        query += "where unfinished = ? and key = ? order by rowid"
        rows = self._store.execute(query, (self._number, key)).fetchall()
        with decoding():
            if not isinstance(single := json.loads(body or "{}"), dict):
                raise ValueError(f"no object: {body}")
            return Piece(
                from_json(json.dumps(single["convergence"]), ConvergenceStudy)
                if single.get("convergence") else None,
                dict(extra_of(*row) for row in rows),
                from_json(json.dumps(single["cost"]), Cost) if single.get("cost") else None,
                single.get("reference_step", float("nan")), lost, seconds,
            )  # fmt: skip

    def claim(self, key: str, label: str) -> Claim:
        """Whose the piece is, in one transaction."""
        where = (self._number, key)
        with transaction(self._store):
            query = "select owner, state from piece where unfinished = ? and key = ?"
            found = self._store.execute(query, where).fetchone()
            if found is None:
                self._store.execute(
                    "insert into piece values (?, ?, ?, ?, 'claimed', 0, null)",
                    (*where, label, self._locks.own),
                )
                return "ours"
            owner, state = found
            if state != "claimed":
                return "there"
            if owner == self._locks.own:
                return "ours"
            if self._locks.held(owner):
                return "theirs"
            statement = "update piece set owner = ? where unfinished = ? and key = ?"
            self._store.execute(statement, (self._locks.own, *where))
            return "cut off"

    def keep(self, key: str, piece: Piece) -> None:
        """Keep a piece that we have claimed, in one transaction."""
        self.keep_all({key: ("", piece)})

    def keep_all(self, pieces: Mapping[str, tuple[str, Piece]]) -> None:
        """Claim and keep pieces, by key with the label of each, in one transaction."""
        with transaction(self._store):
            for key, (label, piece) in pieces.items():
                names = ("convergence", "cost", "reference_step")
                parts = [f'"{name}": {to_json(getattr(piece, name))}' for name in names]
                body = piece.lost or f"{{{', '.join(parts)}}}"
                state, where = "lost" if piece.lost else "done", (self._number, key)
                self._store.execute(
                    "insert or ignore into piece values (?, ?, ?, ?, 'claimed', 0, null)",
                    (*where, label, self._locks.own),
                )
                self._store.execute(
                    "update piece set state = ?, seconds = ?, body = ? where unfinished = ? "
                    "and key = ? and state = 'claimed'",
                    (state, piece.seconds, body, *where),
                )
                extras = {} if piece.lost else piece.extras or {}
                self._store.executemany(
                    "insert into piece_extra values (?, ?, ?, ?, ?, ?)",
                    [(*where, *extra_row(*extra)) for extra in extras.items()],
                )

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Holds the byte of costs."""
        while not self._locks.take(COSTS):
            self.waits("measures costs")
            time.sleep(PAUSE)
        try:
            yield
        finally:
            self._locks.leave(COSTS)

    def waits(self, what: str) -> None:
        """Say once that another process is waited for."""
        if not self._waited:
            self._note(f"waits for another process, which {what} into the same folder")
        self._waited = True

    def finished(self, study: Study) -> tuple[int, tuple[str, ...]]:
        """Store the study, which is complete unless pieces were given up; returns its number, and
        what was given up with its reason. Where another process has stored it already, it is
        that one."""
        query = "select complete, study from unfinished where id = ?"
        with transaction(self._store):
            complete, number = self._store.execute(query, (self._number,)).fetchone()
            if complete and number is not None:
                return number, ()
            if number is not None:
                removed(self._store, number)
            lost = self._store.execute(
                "select label, body from piece where unfinished = ? and state = 'lost'",
                (self._number,),
            ).fetchall()
            query = "select request, rowid, kind from piece_extra where unfinished = ?"
            rows = self._store.execute(query, (self._number,)).fetchall()
            packed = {extra_of(kind, text, None, None)[0]: row for text, row, kind in rows}
            number = add(self._store, study, number, packed)
            self._store.execute(
                "update unfinished set study = ?, complete = ? where id = ?",
                (number, not lost, self._number),
            )
        return number, tuple(f"{label}: {why}" for label, why in lost)

    def left(self) -> None:
        """Leave what we have claimed and not measured to others, and drop the pieces of complete
        studies unless another process reads them; on a full disk our claims end with this
        process."""
        with suppress(DatabaseError), transaction(self._store):
            self._store.execute(
                "delete from piece where owner = ? and state = 'claimed'", (self._locks.own,)
            )
            if self._locks.alone():
                query = "select id from unfinished where complete"
                for (number,) in self._store.execute(query).fetchall():
                    self._dropped(number)


class Locks:
    """Locks on single bytes of a file, which end with the process that holds them."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.own = random.SystemRandom().randrange(1, LAST)
        self._handle = self._opened()

    def _opened(self) -> int:
        while True:
            handle = os.open(self._file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
            self._handle = handle
            try:
                # Nobody removes it, nor has removed it meanwhile.
                if self.take(self.own) and os.path.samestat(os.stat(self._file), os.fstat(handle)):
                    return handle
            except FileNotFoundError:
                pass
            os.close(handle)
            time.sleep(0.01)

    def take(self, byte: int) -> bool:
        """Whether the byte is ours now; always where there are no such locks."""
        try:
            import fcntl
        except ImportError:  # Windows
            return True
        try:
            fcntl.lockf(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
        except OSError:
            return False
        return True

    def leave(self, byte: int) -> None:
        """Give a byte back."""
        try:
            import fcntl
        except ImportError:
            return
        fcntl.lockf(self._handle, fcntl.LOCK_UN, 1, byte)

    def held(self, byte: int) -> bool:
        """Whether another process holds a byte."""
        if byte == self.own:
            return False
        if not self.take(byte):
            return True
        self.leave(byte)
        return False

    def alone(self) -> bool:
        """Whether no other process holds a byte; from now on none can take one."""
        try:
            import fcntl

            fcntl.lockf(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except ImportError:
            return True
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Give all back, and remove the file where nobody else holds a byte of it."""
        if self.alone():
            with suppress(OSError):
                self._file.unlink(missing_ok=True)
        os.close(self._handle)


@contextmanager
def measured_into(
    file: Path, fresh: bool = False, note: Callable[[str], None] = lambda _: None
) -> Iterator[Unfinished]:
    """What is kept in the store `file`, made if need be; `fresh` begins a new study where one is
    not complete, `note` is given what a user wants to know. Raises ParameterError for a file that
    is no store or cannot be written."""
    with ExitStack() as held:
        store = held.enter_context(writing(file))
        locks = Locks(file.with_name(f".{file.name}.lock"))
        held.callback(locks.close)
        kept = Unfinished(store, locks, fresh, note)
        try:
            yield kept
        finally:
            kept.left()


def key_of(*what: Any) -> str:
    """The hash of what defines a piece: dataclasses, and what JSON knows."""
    text = json.dumps([json.loads(to_json(one)) for one in what], sort_keys=True)
    return hashlib.sha256(f"{_source()}{text}".encode()).hexdigest()


@cache
def _source() -> str:
    """The hash of plumbob's own files that decide what is measured: a version between two releases
    has the number of the last."""
    root, digest = Path(__file__).parents[2], hashlib.sha256()
    for folder in SOURCES:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix in (".py", ".xml", ".toml") and file.is_file():
                digest.update(f"{file.relative_to(root)}\0".encode() + file.read_bytes())
    return digest.hexdigest()
