"""Exact sensitivities: derivatives of exact motions by parameters and by the initial state.

A parameter's neighbours (`neighbours`) are the same problem with the parameter moved a little. No
motion of a neighbour is integrated: its equations, its start and its observables are evaluated on
the motion itself, and their derivatives by the parameter follow from a stencil of order 8.

    smooth motions           `smooth_motion`, the variational equation
    three Coulomb points     `sliding_motion`, with saltation at every event
    closed forms in pieces   `phases`, stencils of the formula in each of its phases
"""
