"""The page of a study with its replays: one in each scene, drawn beside everything else."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Browser

from plumbob.reports.findings import section
from plumbob.reports.view.page import write_page
from plumbob.reports.view.replay import replay
from plumbob.tests.replay.in_browser import found, opened, set_time
from plumbob.tests.support.studies import SCENE, quick


def test_each_scene_of_a_page_has_its_replay(chromium: Browser, tmp_path: Path) -> None:
    page = write_page(quick(), tmp_path, section, replays=replay)
    for shown in opened(chromium, page):
        assert shown.locator(".replay").count() == len(quick().scenes)
        shown.evaluate(f"location.hash = '{SCENE.replace('/', '-')}'")
        figure = found(shown, SCENE)
        set_time(figure, 0.5)
        assert "250 ms of 500 ms" in figure.locator(".now").inner_text()
        assert figure.locator(".layers li").count() == 3
        assert "mujoco/euler, 2 ms (default settings)" in figure.locator(".layers").inner_text()
