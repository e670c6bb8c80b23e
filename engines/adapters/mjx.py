"""MJX as an engine: the MuJoCo adapter's models, stepped by JAX on the processor, in single
precision, MJX's default, and in double precision. All steps from one sample to the next are one
compiled loop."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.schemes import Scheme
from plumbob.engines import sampling
from plumbob.engines.abilities import (
    Batches,
    OwnDerivative,
    RunsCopies,
    RunsFiles,
    SchemeOfCase,
)
from plumbob.engines.adapters import ported
from plumbob.engines.adapters.own_derivatives import moved, nudged
from plumbob.engines.adapters.ported import EVERY, LOADED, SMOOTH
from plumbob.engines.adapters.stepping import Built, SteppedSimulation
from plumbob.engines.method import Engine, Method, Unsupported
from plumbob.engines.peer_model import RefusedFile
from plumbob.engines.processor_time import processor_time
from plumbob.engines.trajectory import ByName, Trajectory
from plumbob.models.border import border
from plumbob.models.scene import Case

if TYPE_CHECKING:
    from plumbob.models.gradient import Number

METHODS = (
    ported.ported("mjx/default", "Euler", SMOOTH),
    ported.ported("mjx/euler+float64", "Euler", EVERY, float64=True),
    ported.ported("mjx/rk4+float64", "RK4", SMOOTH, float64=True),
)


BLOCK = 64  # rows of controls in a call: the loop is compiled anew for each number of rows
Pair = tuple[Any, Any]  # a model and its data, or positions and velocities


class MjxPort:
    """A compiled model in MJX, in single precision, MJX's default, or in double precision. Raises
    RefusedFile."""

    def __init__(self, model: Any, double: bool = False) -> None:
        import jax
        from mujoco import mjx

        self.precision = partial(jax.enable_x64, double)
        with self.precision(), border(RefusedFile):
            self.compiled, self.model = model, mjx.put_model(model)
            self.data = mjx.make_data(model)
        self.take, self.forwards = _loop(), jax.jit(mjx.forward)

    def load(self, data: Any) -> None:
        """Copies the state, the controls and the applied forces of an mjData."""
        import jax

        kind = self.data.qpos.dtype
        with self.precision():
            loaded = {name: np.array(getattr(data, name), kind) for name in LOADED}
            # JAX compiles a loop anew if some arrays are on a device and others are not.
            self.data = jax.device_put(self.data.replace(**loaded), self.data.qpos.device)

    def forward(self) -> None:
        """Computes all terms of the equations of motion."""
        self.data = self.forwards(self.model, self.data)

    def steps(self, count: int) -> None:
        """Takes `count` steps."""
        import jax

        with self.precision():
            self.data = jax.block_until_ready(self.take(self.model, self.data, count))

    def step_under(self, controls: Array) -> None:
        """Takes a step under each of the controls, shape (steps, nu). The loop is compiled for
        BLOCK rows; rows beyond the last step are not used."""
        import jax

        rows = np.zeros((BLOCK, controls.shape[1]), self.data.ctrl.dtype)
        with self.precision():
            for first in range(0, len(controls), BLOCK):
                part = controls[first : first + BLOCK]
                rows[: len(part)] = part
                self.data = _controlled_loop()(self.model, self.data, rows.copy(), len(part))
            jax.block_until_ready(self.data)

    @property
    def numbers(self) -> Pair:
        """The model and its data, as trees of arrays."""
        return self.model, self.data

    def state(self) -> Pair:
        """The positions and velocities."""
        return self.data.qpos, self.data.qvel

    def unload(self, data: Any) -> None:
        """Writes the state and all terms into an mjData."""
        from mujoco import mjx

        mjx.get_data_into(data, self.compiled, self.data)


class MjxCopies:
    """A compiled model in MJX, stepped in batches by JAX's vmap. Raises RefusedFile."""

    def __init__(self, model: Any, double: bool) -> None:
        import jax
        from mujoco import mjx

        self.port = MjxPort(model, double)
        self.sizes = model.nq, model.nq + model.nv
        one = self.port.data

        def begin(qpos: Any, qvel: Any, act: Any, warm_start: Any) -> Any:
            """Returns the data of a copy at its start."""
            return one.replace(qpos=qpos, qvel=qvel, act=act, qacc_warmstart=warm_start)

        def step(model: Any, data: Any, control: Any) -> Any:
            """Returns the data of a copy after a step."""
            return mjx.step(model, data.replace(ctrl=control))

        self.begin = jax.jit(jax.vmap(begin))
        self.step = jax.jit(jax.vmap(step, (None, 0, 0)))

    def run(self, states: Array, warm_starts: Array, controls: Array) -> Array:
        """Returns the states of the copies, see `Copies.run`."""
        kind = self.port.data.qpos.dtype
        parts = [*np.split(states, self.sizes, axis=1), warm_starts]
        rows = [states]
        with self.port.precision():
            data = self.begin(*(part.astype(kind) for part in parts))
            for held in np.moveaxis(controls, 1, 0).astype(kind):
                data = self.step(self.port.model, data, held)
                after = (np.array(part, float) for part in (data.qpos, data.qvel, data.act))
                rows.append(np.hstack(list(after)))
        return np.stack(rows, axis=1)


