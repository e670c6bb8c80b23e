"""How tight the tolerances of a stored study are: by method, and the loosest.

    python -m plumbob.tests.validation.tightness FOLDER [COUNT]

FOLDER is one that `plumbob validate --out` wrote; COUNT, 10 without, is how many are listed.
"""

import sys
from pathlib import Path

from plumbob.engines.study.store import FILE, load
from plumbob.reports.judge.study_verdicts import judge_study
from plumbob.reports.judge.tightness import slacks, tightness
from plumbob.reports.view.top_tables import tightness_tables


def loosest(every, count):
    """The loosest of each scene, method and observable, the worst first; without round-off."""
    worst = {}
    for slack in every:
        key = slack.scene, slack.method, slack.observable
        if not slack.rounded and (key not in worst or over_use(slack) > over_use(worst[key])):
            worst[key] = slack
    return sorted(worst.values(), key=over_use, reverse=True)[:count]


def over_use(slack):
    """What is allowed over what is used."""
    return slack.allowed / slack.used


def main(arguments):
    """Print the tables; returns an exit code."""
    folder, *rest = arguments
    study = load(Path(folder) / FILE)
    if study is None:
        print(f"{folder}: no stored study", file=sys.stderr)
        return 2
    judged = judge_study(study)
    every = list(slacks(study, judged))
    for table in tightness_tables(tightness(every)):
        print(f"\n{table.caption}", " | ".join(table.heads), sep="\n")
        for cells in table.rows:
            print(" | ".join(cell.text for cell in cells))
    for bound_only in (False, True):
        print(f"\nloosest: {'bounds alone' if bound_only else 'predicted'}")
        chosen = (slack for slack in every if slack.bound_only == bound_only)
        for slack in loosest(chosen, int(rest[0]) if rest else 10):
            print(
                f"{over_use(slack):9.2g} {slack.scene} {slack.method} {slack.observable} "
                f"{slack.step:.4g}: allowed {slack.allowed:.2g}, {slack.used:.2g}"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
