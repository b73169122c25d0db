"""Clock, Sun, P and O of a unit that has none of them, kept by the station."""

import pytest

from solarcal.errors import ConfigurationError, UnitRefused
from solarcal.mount.controller import ideal_axes_deg
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.profiles import MountDescription
from solarcal.site import Site
from solarcal.station.described_unit import unit_parameters
from solarcal.station.software_controller.coefficient_store import (
    FileStore,
    MemoryStore,
    StoredCorrection,
)
from solarcal.station.software_controller.controller_model import SoftwareControllerModel
from solarcal.timescale import parse_utc

SITE = Site(35.05, -106.48, 1830.0)
SOUTH = Site(-23.55, -46.63)
NOON = parse_utc("2026-06-03T19:00:00Z")
NIGHT = parse_utc("2026-06-03T08:00:00Z")
P = Coefficients(0.3, -0.36, 0.1, 0.05, 0.0004, -0.0006)


class StoppedClock:
    def __init__(self, utc_s=NOON):
        self.now = utc_s

    def utc_s(self):
        return self.now

    def wait(self, seconds):
        self.now += seconds


def model(store=None, clock=None, **described):
    return SoftwareControllerModel(
        MountDescription(**described), SITE, clock or StoppedClock(), store or MemoryStore()
    )


def test_the_ideal_angles_are_those_of_a_solartrak_at_that_place_and_time():
    it = model()
    assert it.ideal_deg(NOON) == ideal_axes_deg(it.geometry, SITE, NOON)


def test_a_sun_offset_makes_reading_equal_to_ideal_plus_e_plus_o():
    it = model()
    it.write(P, Offsets())
    ideal1, ideal2 = it.ideal_deg(NOON)
    offsets = it.set_sun_offset(NOON, ideal1 + 0.5, ideal2 - 0.2)
    e1, e2 = correction_deg(P, ideal1, ideal2)
    assert pytest.approx(0.5 - float(e1), abs=1e-6) == offsets.O1
    assert pytest.approx(-0.2 - float(e2), abs=1e-6) == offsets.O2
    assert it.target_deg(NOON) == pytest.approx((ideal1 + 0.5, ideal2 - 0.2), abs=1e-6)


def test_no_sun_offset_at_night():
    with pytest.raises(UnitRefused, match="below the horizon"):
        model().set_sun_offset(NIGHT, 0.0, 80.0)


def test_a_time_tick_corrects_the_clock_and_lasts_as_long_as_the_line():
    clock = StoppedClock()
    it = model(clock=clock)
    it.set_clock(NOON + 2.5)
    clock.wait(100.0)
    assert it.utc_s() == pytest.approx(NOON + 102.5)
    assert model(clock=clock).utc_s() == pytest.approx(NOON + 100.0)


def test_p_and_o_survive_a_restart(tmp_path):
    store = FileStore(tmp_path / "units" / "rotor.toml")
    model(store).write(P, Offsets(0.1, -0.2))
    again = model(FileStore(store.path))
    assert (again.coefficients, again.offsets) == (P, Offsets(0.1, -0.2))
    stored = again.stored()
    assert stored.permanent_coefficients == P
    assert stored.permanent_offsets == Offsets(0.1, -0.2)
    assert [path.name for path in store.path.parent.iterdir()] == ["rotor.toml"]


def test_a_damaged_file_of_p_and_o_is_named_and_nothing_is_assumed(tmp_path):
    path = tmp_path / "rotor.toml"
    path.write_text("coefficients = 3\n")
    with pytest.raises(ConfigurationError, match=r"rotor\.toml"):
        model(FileStore(path))


def test_what_cannot_be_kept_is_not_in_force(tmp_path):
    (tmp_path / "units").write_text("a file where the folder belongs")
    it = model(FileStore(tmp_path / "units" / "rotor.toml"))
    with pytest.raises(ConfigurationError, match="cannot be written"):
        it.write(P, Offsets())
    assert it.coefficients == Coefficients()


def test_a_units_name_cannot_lead_out_of_the_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_UNITS", str(tmp_path))
    path = FileStore.of_unit("Hamlib Dummy", "../../etc/passwd").path
    assert path == tmp_path / "Hamlib-Dummy-etc-passwd.toml"
    assert FileStore.of_unit("..", "").path.parent == tmp_path
    assert StoredCorrection() == FileStore(path).load()


def test_south_of_the_equator_the_branch_is_around_180():
    it = SoftwareControllerModel(MountDescription(), SOUTH, StoppedClock(), MemoryStore())
    assert it.unit_site.ax1_centre_deg == 180.0
    assert it.parameters.limits.axis1 == AxisLimits(0.0, 360.0)


def test_described_limits_never_go_beyond_the_units_own():
    rotor = Limits(AxisLimits(-170.0, 170.0), AxisLimits(10.0, 90.0))
    told = unit_parameters(
        MountDescription(limits1_deg=(-175.0, 120.0), limits2_deg=None), SITE, rotor
    )
    assert told.limits == Limits(AxisLimits(-170.0, 120.0), AxisLimits(10.0, 90.0))
    with pytest.raises(ConfigurationError, match="axis 2, 91 to 95 deg, lie outside"):
        unit_parameters(MountDescription(limits2_deg=(91.0, 95.0)), SITE, rotor)


def test_a_drive_that_is_none_is_said_with_its_axis():
    with pytest.raises(ConfigurationError, match="mount: axis 2: drive 'belt'"):
        unit_parameters(MountDescription(drive2="belt"), SITE)


@pytest.mark.parametrize(
    ("described", "words"),
    [
        ({"update_range_deg": 0.0}, "update range 0 is not between"),
        ({"limits1_deg": (30.0, -30.0)}, "axis 1: 30 is not below -30"),
        ({"zone_west_h": 20.0}, "zone, hours west 20 is not"),
    ],
)
def test_numbers_that_no_mount_has(described, words):
    with pytest.raises(ConfigurationError, match=words):
        MountDescription(**described)
