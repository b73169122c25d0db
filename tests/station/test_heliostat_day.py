"""A heliostat is calibrated by the same procedure and fit as a tracker."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.model.evidence.branch import branch_warning
from solarcal.model.evidence.direct import evidence_sentences
from solarcal.mount.controller import ideal_axes_deg
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.optics.offset_mirror import Heliostat
from solarcal.optics.reflection import Target
from solarcal.session.interchange import read_table
from solarcal.session.interchange.csv_points import write_points_csv
from solarcal.session.journal import Journal
from solarcal.station.analysing import stamp_findings
from solarcal.station.curves import session_plot_data
from solarcal.station.fitting import solve, solve_table
from solarcal.station.headless import calibrate
from solarcal.station.technician import Schedule
from solarcal.timescale import parse_utc
from solarcal.unit.drivers.solartrak import SolarTrakUnit


@pytest.fixture(scope="module")
def day():
    emulator = Emulator(load_scenario("heliostat"), seed=2)
    return calibrate(
        SolarTrakUnit(lambda: InProcessLink(emulator)), Journal.memory, Schedule(points=8)
    )


def test_a_day_brings_the_mirrors_normal_to_where_it_belongs(day):
    """The beam moves by twice the normal: 0.02 deg of the normal are 0.04 deg on the board."""
    assert day.truth_before.year_rms_deg > 0.5
    assert day.truth_after.year_rms_deg < 0.03
    # What is left agrees with the eye's 0.01 deg (and the technician's centring).
    assert day.solution.sky_rms_deg < 0.03


def test_the_station_knows_the_units_ideal_without_being_told_its_normal(day):
    """Every point passed the check of the unit's ideal: Sun from clock and site, target, mirror."""
    header = day.session.header
    told = load_scenario("heliostat").unit.heliostat()
    assert header.unit.heliostat.target == told.target
    assert header.unit.heliostat.offset.PivotRefl_Z == pytest.approx(told.offset.PivotRefl_Z)
    assert len(day.session.accepted) == 8
    point = day.session.accepted[0]
    table = day.session.table
    ours = ideal_axes_deg(
        day.session.geometry, header.site, float(table.utc_s[0]), header.unit.heliostat
    )
    assert point.ideal_deg == pytest.approx(ours, abs=0.01)
    bare = ideal_axes_deg(day.session.geometry, header.site, float(table.utc_s[0]))
    assert abs(bare[1] - point.ideal_deg[1]) > 5.0


def test_the_suns_place_is_shown_and_not_the_normals(day):
    data = session_plot_data(day.session.header, day.session.accepted, day.solution)
    near = [
        np.min(
            np.hypot(
                (data.path.azimuth_deg - a) * np.cos(np.radians(h)), data.path.elevation_deg - h
            )
        )
        for a, h in zip(
            data.points.azimuth_deg.tolist(), data.points.elevation_deg.tolist(), strict=True
        )
    ]
    # Half of ten minutes of the Sun from a dot of its path.
    assert max(near) < 1.3


def test_no_evidence_speaks_against_it(day):
    """The unit's Sun is ours through the mirror, and its normals cross no edge of the branch."""
    assert "unit's Sun" not in " ".join(evidence_sentences(day.session))
    header = day.session.header
    noon_s = parse_utc("2026-06-10T19:00:00Z")
    assert branch_warning(header, noon_s) is None
    # The same target in the North: the normals pass where a branch about the South ends.
    target = Target(0.0, 85.0, 120.0)
    unit = msgspec.structs.replace(
        header.unit,
        heliostat=Heliostat(target),
        limits=Limits(AxisLimits(-180.0, 180.0), AxisLimits(2.0, 88.0)),
    )
    north = msgspec.structs.replace(header, unit=unit)
    assert "crosses the edge" in (branch_warning(north, noon_s) or "")


def test_its_points_survive_a_csv_file(day, tmp_path: Path):
    table = day.session.table
    path = tmp_path / "heliostat.csv"
    write_points_csv(table, path)
    again = read_table(path)
    assert again.heliostat is not None
    assert again.heliostat.target == table.heliostat.target
    assert stamp_findings(again) == ()
    live = solve(day.session)
    read = solve_table(again, header=day.session.header)
    assert live is not None
    for name in ("P1", "P2", "P3", "P4"):
        assert getattr(read.coefficients(), name) == pytest.approx(
            getattr(live.coefficients(), name), abs=1e-4
        )
