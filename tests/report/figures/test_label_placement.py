"""Words beside marks."""

from __future__ import annotations

from inertialcal.report.figures.drawing.metrics import Box, placed

MARK = Box(0.0, 0.0, 5.0, 5.0)


def test_a_word_covers_neither_its_mark_nor_a_neighbour() -> None:
    alone = placed(0.0, 0.0, 5.0, "12", 8.0, [MARK])
    assert alone.on(MARK) == 0.0
    assert alone.x > 0.0
    other = Box(alone.x, alone.y, 6.0, 6.0)
    moved = placed(0.0, 0.0, 5.0, "12", 8.0, [MARK, other])
    assert (moved.on(MARK), moved.on(other)) == (0.0, 0.0)


def test_boxes_share_the_area_of_their_common_part() -> None:
    assert MARK.on(Box(6.0, 7.0, 5.0, 5.0)) == 4.0 * 3.0
    assert MARK.on(Box(11.0, 0.0, 5.0, 5.0)) == 0.0
