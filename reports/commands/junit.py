"""Verdicts as JUnit XML, which continuous integration servers read."""

from __future__ import annotations

import os
from pathlib import Path
from xml.etree import ElementTree

from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.reports.judge.expectations import as_expected, expected
from plumbob.reports.judge.verdict import Judgements


def write_junit(file: Path, study: Study, judged: Judgements) -> None:
    """Write one test case for each scene and method; what is not as expected is a failure."""
    suite = ElementTree.Element("testsuite", name="plumbob", tests=str(len(judged)))
    counts = {"failures": 0, "skipped": 0}
    for scene, method in pairs(study.scenes, study.methods):
        found = judged[scene.name, method.name].whole
        case = ElementTree.SubElement(suite, "testcase", classname=scene.name, name=method.name)
        if found.verdict in ("unsupported", "missing"):
            ElementTree.SubElement(case, "skipped", message=found.reason)
            counts["skipped"] += 1
        elif not as_expected(scene, method, found):
            wanted = expected(scene.name, method.name).verdict
            text = f"{found.verdict}, expected {wanted}: {found.reason}"
            ElementTree.SubElement(case, "failure", message=text)
            counts["failures"] += 1
    suite.attrib.update({name: str(count) for name, count in counts.items()})
    suite.set("time", f"{sum(study.seconds.values()):.3f}")
    part = file.with_name(f".{file.name}.part")
    ElementTree.ElementTree(suite).write(part, encoding="utf-8", xml_declaration=True)
    os.replace(part, file)
