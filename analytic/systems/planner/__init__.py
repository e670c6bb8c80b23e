"""A planner from rest pose to rest pose: turns, then lines, joined by slow motions.

The source shows that every rest pose can be reached (Chernousko 2020, section "Controllability").
"""
