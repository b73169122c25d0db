"""The worked examples of docs/physics.md are what the program computes."""

from pathlib import Path

import pytest

from solarcal.mount.drive import ScrewjackDrive, parse_drive, register
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.mount.mechanism import Mechanism

PAGE = (Path(__file__).parents[2] / "docs" / "physics.md").read_text(encoding="utf-8")


def table(first_heading: str) -> list[list[str]]:
    """The cells of the table whose header row begins with that cell and so many columns."""
    _, _, after = PAGE.partition(f"\n{first_heading}")
    rows = []
    for line in after.splitlines()[2:]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip().strip("`") for cell in line.strip("|").split("|")])
    return rows


EXAMPLES = table("| mount | latitude |")


def test_the_page_has_an_example_for_every_geometry():
    assert {row[0] for row in EXAMPLES} == set(GEOMETRIES)
    assert {row[0] for row in table("| mount | primary axis points |")} == set(GEOMETRIES)


@pytest.mark.parametrize("row", EXAMPLES, ids=lambda row: f"{row[0]} at {row[1]}")
def test_worked_example(row):
    coefficients = Coefficients(P1=0.5, P2=-0.2, P3=0.3, P4=0.1, P5=0.001, P6=-0.0005)
    assert "P1 = 0.5, P2 = -0.2, P3 = 0.3, P4 = 0.1, P5 = 0.001, P6 = -0.0005" in PAGE
    latitude, centre, azimuth, zenith, *printed = map(float, row[1:])
    mount = MountGeometry(row[0], latitude, centre)
    axes = mount.axes_from_horizontal(azimuth, zenith)
    formula = correction_deg(coefficients, *axes)
    exact = Mechanism(*coefficients.as_tuple()).errors_deg(mount, *axes)
    assert (*axes, *formula, *exact) == pytest.approx(printed, abs=0.5001e-4)


def test_the_example_by_hand_ends_on_the_printed_read_outs():
    ax1, ax2, e1, e2 = map(float, EXAMPLES[0][5:9])
    assert f"{ax1 + e1:.4f} and {ax2 + e2:.4f} by the formula" in PAGE


def test_screwjack_example():
    drive = parse_drive("screwjack:40:12:2.5:70:1200:-")
    assert isinstance(drive, ScrewjackDrive)
    assert f"SJP2 = {drive.SJP2:g} and SJP3 = {drive.SJP3:g}" in PAGE
    rows = table("| S | L | counts |")
    assert len(rows) == 4
    for angle, length, counts, on_register in ([float(cell) for cell in row] for row in rows):
        assert drive.length(angle) == pytest.approx(length, abs=0.5e-4)
        assert drive.counts(angle) == pytest.approx(counts, abs=0.05)
        assert register(drive, -30.0, angle) == on_register


def test_counts_per_degree_change_along_a_screwjack():
    drive = parse_drive("screwjack:40:12:2.5:70:1200:-")
    worth = [drive.counts(s + 0.5) - drive.counts(s - 0.5) for s in (-30.0, 60.0)]
    assert f"One degree is {worth[0]:.0f} counts at S = -30 and {worth[1]:.0f} at S = 60" in PAGE
