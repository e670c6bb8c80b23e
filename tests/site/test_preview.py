"""What is shown with a link to a site: words, an icon and a picture."""

import re

from plumbob.tests.support.page_document import site_files


def test_each_page_has_words_of_its_own_and_the_icon(index):
    shown = []
    for file in site_files(index):
        text = file.read_text("utf-8")
        title, words = re.findall(
            r'<meta property="og:(?:title|description)" content="([^"]+)">', text
        )
        assert f"<title>{title}</title>" in text
        assert f'<meta name="description" content="{words}">' in text
        (icon,) = re.findall(r'<link rel="icon" href="([^"]+)"', text)
        assert (file.parent / icon).is_file()
        for picture in re.findall(r'<meta property="og:image" content="([^"]+)">', text):
            assert (file.parent / picture).is_file()
        shown.append((title, words))
    assert len(set(shown)) == len(shown)
