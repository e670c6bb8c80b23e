"""The motion of a user's model in another engine that builds it from the records of its mechanism:
what is wrong there is the engine's step, its contacts and its precision, and no importer's."""

from __future__ import annotations

import time

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.audit.term_differences import Held
from plumbob.engines.method import Unsupported
from plumbob.engines.peer_model import RefusedFile
from plumbob.engines.stepper import State
from plumbob.models.border import border


def built_motion(builds: BuildsMechanisms, held: Held) -> tuple[Array, str]:
    """States at the ends of the control periods in an engine that builds the mechanism of a model,
    shape (periods + 1, n), nan after the last one that is known, and why they end early. Where the
    engine cannot express a part of the mechanism, only the start is known and the reason names that
    part."""
    states = np.full(held.states.shape, np.nan)
    states[0] = held.script.start
    ends = time.process_time() + held.seconds
    try:
        with border(RefusedFile, Unsupported):
            mechanism = held.model.mechanism()
            start = _split(states[0], held)
            stepper = builds.build(mechanism, start, held.model.step)
            stepper.put(start)
            for k, control in enumerate(held.script.controls):
                stepper.advance(np.tile(control, (held.parts, 1)), held.parts)
                now = stepper.state()
                states[k + 1] = np.concatenate([now.qpos, now.qvel, states[0, _size(now) :]])
                at = f"{(k + 1) * held.script.period:.3g} s"
                if not np.isfinite(states[k + 1]).all():
                    return states, f"it diverges within {at}"
                if time.process_time() > ends:
                    return states, f"{held.seconds:g} s were enough for {at}"
    except (Unsupported, RefusedFile) as why:
        return states, str(why)
    return states, ""


def _split(state: Array, held: Held) -> State:
    """A state of the audit as positions and velocities; a mechanism has no activations."""
    velocity = held.model.layout.velocity
    return State(state[: velocity.start], state[velocity])


def _size(state: State) -> int:
    """How many numbers of a state of the audit are positions and velocities."""
    return len(state.qpos) + len(state.qvel)
