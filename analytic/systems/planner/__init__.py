"""A planner from rest pose to rest pose: turns, then lines, joined by slow motions.

The source shows that every rest pose can be reached (Chernousko 2020, section "Controllability").
`problem` holds the poses and limits. `construction` puts a plan together and checks where it ends;
`turns` and `lines` choose its manoeuvres and compute them, on one of the `tracks`. `manoeuvre`
holds the manoeuvres as data, `result` the plan.
"""
