"""Links of a built site: those to files and anchors that are not there are told."""

from pathlib import Path

from links import broken


def test_broken_links_are_told(tmp_path: Path) -> None:
    """A missing file, a missing anchor; not addresses on the net."""
    (tmp_path / "b.html").write_text('<h1 id="top">b</h1>')
    links = ("b.html", "b.html#top", "b.html#end", "c.html", "#own", "https://example.org/nothing", "a%20b.txt")
    (tmp_path / "a b.txt").write_text("")
    (tmp_path / "a.html").write_text("".join(f'<a href="{link}" id="own">x</a>' for link in links))
    wrong, inside, outside = broken(tmp_path)
    assert wrong == ["a.html: b.html#end", "a.html: c.html"] and (inside, outside) == (6, 1)
