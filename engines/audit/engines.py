"""Other engines on one motion of a user's model: their errors against its certified motion, and the
first term of their equations of motion that differs from the file's."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.abilities import BuildsMechanisms, RunsFiles
from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.built_mechanism import built_runs
from plumbob.engines.audit.reference import Certificate, largest_displacement
from plumbob.engines.audit.step_errors import StateErrors, state_errors
from plumbob.engines.audit.term_differences import (
    AXES,
    CONTACTS,
    INTEGRATOR,
    SAME_STEP,
    SINGLE,
    STEP,
    TERMS,
    Look,
    ReferenceMotion,
    TermDifference,
    look_at_states,
    step_differences,
    term_differences,
    total_force,
)
from plumbob.engines.method import Engine, Unsupported
from plumbob.engines.own_motion import NotControlled, OwnModel, Script
from plumbob.engines.peer_model import MechanismDiffers, PeerModel, RefusedFile
from plumbob.engines.registry import engines, find_engine, installed
from plumbob.engines.study.provenance import version_of
from plumbob.engines.workers import Lost, Task, Workers
from plumbob.models.entry_points import captured

# Multiple of the effect of rounding the state above which a difference is more than rounding.
# Rounding within a step adds up to 5 times that effect, as measured.
BEYOND = 30.0
MORE = "less than it shows in states, and more than rounding: perhaps the solver, or contacts"
EXACT = 1e-10  # largest relative rounding of numbers that are not in single precision
DIVERGED = 1e10  # magnitude above which MuJoCo calls a number huge
NOT_RIGHT = MappingProxyType(
    {
        CONTACTS: "contacts are its solver's: none is added or taken away",
        AXES: "contacts are its solver's, their axes too",
        STEP: "the law is its solver's: no force stands for another one",
        INTEGRATOR: "no force stands for another integrator",
        SINGLE: "no force undoes rounding",
    }
)
HANGS = 300.0  # [s] time in addition to the runs: kernels are compiled


@dataclass(frozen=True)
class EngineError:
    """The errors of an engine's steps, at the file's step, against the certified motion."""

    engine: str
    version: str = ""
    why: str = ""  # why there is no error, or the difference cannot be corrected
    # [m] largest so far, at the ends of the periods
    errors: Array = field(default_factory=lambda: np.zeros(0))
    # [m] error of MuJoCo with the scheme of the engine at the same step
    step_error: float = math.nan
    differences: tuple[TermDifference, ...] = ()  # in the order in which terms are compared
    first_right: float = math.nan  # [m] error with the first term corrected
    all_right: float = math.nan  # [m] error with all terms corrected that can be
    built: float = math.nan  # [m] error of the mechanism as plumbob builds it in the engine
    not_built: str = ""  # why the mechanism is not built, or its run ends early
    rounding: float = math.nan  # [m] predicted effect of single precision
    apart: float = math.nan  # [m] largest displacement from MuJoCo's own steps
    # Errors of attitudes, coordinates and activations; None if there are no errors
    state_errors: StateErrors | None = None

    @property
    def error(self) -> float:
        """The error [m] at the end; NaN if there is none."""
        return float(self.errors[-1]) if self.errors.size else math.nan

    @property
    def finite(self) -> bool:
        """Whether the run reaches the end."""
        return math.isfinite(self.error)

    @property
    def first(self) -> TermDifference | None:
        """The first term that differs."""
        return self.differences[0] if self.differences else None

    @property
    def reason(self) -> str:
        """The reason why there is no error, the run ends early, or the first term is not
        corrected."""
        return self.why or (NOT_RIGHT.get(self.first.term, "") if self.first else "")

    @property
    def left(self) -> float:
        """The engine's part of the error [m]: from its step, its contacts and its precision. If the
        mechanism is not built in the engine, it is the error that remains with all terms
        corrected."""
        return self.built if math.isfinite(self.built) else self.all_right

    @property
    def part_explained(self) -> float | None:
        """The fraction of the error that vanishes if plumbob builds the model in the engine without
        the engine's reader of files. If the model cannot be built there, the fraction that vanishes
        with the first wrong term corrected; None if no force corrects it."""
        without = self.built if math.isfinite(self.built) else self.first_right
        part = (self.error - without) / self.error if self.error else math.nan
        return part if math.isfinite(part) else None


def with_engines(
    audit: Audit,
    file: Any,
    names: Sequence[str],
    seconds: float,
    progress: Callable[[str], None] = lambda what: None,
) -> Audit:
    """Returns an audit with the errors of the named engines. Each engine has a process of its own,
    since some crash on features that they do not know; each run takes `seconds` at most."""
    if not names:
        return audit
    count = audit.found.index if audit.found else 0
    motion = reference_motion(
        Path(file), audit.model, audit.script, audit.reference, count, seconds
    )
    tasks = [
        Task(name, engine_error, (name, motion), HANGS + 4 * seconds, label=name)
        for name in dict.fromkeys(names)
    ]
    with Workers(1) as workers:
        rows = [
            EngineError(task.label, why=row.why) if isinstance(row, Lost) else row
            for task, row in workers.results(tasks, lambda task: progress(task.label))
        ]
    return replace(audit, engines=tuple(rows))


def reference_motion(
    file: Path,
    model: OwnModel,
    script: Script,
    reference: Certificate,
    count: int,
    seconds: float,
) -> ReferenceMotion:
    """Returns a motion that is certified for `count` periods, as the standard for other engines."""
    return ReferenceMotion(
        file.resolve(),
        model,
        replace(script, controls=script.controls[:count]),
        reference.course.states[: count + 1],
        seconds,
    )


def readers() -> tuple[str, ...]:
    """Returns the names of the installed engines that run model files."""
    able = (engine for engine in engines().values() if engine.ability(RunsFiles) is not None)
    return tuple(engine.name for engine in able if installed(engine))


def engine_error(name: str, motion: ReferenceMotion) -> EngineError:
    """Returns the error of an engine, with the engine's output suppressed."""
    engine = find_engine(name)
    if engine.ability(RunsFiles) is None:
        return EngineError(name, why="plumbob has no reader of model files for it")
    if not installed(engine):
        return EngineError(name, why="it is not installed")
    if not len(motion.script.controls):
        return EngineError(name, why="there is no certified motion")
    try:
        with captured():
            return file_error(engine, motion)
    except RefusedFile as error:
        refused = f"it refuses the file: {error}"
    except MechanismDiffers as why:
        refused = str(why)
    with captured():
        return _with_built_error(EngineError(name, version_of(engine), refused), engine, motion)


