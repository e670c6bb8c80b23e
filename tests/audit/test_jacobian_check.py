"""An audit says so if MuJoCo's sparse solver gives other accelerations than its dense one."""

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.own_model import jacobian_check
from plumbob.engines.audit.user_models import user_models
from plumbob.engines.own_motion import AS_IT_STANDS

JOINTED = """<body pos="{place} 0 0"><joint axis="0 1 0"/><joint axis="1 0 0"/>
<geom size=".05" pos=".1 0 0"/>{child}</body>"""


def tree(jacobian):
    """A trunk that touches the ground, with four branches of four bodies: 38 degrees of freedom."""
    branch = ""
    for _ in range(4):
        branch = JOINTED.format(place=0.2, child=branch)
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option jacobian="{jacobian}"/><worldbody><geom type="plane" size="9 9 1"/>
        <body pos="0 0 .049"><freejoint/><geom size=".05"/>{4 * branch}</body></worldbody>
        </mujoco>"""
    )


@pytest.mark.parametrize("jacobian", ["dense", "sparse"])
def test_a_right_solver_is_not_named(jacobian):
    model = tree(jacobian)
    assert model.nv == 38
    assert not [
        note for note in user_models().model(model, AS_IT_STANDS).notes if "wrong" in note
    ]


@pytest.mark.parametrize(("off", "named"), [(1e-7, False), (1e-5, True)])
def test_a_sparse_solver_that_is_off_is_named(off, named, monkeypatch):
    """Both sides of the limit of a millionth."""
    right = jacobian_check.accelerations

    def wrong(model, start, form):
        sparse = form == mujoco.mjtJacobian.mjJAC_SPARSE
        return right(model, start, form) * (1.0 + off * sparse)

    monkeypatch.setattr(jacobian_check, "accelerations", wrong)
    notes = user_models().model(tree("sparse"), AS_IT_STANDS).notes
    assert any('set jacobian="dense" in <option>' in note for note in notes) == named
