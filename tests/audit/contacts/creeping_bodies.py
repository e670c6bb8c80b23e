"""Bodies that creep under an engine's steps, with settings of their contacts to choose."""

from itertools import product

CONES = (("pyramidal", 1), ("pyramidal", 20), ("elliptic", 1), ("elliptic", 20))
IMPEDANCES = (
    "0.9 0.95 0.001",
    "0.95 0.99 0.001",
    "0.8 0.95 0.002 0.3 3",
    "0.98 0.998 0.0005",
    "0.9 0.9 0.001",
)
STEPS = (0.001, 0.002, 0.005)
RAMP = """<geom type="plane" size="9 9 1" euler="0 12 30" friction="0.5"/>
<body pos="0 0 .06" euler="0 12 30"><freejoint/>
<geom type="box" size=".1 .08 .05" mass="2" friction="0.5"/></body>"""
ROD = """<body pos="-.05 0 0"><joint name="l" type="slide" axis="1 0 0"/>
<geom type="box" size=".01 .02 .02" mass=".1"/></body>
<body pos=".05 0 0"><joint name="r" type="slide" axis="-1 0 0"/>
<geom type="box" size=".01 .02 .02" mass=".1"/></body>
<body><freejoint/><geom type="capsule" fromto="-.03 0 0 .03 0 0" size=".01" mass=".2"/></body>"""
STACK = """<geom type="plane" size="9 9 1" euler="0 6 0"/>
<body pos="0.0052 0 .0497" euler="0 6 0"><freejoint/>
<geom type="box" size=".05 .05 .05" mass="1"/></body>
<body pos="0.0157 0 .1492" euler="0 6 0"><freejoint/>
<geom type="box" size=".05 .05 .05" mass="1"/></body>"""
GRIP = """<actuator><motor joint="l"/><motor joint="r"/></actuator>
<keyframe><key name="grip" ctrl="4 4"/></keyframe>"""
BODIES = ((RAMP, "", None), (ROD, GRIP, "grip"), (STACK, "", None))


def combinations():
    """The 60 combinations of cone and impratio, solimp and step, each with one of the bodies in
    turn: (text, keyframe)."""
    rows = list(product(CONES, IMPEDANCES, STEPS))
    return [
        creeping(*BODIES[number % 3 - number // 3 % 3], *row) for number, row in enumerate(rows)
    ]


def creeping(bodies, rest, keyframe, cone, impedance, step):
    """The text of a model, and the keyframe in which it starts."""
    name, ratio = cone
    return (
        f'<mujoco><option timestep="{step}" cone="{name}" impratio="{ratio}"/>'
        f'<default><geom solimp="{impedance}"/></default>'
        f"<worldbody>{bodies}</worldbody>{rest}</mujoco>"
    ), keyframe