def file_error(engine: Engine, motion: ReferenceMotion) -> EngineError:
    """Returns the error of an engine that runs files. Raises the errors of its reader."""
    reader = engine.ability(RunsFiles)
    assert reader is not None
    peer = reader.load(motion.file, motion.model.layout, motion.model.step)
    integrators = motion.model.integrator, peer.integrator
    looks = look_at_states(peer, motion)
    differing = tuple(term_differences(engine, looks, motion, reader.precision, integrators))
    states, why = _run(peer, motion)
    mujoco_states = motion.model.stepped(motion.script, peer.integrator, motion.parts).states
    rounding = math.nan
    from_mujoco = largest_displacement(motion.model, states, mujoco_states)
    if reader.precision > EXACT:
        rounded_states = motion.model.stepped(
            motion.script, peer.integrator, motion.parts, single=True
        ).states
        rounding = largest_displacement(motion.model, rounded_states, mujoco_states)
        by_rounding = from_mujoco <= BEYOND * rounding
        cause = (SINGLE, reader.precision) if by_rounding else (STEP, SAME_STEP, MORE)
        differing = differing or (TermDifference(*cause),)
    result = EngineError(
        engine=engine.name,
        version=version_of(engine),
        why=why,
        errors=motion.errors(states),
        step_error=float(motion.errors(mujoco_states)[-1]),
        differences=differing,
        rounding=rounding,
        apart=from_mujoco,
        state_errors=state_errors(motion.model, motion.states, states),
    )
    return _with_built_error(_with_corrections(result, looks, peer, motion), engine, motion)


def _with_built_error(
    result: EngineError, engine: Engine, motion: ReferenceMotion
) -> EngineError:
    """Returns the result with the error of the model's mechanism as plumbob builds it in the
    engine."""
    builds = engine.ability(BuildsMechanisms)
    if builds is None:
        return replace(result, not_built="plumbob builds no mechanism in it")
    try:
        built = built_runs(builds, motion.model, motion.script, motion.parts, motion.seconds)
        run = built.run(motion.script)
    except Unsupported as why:
        return replace(result, not_built=str(why))
    error = math.nan if run.why else float(motion.errors(run.states)[-1])
    return replace(result, built=error, not_built=run.why)


