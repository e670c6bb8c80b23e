"""Names of the types of pytest's fixtures."""

from __future__ import annotations

import pytest

Capture = pytest.CaptureFixture[str]  # of stdout and stderr
Patch = pytest.MonkeyPatch
