"""The calculators' drawings: any size, nothing cut, said without colour."""

import numpy as np
import pytest

from solarcal.report.instrument_plots import Curve, curve_plot, directions_plot, plate_drawing
from solarcal.report.scales import Sheet

HOURS = np.linspace(6.0, 18.0, 73)


@pytest.mark.parametrize("size", [(40, 10), (80, 24), (132, 43)])
def test_every_drawing_keeps_to_its_size(size):
    width, height = size
    sheet = Sheet(width, height, colour=False)
    drawn = (
        curve_plot(
            "drift",
            HOURS,
            [Curve("right", np.sin(HOURS), "●"), Curve("up", np.cos(HOURS), "+")],
            "solar time",
            sheet,
            hours=True,
        ),
        directions_plot([("S", "Sun", 120.0, 50.0), ("T", "target", 180.0, -5.0)], 35.0, sheet),
        plate_drawing(4.0, 13.0, 1.0, -2.0, sheet),
    )
    for picture in drawn:
        lines = picture.split("\n")
        assert len(lines) == height
        assert max(map(len, lines)) <= width


def test_the_dead_points_are_columns_of_their_own():
    angles = np.linspace(-85.0, 85.0, 50)
    drawn = curve_plot(
        "L", angles, [Curve("L", angles + 100.0, "●")], "angle", Sheet(80, 16, colour=False),
        marks=[(-90.0, "dead point"), (90.0, "dead point")],
    )  # fmt: skip
    head, *body = drawn.split("\n")
    assert "░ dead point" in head
    rows = [line for line in body if "░" in line]
    assert len(rows) >= 8
    assert all(line.count("░") == 2 for line in rows)


def test_a_constant_has_a_frame_too():
    assert "●" in curve_plot(
        "flat", HOURS, [Curve("c", np.zeros(73), "●")], "h", Sheet(60, 12, colour=False), hours=True
    )


def test_the_spot_lies_where_the_error_moved_it():
    """Moved right: the spot's circle reaches further right of the hole than left."""
    rows = plate_drawing(4.0, 13.0, 5.0, 0.0, Sheet(80, 20, colour=False)).split("\n")[1:]
    hole = [i for row in rows for i, c in enumerate(row) if c == "#"]
    spot = [i for row in rows for i, c in enumerate(row) if c == "o"]
    middle = 0.5 * (min(hole) + max(hole))
    assert max(spot) - middle > 2.0 * (middle - min(spot))


def test_sun_normal_and_target_are_letters_in_the_sky():
    drawn = directions_plot(
        [("S", "Sun", 110.0, 40.0), ("N", "normal", 140.0, 35.0), ("T", "target", 180.0, 10.0)],
        35.0, Sheet(80, 20, colour=False),
    )  # fmt: skip
    body = "\n".join(drawn.split("\n")[1:-2])
    assert [body.count(letter) for letter in "SNT"] == [1, 1, 1]


def test_where_the_title_leaves_no_room_the_glyphs_are_still_named():
    sheet = Sheet(30, 12, colour=False)
    assert plate_drawing(4.0, 13.0, 0.0, 0.0, sheet).split("\n")[0] == "# hole  o spot"
    wide = plate_drawing(4.0, 13.0, 0.0, 0.0, Sheet(60, 12, colour=False))
    assert wide.split("\n")[0] == "the plate from the mirror  # hole  o spot"
