"""The site of a study with its replays: one on the page of each scene, and in the one file."""

import pytest

from plumbob.reports.view.site.writing import site_in_one_file, write_site
from plumbob.reports.view.top_tables import anchor
from plumbob.tests.replay.in_browser import found, opened, set_time
from plumbob.tests.site.whole_profile import small
from plumbob.tests.support.page_document import site_files
from plumbob.tests.support.studies import SCENE, quick


@pytest.mark.long
def test_each_scene_of_a_site_has_its_replay(browser, tmp_path):
    whole = small()
    pages = {page.stem: page for page in site_files(write_site(whole, tmp_path))}
    single = tmp_path / "one.html"
    single.write_text(site_in_one_file(whole), "utf-8")
    assert all(
        pages[anchor(scene.name)].read_text("utf-8").count('<figure class="replay"') == 1
        for scene in quick().scenes
    )
    for page in (pages[anchor(SCENE)], single):
        for shown in opened(browser, page):
            shown.evaluate(f"location.hash = '{anchor(SCENE)}'")
            figure = found(shown, SCENE)
            set_time(figure, 0.5)
            assert "250 ms of 500 ms" in figure.locator(".now").inner_text()
            assert figure.locator(".layers li").count() == 3
            assert (
                "mujoco/euler, 1 ms (default settings but for the step)"
                in figure.locator(".layers").inner_text()
            )
