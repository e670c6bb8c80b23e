"""Pinocchio as an engine: its articulated-body dynamics of the smooth scenes, under the integrators
of this package, since it brings none. It shows the accuracy of an engine's equations of motion
alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.abilities import Fields, ModelReader, OwnDerivative, RunsFiles
from plumbob.engines.adapters.equation import Equation
from plumbob.engines.adapters.hinged_body import PENDULUMS, HingedBody, hinged_body, model_error
from plumbob.engines.adapters.integrators import fixed_steps
from plumbob.engines.adapters.own_derivatives import nudged
from plumbob.engines.adapters.three_feet import CAPSULE
from plumbob.engines.method import Engine, Method, Simulation, Unsupported
from plumbob.engines.peer_model import (
    FREE,
    Frame,
    Layout,
    NotRead,
    PeerModel,
    RefusedFile,
    Translated,
)
from plumbob.engines.trajectory import ByName
from plumbob.models.border import border
from plumbob.models.scene import Case

if TYPE_CHECKING:
    from plumbob.models.gradient import Number

NO_CONTACTS = (
    "its forward dynamics has bilateral constraints: contacts would be those of its caller"
)
METHODS = (
    Method("pinocchio/aba+euler", Scheme(EULER), 1, kinds=PENDULUMS),
    Method(
        "pinocchio/aba+rk4",
        Scheme(RK4),
        4,
        systems=("capsule-line/heading-030",),
        kinds=PENDULUMS,
    ),
)
Acceleration = Callable[[float, Any, Any], Any]  # of time [s], theta [rad], rate [rad/s]
INERTIAL = ("mass", "arm", "moments", "gravity", "pivot")


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Build `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    if case.system.family == CAPSULE:
        raise Unsupported(NO_CONTACTS)
    begin = time.perf_counter()
    body = hinged_body(case)
    equation = Equation(_dynamics(body), body.theta, body.theta_dot, 1.0, limits=body.limits)
    simulation = fixed_steps(equation, method.scheme.integrator, case.scene.duration, step)
    simulation.compile_seconds = time.perf_counter() - begin
    simulation.samples = case.samples
    return simulation


def _model(body: HingedBody) -> Any:
    """The body on its hinge, on a platform where there is one."""
    import pinocchio

    model = pinocchio.Model()
    last = 0
    still = pinocchio.SE3.Identity()
    for link in body.links:
        turns = pinocchio.JointModelRevoluteUnaligned(np.array(link.axis))
        place = pinocchio.SE3(np.eye(3), np.array(link.place))
        last = model.addJoint(last, turns, place, f"joint {last}")
        inertia = pinocchio.Inertia(link.mass, np.array(link.centre), link.moments)
        model.appendBodyToJoint(last, inertia, still)
    model.gravity.linear = np.array(body.pull)
    return model


def _dynamics(body: HingedBody) -> Acceleration:
    """The angle's acceleration. On a platform that keeps its rate it is the one for which inverse
    dynamics gives no torque on the hinge."""
    import pinocchio

    model = _model(body)
    data = model.createData()
    last = model.nv - 1
    q, v, tau, still = np.zeros((4, model.nv))
    bias = pinocchio.rnea(model, data, q, v, still)[last]
    inertia = float(pinocchio.rnea(model, data, q, v, np.eye(model.nv)[last])[last] - bias)
    v[0] = body.platform_rate or 0.0

    def forward(time: float, theta: float, rate: float) -> float:
        q[last], v[last], tau[last] = theta, rate, _torque(body, time, theta, rate)
        if body.platform_rate is None:
            return float(pinocchio.aba(model, data, q, v, tau)[0])
        needed = float(pinocchio.rnea(model, data, q, v, still)[last])
        return (float(tau[last]) - needed) / inertia

    return forward


def derivatives(number: Number, method: Method, step: float) -> ByName:
    """Derivatives of the angle and its rate at the end, by those of the articulated-body algorithm,
    stepped with the motion as its variational equation; raises Unsupported."""
    cases, apart = nudged(number)
    low, here, high = (hinged_body(case) for case in cases)
    if any(repr(getattr(low, n)) != repr(getattr(high, n)) for n in INERTIAL):
        raise Unsupported(
            f"its derivatives are by state and torque: {number.name} is a parameter of the model"
        )

    def start(name: str) -> Array:
        slope = (getattr(high, name) - getattr(low, name)) / apart
        return np.array([getattr(here, name), slope])

    equation = Equation(
        _variational(low, here, high, apart),
        start("theta"),
        start("theta_dot"),
        1.0,
        names=("theta", "by"),
        rate_names=("theta_dot", "by_dot"),
    )
    duration = number.case.scene.duration
    end = fixed_steps(equation, method.scheme.integrator, duration, step).run().observables
    return {"theta": float(end["by"][-1]), "theta_dot": float(end["by_dot"][-1])}


def _variational(
    low: HingedBody, here: HingedBody, high: HingedBody, apart: float
) -> Acceleration:
    """The acceleration of the angle and of its derivative: where inverse dynamics gives the torque
    of the hinge, their derivatives are equal."""
    import pinocchio

    model = _model(here)
    second = _dynamics(here)
    data = model.createData()
    last = model.nv - 1
    q = np.zeros(model.nv)
    v = np.zeros(model.nv)
    a = np.zeros(model.nv)
    inertia = pinocchio.crba(model, data, q)[last, last]
    low_rate, v[0], high_rate = (body.platform_rate or 0.0 for body in (low, here, high))

    def forward(time: float, x: Any, rate: Any) -> Any:
        q[last] = x[0]
        v[last] = rate[0]
        a[last] = second(time, x[0], rate[0])
        pinocchio.computeRNEADerivatives(model, data, q, v, a)
        torque = (
            _torque(high, time, x[0], rate[0]) - _torque(low, time, x[0], rate[0])
        ) / apart
        torque -= here.damping * rate[1] + here.stiffness * x[1]
        torque -= data.dtau_dq[last, last] * x[1] + data.dtau_dv[last, last] * rate[1]
        if last:
            torque -= data.dtau_dv[last, 0] * (high_rate - low_rate) / apart
        return np.array([a[last], torque / inertia])

    return forward


def _torque(body: HingedBody, time: float, theta: float, rate: float) -> float:
    """On the hinge [N m]."""
    amplitude, frequency = body.forcing or (0.0, 0.0)
    push = amplitude * float(np.sin(frequency * time)) if amplitude else 0.0
    return push - body.damping * rate - body.stiffness * theta


def _read(path: Path) -> Any:
    """The model of a file; raises RefusedFile."""
    import pinocchio

    with border(RefusedFile):
        return pinocchio.buildModelFromMJCF(str(path))


def model_fields(path: Path) -> Fields:
    """The numbers that Pinocchio reads from a model file; its bodies are known by their joints.
    Raises RefusedFile."""
    import pinocchio

    model = _read(path)
    yield "gravity", "", model.gravity.linear
    for frame in model.frames:
        inertia = model.inertias[frame.parentJoint]
        if frame.type == pinocchio.FrameType.BODY and frame.parentJoint:
            yield "mass", frame.name, inertia.mass
            yield "inertia", frame.name, np.linalg.eigvalsh(inertia.inertia)
    for i in range(1, model.njoints):
        if model.nvs[i] == 1:
            dof = model.idx_vs[i]
            name = model.names[i]
            yield "armature", name, model.armature[dof]
            yield "damping", name, model.damping[dof]
            yield "frictionloss", name, model.upperDryFrictionLimit[dof]


class PinocchioModel:
    """A model of a file, stepped by semi-implicit Euler with the damping of its joints implicit:
    the model holds the damping, and the forward dynamics leaves it to the caller."""

    def __init__(self, model: Any, step: float) -> None:
        self.model, self.data, self.step = model, model.createData(), step
        self.damping = np.array(model.damping)
        self.implicit = model.copy()
        self.implicit.armature = model.armature + step * self.damping

    def put(self, q: Array, v: Array) -> None:
        """Start from these coordinates."""
        self.q, self.v = q, v

    def terms(self, q: Array, v: Array, control: Array) -> dict[str, Any]:
        """The terms of the model's equations of motion; it has no springs, actuators or
        contacts."""
        import pinocchio

        inertia = np.array(pinocchio.crba(self.model, self.data, q))
        weight = np.array(pinocchio.computeGeneralizedGravity(self.model, self.data, q))
        bias = pinocchio.nonLinearEffects(self.model, self.data, q, v) - weight
        none = np.zeros(len(v))
        forces = {
            "gravity": -weight,
            "bias": bias,
            "passive": -self.damping * v,
            "actuator": none,
        }
        upper = np.triu(inertia)
        inertia = upper + np.triu(upper, 1).T
        return {"mass matrix": inertia, **forces, "damping": self.damping, "contacts": []}

    def advance(self, control: Array, force: Array, steps: int) -> tuple[Array, Array]:
        """Take steps."""
        import pinocchio

        for _ in range(steps):
            push = force - self.damping * self.v
            self.v = self.v + self.step * pinocchio.aba(
                self.implicit, self.data, self.q, self.v, push
            )
            self.q = pinocchio.integrate(self.model, self.q, self.step * self.v)
        return self.q, self.v


FRAME = Frame(
    lambda place, w: np.concatenate([place, w[1:], w[:1]]),
    lambda q: (q[:3], np.concatenate([q[6:], q[3:6]])),
    linear_first=True,
    linear_in_body=True,
    angular_in_body=True,
)


def user_model(path: Path, layout: Layout, step: float) -> PeerModel:
    """The model of a file; joints of one body are one, in their order. Raises NotRead."""
    model = _read(path)
    hinges = list[tuple[str, tuple[int, int]]]()
    free = []
    for i in range(1, model.njoints):
        at = (int(model.idx_qs[i]), int(model.idx_vs[i]))
        count = model.nvs[i]
        if count == FREE and model.nqs[i] > FREE:
            free.append((*at, FRAME))
        elif count != model.nqs[i]:
            raise NotRead(f"its joint {model.names[i]} is of a kind that is not compared")
        else:
            name = model.names[i]
            hinges += [(name + "+" * k, (at[0] + k, at[1] + k)) for k in range(count)]
    return Translated(PinocchioModel(model, step), layout, hinges, free)


ENGINE = Engine(
    "pinocchio",
    "pinocchio",
    METHODS,
    prepare,
    model_error,
    optional=True,
    abilities=(
        ModelReader(model_fields),
        OwnDerivative("rnea", derivatives, 1e-12),
        RunsFiles(user_model),
    ),
)
