"""Results of the stages of a training run, which can be resumed."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Stored:
    """Results of finished stages.

    Attributes
    ----------
    folder : Path or None
        Where they are kept; without a folder, all stages run.
    report : callable
        Receives the name of each stage.
    """

    folder: Path | None
    report: Callable[[str], None]

    def __call__(self, stage: str, run: Callable[[], Result]) -> Result:
        """Result of a stage, from its file or, if there is none, by running it."""
        self.report(stage)
        if self.folder is None:
            return run()
        file = self.folder / f"{stage.replace(' ', '-')}.pickle"
        if file.exists():
            found: Result = pickle.loads(file.read_bytes())
            return found
        found = run()
        self.folder.mkdir(parents=True, exist_ok=True)
        partial = file.with_suffix(".part")
        partial.write_bytes(pickle.dumps(found))
        partial.replace(file)
        return found