@cache
def _loop() -> Callable[[Any, Any, int], Any]:
    """The compiled loop: model, data, number of steps -> data."""
    import jax

    return jax.jit(_steps)  # type: ignore[no-any-return]


@cache
def _controlled_loop() -> Callable[[Any, Any, Array, int], Any]:
    """The compiled loop under controls: model, data, controls, number of steps -> data."""
    import jax
    from mujoco import mjx

    def steps(model: Any, data: Any, controls: Any, count: Any) -> Any:
        """The data after `count` steps, each under its row of controls."""
        return jax.lax.fori_loop(
            0, count, lambda n, data: mjx.step(model, data.replace(ctrl=controls[n])), data
        )

    return jax.jit(steps)  # type: ignore[no-any-return]


def _steps(model: Any, data: Any, count: Any) -> Any:
    """The data after `count` steps, to be compiled."""
    import jax
    from mujoco import mjx

    return jax.lax.fori_loop(0, count, lambda n, data: mjx.step(model, data), data)


class MjxSimulation(SteppedSimulation):
    """A model in MJX. Its steps are timed in one call: starting a call takes up to 200 times as
    long as the steps between two samples."""

    def run(self) -> Trajectory:
        """Runs from the start to the end, or until the run diverges."""
        run = super().run()
        return replace(run, seconds=self.stepped(run.steps / self.steps).seconds)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of a method on a case: MuJoCo's with this integrator. If the case has a loop, MJX
    leaves the change of the constraint's direction out of the reference acceleration."""
    chosen = ported.scheme(case, method)
    if chosen.loop is None:
        return chosen
    return replace(chosen, loop=replace(chosen.loop, curved=False))


def prepare(case: Case, method: Method, step: float) -> MjxSimulation:
    """Compiles `case` for `method` at `step` [s]; raises Unsupported and ParameterError. Steps are
    timed by the processor time of the whole process, since JAX steps on other threads."""
    steps = sampling.step_count(case.scene.duration, step)
    stride = sampling.stride(steps, case.samples)
    begin = time.perf_counter()
    translation, model = ported.compiled(case, method, step)

    def build() -> Built:
        """The scene at its start in a port whose loop is compiled."""
        port = _started(translation, model, _double(method))
        start = port.data
        scene = ported.built(port, translation, step)
        scene.advance(0, stride)  # compiles the loop
        port.data = start
        return scene

    try:
        _started(translation, model, _double(method))
    except RefusedFile as error:
        raise Unsupported(f"MJX refuses the model: {error}") from None
    seconds = time.perf_counter() - begin
    return MjxSimulation(
        build, steps, step, seconds, samples=case.samples, clock=processor_time
    )


