"""Convergence studies that several tests need: each is measured once in a run of the tests, by
whichever of its processes comes first, and kept under the key that a study keeps it under."""

import os
import pickle
from dataclasses import dataclass
from pathlib import Path

from plumbob.engines.study.convergence import SEED, ConvergenceStudy
from plumbob.engines.study.runner import convergence_task


@dataclass(frozen=True)
class Shared:
    """Error halves of studies without recordings, in files of a folder; costs are kept nowhere. A
    key is a hash of what is measured, and not of what a test has put in a function's place."""

    folder: Path

    def begin(self, plan, keys):
        """No study is gone on with."""
        return False

    def complete(self, study, results):
        """Nothing of a whole study is kept."""

    def there(self, keys):
        """Those of the results that are there."""
        files = {key: self.folder / key for key in keys}
        return {
            k: pickle.loads(file.read_bytes()) for k, file in files.items() if file.exists()
        }

    def keep(self, results):
        """Keep convergence studies; a file of its name is whole."""
        for key, result in results.items():
            if isinstance(result.answer, ConvergenceStudy):
                part = self.folder / f"{key}.{os.getpid()}"
                part.write_bytes(pickle.dumps(result))
                part.replace(self.folder / key)

    def convergence(self, scene, method, profile, seed=SEED):
        """The convergence study of a pair, as `run_study` measures it."""
        task = convergence_task(scene, method, profile, seed)
        result = self.there([task.key]).get(task.key)
        if result is None:
            result = task.do(*task.arguments)
            self.keep({task.key: result})
        return result.answer
