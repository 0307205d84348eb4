"""Reads HTML strictly enough to see a broken page."""

from html.parser import HTMLParser

_EMPTY = {"meta", "br", "img", "link", "input", "hr", "col", "path", "use", "rect", "image", "stop"}
_LOADS = {"src", "srcset", "href", "xlink:href", "data", "poster", "action"}


class Page(HTMLParser):
    """The text of a page, its tags, and what it would load; raises AssertionError on tags that don't nest."""

    def __init__(self, html: str):
        super().__init__()
        self.text, self.tags, self.loads, self.ids = "", [], [], []
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        links = [value for name, value in attributes if name in _LOADS]
        self.loads += links if tag != "a" else []
        self.ids += [value for name, value in attributes if name == "id"]
        if tag not in _EMPTY:
            self._open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in _EMPTY:
            self._open.pop()

    def handle_endtag(self, tag):
        if tag not in _EMPTY:
            assert self._open.pop() == tag

    def handle_data(self, data):
        self.text += data


def check_self_contained(html: str) -> Page:
    """The page, after checking that it loads nothing from anywhere and repeats no id."""
    page = Page(html)
    assert all(link.startswith(("data:", "#")) for link in page.loads), page.loads
    assert "@import" not in html
    assert "url(http" not in html
    assert "script" not in page.tags
    assert len(page.ids) == len(set(page.ids))
    return page