def _double(method: Method) -> bool:
    """Whether a method computes in double precision."""
    return bool(method.settings.get("float64"))


def _started(translation: Any, model: Any, double: bool) -> MjxPort:
    """A port at the start of a scene."""
    port: MjxPort = ported.started(MjxPort(model, double), translation, model)
    return port


def batch(
    case: Case, method: Method, step: float, worlds: int
) -> tuple[str, Callable[[int], float]]:
    """The device of a batch of `worlds` at the start of a case, by JAX's vmap, and a function that
    takes a number of steps and returns the wall time [s]."""
    import jax

    translation, model = ported.compiled(case, method, step)
    ported.uncontrolled(translation)
    port = _started(translation, model, _double(method))
    port.take = jax.jit(jax.vmap(_steps, (None, 0, None)))
    with port.precision():
        port.data = jax.tree.map(
            lambda array: jax.numpy.broadcast_to(array, (worlds, *array.shape)), port.data
        )
    return jax.devices()[0].device_kind, partial(ported.timed, port)


def derivatives(way: str, number: Number, method: Method, step: float) -> ByName:
    """The derivatives of the observables at the end of a run by a number of the start or the model,
    by JAX through all steps: forward or backward, as the `way` says. Raises Unsupported."""
    import jax

    cases, apart = nudged(number)
    low, middle, high = (ported.compiled(case, method, step) for case in cases)
    translation, _ = middle
    ported.uncontrolled(translation)
    port = _started(*middle, _double(method))
    with port.precision():
        steps = sampling.step_count(number.case.scene.duration, step)
        end = partial(_end, port.numbers, _slopes(low, high, apart), steps)
        slopes, state = jax.jit(getattr(jax, way)(end, has_aux=True))(0.0)
    qpos, qvel, by_qpos, by_qvel = (
        np.array(values, np.float64)[None] for values in (*state, *slopes)
    )

    def observe(place: float, rate: float) -> Signals:
        """The observables of the end, moved along its slopes by two amounts."""
        moved_end = (qpos + place * by_qpos, qvel + rate * by_qvel)
        observables: Signals = translation.observed(*moved_end)[0]
        return observables

    return moved(observe, by_qpos, by_qvel)


def _slopes(low: Pair, high: Pair, apart: float) -> list[Array]:
    """The difference quotient of each array of a model and its data between two sides, which are
    `apart` in the number that is varied."""
    import jax

    low_leaves, high_leaves = (
        jax.tree.leaves(_started(*side, True).numbers) for side in (low, high)
    )
    return [
        (np.asarray(above, float) - np.asarray(below, float)) / apart
        for below, above in zip(low_leaves, high_leaves, strict=True)
    ]


def _end(numbers: Any, slopes: Any, steps: int, amount: Any) -> Pair:
    """Positions and velocities after `steps` steps from a model and data whose numbers are moved by
    `amount` times their slopes. They are returned twice: JAX differentiates the first pair, and
    returns the second as it is."""
    import jax

    def changed(array: Any, slope: Array) -> Any:
        """An array of floats, moved; an array of integers as it is."""
        if not jax.numpy.issubdtype(array.dtype, jax.numpy.floating):
            return array
        return array + amount * slope.astype(array.dtype)

    leaves, structure = jax.tree.flatten(numbers)
    model, start = jax.tree.unflatten(structure, map(changed, leaves, slopes))
    end = _steps(model, start, steps)
    return (end.qpos, end.qvel), (end.qpos, end.qvel)


ENGINE = Engine(
    "mjx",
    "mujoco.mjx",
    METHODS,
    prepare,
    ported.model_error,
    optional=True,
    abilities=(
        *(OwnDerivative(way, partial(derivatives, way), 1e-15) for way in ("jacfwd", "jacrev")),
        SchemeOfCase(scheme),
        RunsFiles(partial(ported.load_file, MjxPort), 2.0**-24),
        Batches(batch),
        RunsCopies(MjxCopies, (False, True)),
    ),
)
