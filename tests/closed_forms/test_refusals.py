"""Impossible parameters are refused by name, in one line, in every part of the theory."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.smooth_motion.energy_drift import energy_drift_rate
from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.linear_oscillator import LinearOscillator
from plumbob.analytic.numerics.rotor.orbit import integrate
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import EULER, LEAPFROG, RK4, Scheme
from plumbob.analytic.systems.capsule import direction_to
from plumbob.analytic.systems.cone_pendulum import Body, ConePendulum, cone
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.analytic.systems.manoeuvres.residual_motion import spin, translation
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke
from plumbob.analytic.systems.manoeuvres.tilted_hold import TiltedHold, tilt_angle
from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre, turn_of
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.models.registry import scene
from plumbob.tests.support.pendulum_cases import CASES, motion
from plumbob.tests.support.random_capsules import CHECK, LIMIT, LINE

STEEL = cone(8000.0, 0.3, math.radians(30.0))
TURNING = ConePendulum(STEEL, 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
BODY = Body(1.0, 0.2, 0.1, 0.1, 0.05)
PENDULUM = PendulumMotion(TrigonometricPotential(0.0, 0.0, 9.8), 1.0, 0.3, 1.0)
OSCILLATOR, ROTOR = LinearOscillator(9.8), DrivenRotor(sin=1.0)
SMOOTH = replace(CHECK, friction=0.0)
BAD = (  # the name, and a field of what becomes what
    ("body_mass", CHECK, "body_mass", 0.0),
    ("slider_mass", CHECK, "slider_mass", -0.3),
    ("inertia", CHECK, "inertia", math.inf),
    ("friction", CHECK, "friction", -0.1),
    ("gravity", CHECK, "gravity", "9.81"),
    ("supports", CHECK, "supports", ((0, 0), (1, 1))),
    ("supports", CHECK, "supports", ((0, 0), (1, 1), (2, 2))),
    ("supports", CHECK, "supports", ((0, 0), (1, 1), (1, 1))),
    ("supports[2]", CHECK, "supports", ((0, 0), (1, 0), (0, math.nan))),
    ("supports", CHECK, "supports", 3),
    ("w1", LINE, "w1", LIMIT),
    ("w1", LINE, "w1", LIMIT * (1 - 1e-9)),
    ("w2", LINE, "w2", LIMIT * (1 + 1e-9)),
    ("w2", LINE, "w2", 0.0),
    ("t1", LINE, "t1", math.nan),
    ("w1, w2, t1", replace(LINE, t1=1e-9), "w1", 1e300),
    ("normal_force_1", LINE, "start", -0.6),
    ("normal_force_2", LINE, "t1", 0.2),
    ("mass", BODY, "mass", 0.0),
    ("inertia_x", BODY, "inertia_x", 0.03),
    ("inertia_y", BODY, "inertia_y", 0.03),
    ("inertia_x, inertia_y, inertia_z", BODY, "inertia_z", 0.2),
    ("gravity", TURNING, "gravity", -9.8),
    ("theta", TURNING, "theta", math.inf),
    ("excess", TURNING, "excess", -700.0),
    ("excess", TURNING, "excess", math.nan),
    ("excess", PENDULUM, "excess", -20.0),
    ("inertia", PENDULUM, "inertia", 0.0),
    ("theta", PENDULUM, "theta", math.nan),
    ("theta_from_top", PENDULUM, "theta_from_top", math.inf),
    ("stiffness", OSCILLATOR, "stiffness", math.nan),
    ("damping_rate", OSCILLATOR, "damping_rate", -1.0),
    ("forcing_amplitude", OSCILLATOR, "forcing_amplitude", math.inf),
    ("sin", ROTOR, "sin", math.nan),
    ("damping_rate", ROTOR, "damping_rate", -0.1),
    ("scheme, implicit_damping", Scheme(RK4), "implicit_damping", True),
    ("scheme, position_first", Scheme(LEAPFROG), "position_first", True),
    ("scheme, implicit_spring", Scheme(EULER), "implicit_spring", True),
    ("scheme, joint_closing_rate", Scheme(EULER), "joint_closing_rate", 1.0),
    ("scheme, control", Scheme(EULER), "control", "nothing"),
)
IMPOSSIBLE = (  # called with these
    ("apex_angle", cone, (8000.0, 0.3, math.pi)),
    ("density", cone, (-1.0, 0.3, 0.5)),
    ("height", cone, (8000.0, math.nan, 0.5)),
    ("support", direction_to, (CHECK, 0)),
    ("support", direction_to, (CHECK, 4)),
    ("supports", spin, (CHECK, (0.0, 0.0), 1.0)),
    ("normal_force_2", translation, (CHECK, (2.0, 0.0), 1.0, 0.0)),
    ("speed", translation, (CHECK, (0.0, 0.0), math.nan, 0.0)),
    ("fraction", SlowStroke, (CHECK, 0.1, 1.1)),
    ("length", SlowStroke, (CHECK, 0.0)),
    ("normal_force_1", SlowStroke, (CHECK, -0.6)),
    ("fraction", tilt_angle, (CHECK, 0.0)),
    ("direction", TiltedHold, (CHECK, 0.9, math.inf)),
    ("normal_force_2", TiltedHold, (CHECK, 0.9, 0.0, (1.0, 0.0))),
    ("count", RepeatedLine, (LINE, 0)),
    ("pause", RepeatedLine, (LINE, 3, 0.9, -1.0)),
    ("radius", TurnManoeuvre, (CHECK, -0.1, 1.0, 1.0)),
    ("angular_acceleration", TurnManoeuvre, (CHECK, 0.1, 0.0, 1.0)),
    ("half_time", TurnManoeuvre, (CHECK, 0.1, 1.0, 0.0)),
    ("start", TurnManoeuvre, (CHECK, 0.1, 1.0, 1.0, math.nan)),
    ("normal_force_1", TurnManoeuvre, (CHECK, 0.6, 500.0, 1.0)),
    ("epsilon", turn_of, (CHECK, 0.1, 0.0)),
    ("body_angle", turn_of, (CHECK, 0.1, 0.1, 0.0)),
    ("friction", turn_of, (SMOOTH, 0.1, 0.1)),
    ("theta", DrivenMotion, (ROTOR, math.inf, 0.0)),
    ("duration", integrate, (ROTOR, 0.0, 0.0, 0.0)),
    ("times", motion(CASES["cone"]).observe, (np.array([-0.1]),)),
    ("times", motion(CASES["cone"]).observe, (np.array([math.nan]),)),
    ("rotor", energy_drift_rate, (CASES["damped-large"].rotor, 1.0, 0.0, 1.0, Scheme(RK4))),
)
SCENES = (  # how the message begins
    ("count = 0", "capsule-turn/0.3", {"count": 0}),
    ("count = 2: must be such that slider_angle is whole", "capsule-turn/0.3", {"count": 2}),
    ("pause = ", "capsule-turn/0.3", {"pause": -1.0}),
    ("radius = 0.5: must be such that normal_force_", "capsule-turn/0.3", {"radius": 0.5}),
    ("half_time = ", "capsule-turn/0.3", {"half_time": 0.0}),
    ("spin = ", "capsule-turn/0.3", {"spin": 1.0}),
    ("length = ", "simple-pendulum", {"length": 0.0}),
    ("gravity = ", "simple-pendulum", {"gravity": -9.8}),
    ("damping_rate = ", "simple-pendulum", {"damping_rate": -0.1}),
    ("theta = ", "simple-pendulum", {"theta": math.nan}),
    ("forcing_frequency = ", "simple-pendulum", {"forcing_frequency": math.inf}),
    ("theta_dot = ", "simple-pendulum", {"theta_dot": "fast"}),
    ("gravity = ", "simple-pendulum", {"gravity": True}),
    ("mass = ", "simple-pendulum", {"mass": 0.0}),
    ("inertia = ", "simple-pendulum", {"inertia": 1.0}),
    ("theta_from_top = ", "simple-pendulum", {"theta": 1.0, "theta_from_top": 1e-3}),
    ("theta_from_top = ", "simple-pendulum", {"theta_from_top": math.nan}),
    ("theta_from_top = ", "simple-pendulum", {"theta_from_top": None}),
    ("theta_from_top = ", "simple-pendulum", {"theta_from_top": 1e-3, "gravity": 0.0}),
    ("theta_from_top = ", "simple-pendulum/damped-large", {"theta_from_top": 1e-3}),
    ("theta_from_top = ", "simple-pendulum/forced-large", {"theta_from_top": 1e-3}),
    ("theta_from_top = ", "linear-pendulum", {"theta_from_top": 1e-3}),
)


@pytest.mark.parametrize(
    ("begins", "make"),
    [
        *(
            (f"{name} = ", lambda b=base, f=field, v=value: replace(b, **{f: v}))
            for name, base, field, value in BAD
        ),
        *((f"{name} = ", lambda m=make, a=given: m(*a)) for name, make, given in IMPOSSIBLE),
        *((begins, lambda n=name, c=changes: scene(n, c)) for begins, name, changes in SCENES),
    ],
)
def test_a_parameter_is_named(begins, make):
    with pytest.raises(ParameterError, match=f"^{re.escape(begins)}[^\n]*$"):
        make()
