"""MJX as an engine: the models of the MuJoCo adapter, stepped by JAX on the processor, in single
precision, which is its default, and in double precision. All steps from one sample to the next are
one compiled loop.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.engines import sampling
from plumbob.engines.abilities import Batches, OwnDerivative, RunsFiles, SchemeOfCase
from plumbob.engines.adapters import ported
from plumbob.engines.adapters.own_derivatives import moved, nudged
from plumbob.engines.adapters.ported import EVERY, LOADED, PORTED, SMOOTH
from plumbob.engines.adapters.stepping import Built, SteppedSimulation
from plumbob.engines.method import Engine, Method, Unsupported
from plumbob.engines.peer_model import RefusedFile
from plumbob.engines.processor_time import processor_time
from plumbob.engines.trajectory import ByName, Trajectory
from plumbob.models.border import border
from plumbob.models.scene import Case, later

if TYPE_CHECKING:
    from plumbob.models.gradient import Number

METHODS = (
    ported.ported("mjx/default", "Euler", SMOOTH),
    ported.ported("mjx/euler+float64", "Euler", EVERY, float64=True),
    ported.ported("mjx/rk4+float64", "RK4", SMOOTH, float64=True),
)


BLOCK = 64  # rows of controls: for each length of a block the loop would be compiled anew
Pair = tuple[Any, Any]
"""A model and its data, or positions and velocities."""


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
        """Take over the state, control and applied forces of an mjData."""
        import jax

        kind = self.data.qpos.dtype
        with self.precision():
            loaded = {n: np.array(getattr(data, n), kind) for n in LOADED}
            # Beside others that are on a device a loop is compiled once more for those on none.
            self.data = jax.device_put(self.data.replace(**loaded), self.data.qpos.device)

    def forward(self) -> None:
        """Work out all terms."""
        self.data = self.forwards(self.model, self.data)

    def steps(self, count: int) -> None:
        """Take steps."""
        import jax

        with self.precision():
            self.data = jax.block_until_ready(self.take(self.model, self.data, count))

    def controlled(self, controls: Array) -> None:
        """Take a step under each of the controls, shape (steps, nu). The loop is compiled for BLOCK
        rows, of which those beyond the last step are not used."""
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
        """The model, and where it is."""
        return self.model, self.data

    def state(self) -> Pair:
        """Positions and velocities."""
        return self.data.qpos, self.data.qvel

    def unload(self, data: Any) -> None:
        """Fill in an mjData."""
        from mujoco import mjx

        mjx.get_data_into(data, self.compiled, self.data)


@cache
def _loop() -> Callable[[Any, Any, int], Any]:
    """The compiled loop: model, data, and how many steps."""
    import jax

    return jax.jit(_steps)  # type: ignore[no-any-return]


@cache
def _controlled_loop() -> Callable[[Any, Any, Array, int], Any]:
    """The compiled loop under controls: model, data, controls, and how many steps."""
    import jax
    from mujoco import mjx

    def steps(model: Any, data: Any, controls: Any, count: Any) -> Any:
        return jax.lax.fori_loop(
            0, count, lambda n, data: mjx.step(model, data.replace(ctrl=controls[n])), data
        )

    return jax.jit(steps)  # type: ignore[no-any-return]


def _steps(model: Any, data: Any, count: Any) -> Any:
    import jax
    from mujoco import mjx

    return jax.lax.fori_loop(0, count, lambda n, data: mjx.step(model, data), data)


class MjxSimulation(SteppedSimulation):
    """A model in MJX, timed in one go: to begin the steps between two samples takes up to 200 times
    what they take."""

    def run(self) -> Trajectory:
        """Run from the start to the end, or until the run diverges."""
        done = super().run()
        return replace(done, seconds=self.stepped(done.steps / self.steps).seconds)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of a method on a case: MuJoCo's own with this integrator, but for a loop, whose
    reference acceleration leaves out the change of the constraint's direction."""
    chosen = ported.scheme(case, method)
    if chosen.loop is None:
        return chosen
    return replace(chosen, loop=replace(chosen.loop, curved=False))


def prepare(case: Case, method: Method, step: float) -> MjxSimulation:
    """Compile `case` for `method` at `step` [s]; raises Unsupported and ParameterError. JAX steps
    on other threads, so that the time is that of the process."""
    steps = sampling.step_count(case.scene.duration, step)
    stride = sampling.stride(steps, case.samples)
    begin = time.perf_counter()
    translation, model = ported.compiled(case, method, step)

    def build() -> Built:
        port = _started(translation, model, _double(method))
        start = port.data
        scene = ported.built(port, translation, step)
        scene.advance(0, stride)  # compiles
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
    return bool(method.settings.get("float64"))


def _started(translation: Any, model: Any, double: bool) -> MjxPort:
    """A port at the start of a scene."""
    port: MjxPort = ported.started(MjxPort(model, double), translation, model)
    return port


def batch(
    case: Case, method: Method, step: float, worlds: int
) -> tuple[str, Callable[[int], float]]:
    """So many worlds from the start on, by JAX's vmap."""
    import jax

    translation, model = ported.compiled(case, method, step)
    ported.uncontrolled(translation)
    port = _started(translation, model, _double(method))
    port.take = jax.jit(jax.vmap(_steps, (None, 0, None)))
    with port.precision():
        port.data = jax.tree.map(
            lambda x: jax.numpy.broadcast_to(x, (worlds, *x.shape)), port.data
        )
    return jax.devices()[0].device_kind, partial(ported.timed, port)


def derivatives(way: str, number: Number, method: Method, step: float) -> ByName:
    """Derivatives of the observables by JAX, forward or backward (`way`) through all steps, of a
    number in the start or the model; raises Unsupported."""
    import jax

    cases, apart = nudged(number)
    sides = tuple(ported.compiled(case, method, step) for case in cases)
    ported.uncontrolled(sides[1][0])
    slopes = _slopes(sides[0], sides[2], apart)
    port = _started(*sides[1], _double(method))
    with port.precision():
        steps = sampling.step_count(number.case.scene.duration, step)
        end = partial(_end, port.numbers, slopes, steps)
        slope, state = jax.jit(getattr(jax, way)(end, has_aux=True))(0.0)
    qpos, qvel, by_qpos, by_qvel = (np.array(x, np.float64)[None] for x in (*state, *slope))
    return moved(
        lambda q, v: sides[1][0].observed(qpos + q * by_qpos, qvel + v * by_qvel)[0],
        by_qpos,
        by_qvel,
    )


def _slopes(low: Pair, high: Pair, apart: float) -> list[Array]:
    """The derivative of each of the numbers that a run starts with."""
    import jax

    sides = (jax.tree.leaves(_started(*side, True).numbers) for side in (low, high))
    rows = zip(*sides, strict=True)
    return [(np.asarray(b, float) - np.asarray(a, float)) / apart for a, b in rows]


def _end(numbers: Any, slopes: Any, steps: int, amount: Any) -> Pair:
    """Positions and velocities after so many steps, from numbers moved by an amount of slopes, to
    differentiate and as they are."""
    import jax

    def changed(x: Any, slope: Array) -> Any:
        exact = not jax.numpy.issubdtype(x.dtype, jax.numpy.floating)
        return x if exact else x + amount * slope.astype(x.dtype)

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
        RunsFiles(partial(later(PORTED), MjxPort), 2.0**-24),
        Batches(batch),
    ),
)
