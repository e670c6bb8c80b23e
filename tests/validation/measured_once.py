"""Convergence studies that several tests need: each is measured once in a run of the tests, by
whichever of its processes comes first, and kept under the key that a study keeps it under."""

from __future__ import annotations

import os
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import SEED, ConvergenceStudy
from plumbob.engines.study.runner import Profile, _convergence_task
from plumbob.engines.study.unfinished import Piece, Unkept
from plumbob.models.scene import Scene


@dataclass(frozen=True)
class Shared(Unkept):
    """Error halves of studies without recordings, in files of a folder; costs are kept nowhere. A
    key is a hash of what is measured, and not of what a test has put in a function's place."""

    folder: Path

    def there(self, keys: Sequence[str]) -> dict[str, Piece]:
        """Those of the pieces that are there."""
        files = {key: self.folder / key for key in keys}
        return {k: pickle.loads(file.read_bytes()) for k, file in files.items() if file.exists()}

    def keep(self, key: str, piece: Piece) -> None:
        """Keep a convergence study; a file of its name is whole."""
        if piece.convergence is not None and not piece.extras:
            part = self.folder / f"{key}.{os.getpid()}"
            part.write_bytes(pickle.dumps(piece))
            part.replace(self.folder / key)

    def convergence(
        self, scene: Scene, method: Method, profile: Profile, seed: int = SEED
    ) -> ConvergenceStudy:
        """The convergence study of a pair, as `run_study` measures it."""
        task = _convergence_task(scene, method, profile, (), seed)
        piece = self.there([task.key]).get(task.key)
        if piece is None:
            piece = task.do(*task.arguments)
            self.keep(task.key, piece)
        assert piece.convergence is not None
        return piece.convergence
