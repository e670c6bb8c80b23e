"""The linear pendulum as an equation of motion: the simple one's, with theta for sin theta."""

from __future__ import annotations

from plumbob.engines.adapters.ode.simple_pendulum import build

__all__ = ["build"]
