"""Audit a model of plumbob and write the content of its page into the file that is shipped with the
package as a sample.

    python -m plumbob.tests.validation.sample_audit

It takes five seconds of processor time. Look at the differences before they are committed: the
errors of the audit, and the text of its page.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import plumbob
from plumbob.engines.study.codec import unstructured
from plumbob.reports.analyses.replay.audit_motion import audit_replay
from plumbob.reports.audit_from_python import audit
from plumbob.reports.view.audit.html import SAMPLE_AUDIT
from plumbob.reports.view.audit.page import audit_answer, audit_page

MODEL = "models/rolling_disc/scene.xml"


def audited_now():
    """The content of the sample page, of an audit that runs here and now."""
    result = replace(audit(Path(plumbob.__file__).parent / MODEL), name=MODEL)
    return audit_page(
        audit_answer(result),
        result,
        f"plumbob audit {MODEL} --out audit-out",
        audit_replay(result),
    )


def main():
    """Write the file; return the exit code."""
    SAMPLE_AUDIT.write_text(json.dumps(unstructured(audited_now())) + "\n", "utf-8")
    print(SAMPLE_AUDIT)
    return 0


if __name__ == "__main__":
    sys.exit(main())