def _with_corrections(
    result: EngineError, looks: Sequence[Look], peer: PeerModel, motion: ReferenceMotion
) -> EngineError:
    """Returns the result with the errors after correcting the first term and after correcting all
    terms that can be, and with the difference that then remains."""
    correctable = [
        difference.term for difference in result.differences if difference.term in TERMS
    ]
    if not correctable:
        return result
    integrators = motion.model.integrator, peer.integrator
    first_states, first_end = _run(peer, motion, correctable[:1])
    all_states, all_end = (
        _run(peer, motion, correctable) if correctable[1:] else (first_states, first_end)
    )
    errors = (float(motion.errors(states)[-1]) for states in (first_states, all_states))
    return replace(
        result,
        why=result.why or first_end or all_end,
        differences=(
            *result.differences,
            *step_differences(_corrected_looks(looks, peer, motion, correctable), integrators),
        ),
        first_right=next(errors),
        all_right=next(errors),
    )


def _corrected_looks(
    looks: Sequence[Look], peer: PeerModel, motion: ReferenceMotion, right: Sequence[str]
) -> list[Look]:
    """Returns the looks with the engine's acceleration after some terms are corrected."""
    step = motion.model.step
    velocity = motion.model.layout.velocity

    def acceleration(look: Look) -> Array:
        start = Script(look.state, step, look.control[None])
        one_step = replace(motion, script=start, states=look.state[None])
        after = _run(peer, one_step, right)[0][1]
        return np.asarray(after[velocity] - look.state[velocity]) / step

    return [
        replace(look, accelerations=(*look.accelerations[:2], acceleration(look)))
        for look in looks
    ]


def _run(
    peer: PeerModel, motion: ReferenceMotion, right: Sequence[str] = ()
) -> tuple[Array, str]:
    """Returns the states at the ends of the periods, with some terms corrected by a force, and the
    reason if the run ends early."""
    script = motion.script
    parts = motion.parts
    states = np.full((len(script.controls) + 1, motion.states.shape[1]), np.nan)
    states[0], ends = script.start, time.process_time() + motion.seconds
    state = script.start
    terms = motion.model.terms()
    force = 0.0 * state[motion.model.layout.velocity]
    calls = parts if right else 1
    peer.begin(state)
    ask = script.new_run()
    for k in range(len(script.controls)):
        try:
            control = ask(k, np.append(state, motion.states[k, state.size :]))
        except NotControlled as reason:
            return states, str(reason)
        for _ in range(calls):
            if right:
                # Activations that the engine does not have
                state = np.append(state, motion.states[k, state.size :])
                force = _correcting_force(terms, peer, state, control, right, motion.model.step)
            state = peer.advance(control, force, parts // calls)
        states[k + 1, : state.size] = state
        end = f"{(k + 1) * script.period:.3g} s"
        if not np.isfinite(state).all() or np.abs(state).max() > DIVERGED:
            return states, f"it diverges within {end}"
        if time.process_time() > ends:
            return states, f"{motion.seconds:g} s were enough for {end}"
    return states, ""


def _correcting_force(
    terms: Any, peer: PeerModel, state: Array, control: Array, right: Sequence[str], step: float
) -> Array:
    """Returns the generalised force to add so that an engine's step uses the file's terms in place
    of those named in `right`. With the engine's mass matrix M_e, implicit damping D_e and force
    f_e, and the wanted M, D and f, it is (M_e + h D_e) (M + h D)^-1 f - f_e."""
    engine_terms = peer.terms(state, control)
    file_terms = terms(state, control)
    chosen = {**engine_terms, **{name: file_terms[name] for name in right}}
    implicit = engine_terms.get("damping", np.zeros(len(file_terms["gravity"])))
    damping = file_terms["damping"] if "passive" in right else implicit
    acceleration = np.linalg.solve(
        chosen[TERMS[0]] + step * np.diag(damping), total_force(chosen)
    )
    inertia: Array = engine_terms[TERMS[0]] + step * np.diag(implicit)
    return inertia @ acceleration - total_force(engine_terms)
