"""Exact solutions of the mechanical systems, one module or folder each."""
