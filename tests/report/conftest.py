"""What a reader of any picture may ask: nothing written over another, nothing cut off."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

_SLACK = 1.0  # pixels that boxes may share


@pytest.fixture
def collisions(monkeypatch: pytest.MonkeyPatch) -> Callable[[Figure], list[str]]:
    """Return what names the pairs of texts of a figure that overlap, and the texts that leave it."""

    def found(figure: Figure) -> list[str]:
        figure.set_dpi(300)
        drawn: dict[int, Text] = {}
        plain = Text.draw

        def noted(self: Text, *args: object, **options: object) -> None:
            """Draw a text, and note that it is drawn."""
            drawn[id(self)] = self
            plain(self, *args, **options)

        with monkeypatch.context() as patch:
            patch.setattr(Text, "draw", noted)
            figure.canvas.draw()
        boxes = [(text.get_text(), Text.get_window_extent(text)) for text in drawn.values() if text.get_text().strip()]
        assert boxes
        (width, height), low = figure.bbox.size + _SLACK, -_SLACK
        out = [f"{words!r} is cut off" for words, box in boxes
               if box.x0 < low or box.y0 < low or box.x1 > width or box.y1 > height]
        return out + [
            f"{one!r} over {other!r}" for (one, a), (other, b) in combinations(boxes, 2)
            if min(a.x1, b.x1) - max(a.x0, b.x0) > _SLACK and min(a.y1, b.y1) - max(a.y0, b.y0) > _SLACK
        ]

    return found
