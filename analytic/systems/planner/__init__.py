"""A planner from rest pose to rest pose: turns, then lines, joined by slow motions.

The source shows that every rest pose can be reached (Chernousko 2020, section "Controllability").
`construction` puts a plan together and checks where it ends; `turns` and `lines` choose and compute
its manoeuvres on one of the `tracks`; `manoeuvre` has the manoeuvres as
data, `problem` the poses and limits, `result` the plan.
"""
