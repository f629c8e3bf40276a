"""Do all links of the built site lead to something? ``python docs/_ext/links.py FOLDER``: files and anchors, from disk.

Addresses on the net are counted, not asked: ``python -m sphinx -b linkcheck docs DIR`` asks them where there is a net.
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what a tag leads to, and what leads to it."""
        for name, value in attrs:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value and tag != "base":
                self.links.append(value)


def read(path: Path) -> Page:
    """Return a page's links and anchors."""
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def broken(folder: Path) -> tuple[list[str], int, int]:
    """Return what leads nowhere, and how many links lead within the site and out of it."""
    pages = {path.resolve(): read(path) for path in folder.rglob("*.html")}
    wrong, inside, outside = [], 0, 0
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                outside += parts.scheme in ("http", "https")
                continue
            inside += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            known = pages[target].anchors if target in pages else set()
            if not target.exists() or (parts.fragment and target in pages and unquote(parts.fragment) not in known):
                wrong.append(f"{path.relative_to(folder.resolve())}: {link}")
    return wrong, inside, outside


def main(folder: Path) -> int:
    """Say what leads nowhere."""
    wrong, inside, outside = broken(folder)
    sys.stdout.write("".join(f"{line}\n" for line in wrong))
    sys.stdout.write(f"{inside} links within the site, {len(wrong)} broken; {outside} out of it, not asked\n")
    return 1 if wrong or not inside else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
