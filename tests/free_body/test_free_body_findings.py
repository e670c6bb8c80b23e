"""The commands solve the free body."""

import json

from plumbob.reports.cli import main


def test_solve_in_words_and_in_json(capsys):
    assert main(["solve", "free-body", "--times", "1,5", "--set", "angular_velocity=[1,2,3]"]) == 0
    assert "attitude_w" in capsys.readouterr().out
    assert main(["solve", "free-body/symmetric", "--times", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    text = json.dumps(found)
    assert "angular_velocity_x" in text
    assert '"kind"' in text
    assert "half_period" in text
