"""What the technician sees: every size, no colour needed, nothing left out silently."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_up_session import hourly

from solarcal.mount.formula import Coefficients
from solarcal.report import plots, scales
from solarcal.report.canvas import Canvas
from solarcal.report.instrument_plots import sky_map
from solarcal.report.scales import Scale, Sheet
from solarcal.session.records import FitRecord
from solarcal.station.curves import session_plot_data

GOLDENS = Path(__file__).parent / "goldens"
ANSI = re.compile(r"\x1b\[[0-9;]*m")


@pytest.fixture
def full_day(june_day, fit_points):
    header, points = june_day
    return session_plot_data(header, points, fit_points(header, points))


@pytest.fixture
def empty(make_header):
    return session_plot_data(make_header(), [])


@pytest.fixture
def history(june_day, fit_points):
    header, points = june_day
    return [
        FitRecord(
            seq=n,
            utc="2026-06-21T15:00:00.000Z",
            method="linear",
            points=n,
            coefficients=fit_points(header, points[:n]).coefficients(),
            sigmas=None,
            sky_rms_deg=0.1,
        )
        for n in range(3, 13)
    ]


def every_plot(data, history, width, height, **how):
    return (
        plots.error_plot(data, Sheet(width, height, **how)),
        plots.residual_plot(data, Sheet(width, height, **how)),
        sky_map(data, Sheet(width, height, **how)),
        plots.convergence_plot(history, Sheet(width, height, **how)),
    )


def body(text):
    """Rows inside the frame, without the rulers."""
    rows = (re.search("[│┤](.*)│$", line) for line in text.split("\n")[1:])
    return [row[1] for row in rows if row]


@settings(
    derandomize=True,
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(width=st.integers(40, 200), height=st.integers(10, 60))
def test_every_plot_fits_the_size_asked_for(full_day, empty, history, width, height):
    for text in (
        *every_plot(full_day, history, width, height, colour=False),
        *every_plot(empty, [], width, height, colour=False),
    ):
        lines = text.split("\n")
        assert len(lines) == height
        assert max(map(len, lines)) <= width
        assert "\x1b" not in text


def test_each_point_is_drawn_for_both_axes_with_its_own_glyph(full_day):
    text = "".join(body(plots.error_plot(full_day, Sheet(140, 45, colour=False))))
    assert text.count(scales.AXIS1) == 12
    assert text.count(scales.AXIS2) == 12
    # Here and there a dot hides behind a point or behind the other axis.
    assert text.count(scales.MODEL1) > 45
    assert text.count(scales.MODEL2) > 45


def test_points_are_at_their_time_and_error(full_day):
    rows = body(plots.error_plot(full_day, Sheet(140, 45, colour=False)))
    cells = {(x, y) for y, row in enumerate(rows) for x, c in enumerate(row) if c == scales.AXIS1}
    columns = sorted(x for x, _ in cells)
    hours = full_day.points.solar_time_h
    expected = (hours - 4.0) / 16.0 * (len(rows[0]) - 1)
    assert np.abs(np.array(columns) - expected).max() <= 1.0
    by_column = [y for _, y in sorted(cells)]
    # Rows count downwards.
    assert np.corrcoef(by_column, full_day.points.err1_deg)[0, 1] < -0.999


def test_with_colour_the_same_characters_in_amber_and_green(full_day, history):
    plain = every_plot(full_day, history, 100, 30, colour=False)
    for theme in ("phosphor", "light"):
        coloured = every_plot(full_day, history, 100, 30, colour=True, theme=theme)
        for with_colour, without in zip(coloured, plain, strict=True):
            bare = "\n".join(line.rstrip() for line in ANSI.sub("", with_colour).split("\n"))
            assert bare == without
        palette = scales.PALETTES[theme]
        assert re.search(rf"\x1b\[38;5;{palette.axis1}m(\x1b\[1m)?{scales.AXIS1}", coloured[0])
        assert re.search(rf"\x1b\[38;5;{palette.axis2}m(\x1b\[1m)?{scales.AXIS2}", coloured[0])
        assert "48;" not in coloured[0], "the terminal keeps its own background"


def test_no_color_in_the_environment_wins(full_day, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b" not in plots.error_plot(full_day, Sheet(80, 24))


def test_the_same_data_give_the_same_plot_whatever_was_drawn_before(full_day, empty, history):
    first = plots.error_plot(full_day, Sheet(80, 24))
    every_plot(empty, history, 60, 15)
    assert plots.error_plot(full_day, Sheet(80, 24)) == first


def test_nothing_measured_is_said_in_words(empty):
    squeezed = " ".join(plots.error_plot(empty, Sheet(40, 10, colour=False)).split())
    assert "No points yet. The first one" in squeezed
    assert "No fit yet" in plots.residual_plot(empty, Sheet(80, 24, colour=False))
    assert "No points yet" in sky_map(empty, Sheet(80, 24, colour=False))
    assert "No fit yet" in plots.convergence_plot([], Sheet(80, 24, colour=False))


def test_times_beyond_the_limits_are_shaded_and_said_so(full_day):
    text = plots.error_plot(full_day, Sheet(80, 24, colour=False))
    assert f"{scales.SHADE} limits" in text.split("\n")[0]
    assert sum(scales.SHADE in row for row in body(text)) >= len(body(text)) - 1


def test_a_wide_band_is_drawn_where_there_is_room(june_day, fit_points):
    header, points = june_day
    data = session_plot_data(header, points[:4], fit_points(header, points[:4]))
    assert "1 sigma" in plots.error_plot(data, Sheet(80, 20, colour=False))
    assert "1 sigma" not in plots.error_plot(data, Sheet(80, 19, colour=False))
    assert "'" in "".join(body(plots.error_plot(data, Sheet(80, 20, colour=False))))


def test_points_of_a_later_day_are_hollow(make_header, make_points, fit_points):
    header = make_header()
    points = make_points(header, hourly("2026-06-21", 15, 23))
    points += make_points(header, hourly("2026-12-21", 16, 22), first_seq=100)
    data = session_plot_data(header, points, fit_points(header, points))
    text = "".join(body(plots.error_plot(data, Sheet(140, 45, colour=False))))
    assert text.count(scales.AXIS1) >= 8
    assert text.count(scales.AXIS1_LATER) >= 6
    assert text.count(scales.AXIS2_LATER) >= 6


def test_without_times_the_ruler_is_called_an_hour_angle(full_day):
    untimed = replace(full_day, days=0)
    assert "apparent solar time" in plots.error_plot(full_day, Sheet(80, 24, colour=False))
    assert "hour angle + 12" in plots.error_plot(untimed, Sheet(80, 24, colour=False))


def test_a_rejected_point_has_a_glyph_of_its_own(june_day, make_points, fit_points):
    header, points = june_day
    rejected = make_points(header, ["2026-06-21T22:30:00Z"], first_seq=80, status="rejected")
    data = session_plot_data(header, points + rejected, fit_points(header, points))
    text = plots.error_plot(data, Sheet(140, 45, colour=False))
    assert "x not used" in text.split("\n")[0]
    assert "".join(body(text)).count(scales.UNUSED) == 2


def test_both_axes_on_one_cell_are_not_lost(full_day):
    half = full_day.points.err2_deg
    together = replace(full_day, points=replace(full_day.points, err1_deg=half))
    text = plots.error_plot(together, Sheet(80, 24, colour=False))
    assert f"{scales.BOTH} both" in text.split("\n")[0]
    assert "".join(body(text)).count(scales.BOTH) + text.count("┤") >= 12


def test_an_unrealistic_model_does_not_flatten_the_points(full_day):
    wild = replace(full_day, model=replace(full_day.model, err1_deg=full_day.model.err1_deg * 400))
    text = plots.error_plot(wild, Sheet(140, 45, colour=False))
    assert "model off frame" in text.split("\n")[0]
    amber = [y for y, row in enumerate(body(text)) if scales.AXIS1 in row]
    assert max(amber) - min(amber) > 5


@pytest.mark.parametrize("site_latitude", [35.05, -33.9])
def test_the_sky_map_is_cut_away_from_the_sun(make_header, make_points, site_latitude):
    header = make_header()
    site = msgspec.structs.replace(header.site, latitude_deg=site_latitude)
    header = msgspec.structs.replace(header, site=site)
    points = make_points(header, hourly("2026-06-21", 15, 22))
    text = sky_map(session_plot_data(header, points), Sheet(100, 24, colour=False))
    ruler = text.split("\n")[-2].split()
    assert ruler[len(ruler) // 2] == ("S" if site_latitude > 0 else "N")
    assert "".join(body(text)).count(scales.AXIS1) >= 6


def test_convergence_shows_each_coefficient_by_its_digit(history):
    text = plots.convergence_plot(history, Sheet(100, 30, colour=False))
    inside = "".join(body(text))
    assert all(inside.count(digit) >= 4 for digit in "1234")
    assert "beyond the frame" in text.split("\n")[0]


def test_convergence_shows_one_sigma_of_each_coefficient(history):
    def bars(history):
        return "".join(body(plots.convergence_plot(history, Sheet(100, 30, colour=False)))).count(
            "│"
        )

    without = [msgspec.structs.replace(fit, sigmas=None) for fit in history]
    wide = [
        msgspec.structs.replace(fit, sigmas=Coefficients(*(0.1 for _ in range(6))))
        for fit in history
    ]
    assert bars(wide) >= bars(without) + 3 * len(history)


FINE = scales.View(fine=True)
BRAILLE = re.compile("[\u2801-\u28ff]")


def test_curves_in_braille_tell_the_axes_apart_without_colour(full_day):
    """Axis 1 is a whole line, axis 2 a dashed one; the points keep their glyphs."""
    text = plots.error_plot(full_day, Sheet(80, 15, colour=False), view=FINE)
    rows = body(text)
    dots = {
        (2 * x + column, 4 * y + row)
        for y, line in enumerate(rows)
        for x, character in enumerate(line)
        if BRAILLE.match(character)
        for bit, (column, row) in enumerate(
            ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3))
        )
        if (ord(character) - 0x2800) >> bit & 1
    }
    assert len({x for x, _ in dots}) > 80, "finer than one mark a column"
    assert scales.AXIS1 in text
    assert scales.AXIS2 in text
    assert "model ⠒⠒ ⠒ ⠒" in text.split("\n")[0]


def test_a_residual_of_a_fiftieth_of_a_degree_is_seen_at_80x24(full_day):
    """The plot pane of an 80x24 terminal is 80x15; tolerance and larger residuals share it."""
    points = full_day.points
    model1 = points.err1_deg - points.residual1_deg
    left = np.zeros(len(points.labels))
    left[2], left[7] = 0.02, 0.09
    quiet = replace(
        points,
        err1_deg=model1,
        residual1_deg=np.zeros_like(left),
        residual2_deg=left,
    )
    text = plots.residual_plot(
        replace(full_day, points=quiet), Sheet(80, 15, colour=False), view=FINE
    )
    without = replace(quiet, residual2_deg=np.where(left == 0.02, 0.0, left))
    other = plots.residual_plot(
        replace(full_day, points=without), Sheet(80, 15, colour=False), view=FINE
    )
    assert text != other
    changed = sum(a != b for a, b in zip(text, other, strict=True))
    assert changed >= 2, "the point and its line both moved"


def column_of_braille(low, high, values, rows=15):
    """Rows from the top in which the lines to these values have a dot, each in its own column."""
    canvas = Canvas(Sheet(40, rows + 4, colour=False), "")
    canvas.frame(Scale(0.0, 10.0, (0.0, 10.0), ("a", "b")), Scale(low, high, (), ()))
    at = np.linspace(2.0, 8.0, len(values))
    canvas.stems(at, np.array(values), 1)
    grid = canvas.finish([]).split("\n")[2:-2]
    columns = sorted({k for row in grid for k, c in enumerate(row) if "\u2800" < c <= "\u28ff"})
    return [
        [n for n, row in enumerate(grid) if len(row) > k and "\u2800" < row[k] <= "\u28ff"]
        for k in columns
    ]


def test_a_line_goes_from_zero_to_each_residual_and_ends_at_the_frame():
    up, down, beyond = column_of_braille(-1.0, 1.0, [0.5, -1.0, 5.0])
    middle = max(beyond)
    assert min(beyond) == 0, "what is beyond the frame ends at its edge"
    assert beyond == list(range(middle + 1))
    assert up == list(range(up[0], middle + 1)), "no gap from the value to zero"
    assert 0 < up[0] < middle, "half as high"
    assert down == list(range(middle, down[-1] + 1))
    assert down[-1] > middle + 5


def test_of_a_zoomed_residual_only_the_part_in_the_window_is_drawn():
    """Zero is below the window: 0.4 is below it too, 0.75 reaches its middle, 2 its top."""
    middle, top = column_of_braille(0.5, 1.0, [0.4, 0.75, 2.0])
    assert middle[-1] == top[-1], "both come from below the window"
    assert top == list(range(top[-1] + 1))
    assert 4 < middle[0] < 10


def test_the_error_plot_of_an_80x24_terminal_has_five_labelled_ticks(full_day):
    text = plots.error_plot(full_day, Sheet(80, 15, colour=False), view=FINE)
    labels = re.findall(r"^ *[+-]?\d+\.\d+┤", text, re.M)
    assert len(labels) >= 5


def test_a_cursor_reads_the_values_of_its_point(full_day):
    view = scales.View(cursor=3, fine=True)
    header = plots.error_plot(full_day, Sheet(100, 30, colour=False), view=view).split("\n")[0]
    assert f"record {full_day.points.labels[3]}" in header
    assert f"{full_day.points.err1_deg[3]:+.4f}" in header
    assert f"{full_day.points.err2_deg[3]:+.4f}" in header


@pytest.mark.parametrize("width", [80, 140])
def test_zoom_shows_a_part_and_never_beyond_the_ends(full_day, width):
    zoomed = scales.View(zoom=4.0, x=0.0, y=0.5, fine=True)
    text = plots.error_plot(full_day, Sheet(width, 24, colour=False), view=zoomed)
    first = re.search(r"(\d\d):(\d\d)", text.split("\n")[-2])
    assert first is not None
    assert int(first[1]) in (4, 5), "the window stays at the beginning of the day"
    assert "09:00" not in text, "a quarter of the day"


def test_the_window_is_centred_on_the_cursor_it_follows(full_day):
    view = scales.View(zoom=6.0, cursor=5, follows=True, fine=True)
    text = plots.error_plot(full_day, Sheet(100, 30, colour=False), view=view)
    assert {scales.AXIS1, scales.AXIS2} <= set("".join(body(text))), "both axes of it are in view"


@pytest.mark.parametrize(("low", "high"), [(-0.03, 0.02), (-2.3, 0.7), (0.0, 90.0), (-1e-6, 1e-6)])
@pytest.mark.parametrize("cells", [6, 18, 50])
@pytest.mark.parametrize("fine", [False, True])
def test_ticks_are_round_and_inside(low, high, cells, fine):
    scale = scales.value_scale(low, high, cells, fine=fine)
    least = 5 if fine and cells >= 10 else 2
    assert least <= len(scale.ticks) <= max(5, 2 * cells // 3 if fine else cells // 2)
    assert all(low <= tick <= high for tick in scale.ticks)
    assert [float(label) for label in scale.labels] == pytest.approx(scale.ticks)
    assert len({len(label) for label in scale.labels}) == 1


@pytest.mark.parametrize(
    ("name", "width", "height"), [("error-80x24", 80, 24), ("error-140x45", 140, 45)]
)
def test_the_error_plot_looks_as_it_did_when_last_looked_at(full_day, name, width, height):
    text = plots.error_plot(full_day, Sheet(width, height, colour=False))
    golden = (GOLDENS / f"{name}.txt").read_text(encoding="utf-8").rstrip("\n")
    pairs = zip(text.ljust(len(golden)), golden.ljust(len(text)), strict=True)
    # Another numpy may round a dot into the neighbouring cell: a few characters, never the picture.
    assert sum(a != b for a, b in pairs) <= 6, text


def test_plotext_is_not_loaded_before_the_first_plot():
    code = "import solarcal.report.plots, sys; sys.exit('plotext' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
