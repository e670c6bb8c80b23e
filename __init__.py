"""plumbob holds physics engines against exact answers: how wrong, at what cost, which setting."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plumbob.reports.audit_from_python import audit, audit_contacts, audit_reproducible
    from plumbob.reports.difference_from_python import assert_same_motion, difference
    from plumbob.reports.judge.assertion import check
    from plumbob.reports.stored_results import load_results as load

__all__ = [
    "__version__",
    "assert_same_motion",
    "audit",
    "audit_contacts",
    "audit_reproducible",
    "check",
    "difference",
    "load",
]


def __getattr__(name: str) -> Any:
    """The names above, looked up when asked for: importing plumbob loads no engine."""
    if name == "check":
        from plumbob.reports.judge.assertion import check

        return check
    if name == "audit":
        from plumbob.reports.audit_from_python import audit

        return audit
    if name == "audit_contacts":
        from plumbob.reports.audit_from_python import audit_contacts

        return audit_contacts
    if name == "audit_reproducible":
        from plumbob.reports.audit_from_python import audit_reproducible

        return audit_reproducible
    if name == "load":
        from plumbob.reports.stored_results import load_results

        return load_results
    if name == "difference":
        from plumbob.reports.difference_from_python import difference

        return difference
    if name == "assert_same_motion":
        from plumbob.reports.difference_from_python import assert_same_motion

        return assert_same_motion
    if name == "__version__":
        from importlib import metadata

        try:
            return metadata.version("plumbob")
        except metadata.PackageNotFoundError:
            return "unknown"
    raise AttributeError(f"module 'plumbob' has no attribute {name!r}")
