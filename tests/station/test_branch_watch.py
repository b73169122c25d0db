"""A tropical az-el site is told that one range of axis 1 cannot hold its day."""

import msgspec
import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.model.evidence.branch import branch_warning
from solarcal.model.evidence.direct import evidence_sentences
from solarcal.session.journal import Journal
from solarcal.session.records import Header
from solarcal.station.clocks import EmulatedClock
from solarcal.station.headless import calibrate
from solarcal.station.procedure import Station
from solarcal.station.technician import Schedule
from solarcal.timescale import parse_utc
from solarcal.unit.drivers.solartrak import SolarTrakUnit

JUNE = parse_utc("2026-06-10T15:00:00Z")
DECEMBER = parse_utc("2026-12-10T15:00:00Z")


def unit_of(scenario: str) -> SolarTrakUnit:
    emulator = Emulator(load_scenario(scenario), seed=1)
    return SolarTrakUnit(lambda: InProcessLink(emulator))


def header_of(scenario: str) -> Header:
    unit = unit_of(scenario)
    unit.open()
    assert unit.emulation is not None
    station = Station(unit, EmulatedClock(unit.emulation))
    station.connect()
    station.open_session(Journal.memory)
    header = station.session.header
    unit.close()
    return header


@pytest.fixture(scope="module")
def tropical() -> Header:
    return header_of("tropical")


def test_the_sun_culminating_in_the_north_crosses_the_branch(tropical: Header) -> None:
    said = branch_warning(tropical, JUNE)
    assert said is not None
    assert "AX1 180 and -180 deg are one direction" in said
    # Local noon at 52.7 W, zenith distance 23.0 - 5.2 deg.
    assert "2026-06-10T15:" in said
    assert "72 deg high" in said
    assert "this site needs two" in said
    assert "\n" not in said


def test_in_december_the_same_site_is_whole(tropical: Header) -> None:
    assert branch_warning(tropical, DECEMBER) is None


def test_every_hour_of_the_solar_day_gives_the_same_answer(tropical: Header) -> None:
    # Mean solar midnight lies at 03:31 UTC.
    morning = parse_utc("2026-06-10T03:31:00Z")
    assert len({branch_warning(tropical, morning + 3600.0 * hour) for hour in range(24)}) == 1


def test_centred_on_north_the_branch_breaks_in_december_instead(tropical: Header) -> None:
    limits = msgspec.structs.replace(
        tropical.unit.limits,
        axis1=msgspec.structs.replace(tropical.unit.limits.axis1, low_deg=2.0, high_deg=358.0),
    )
    unit = msgspec.structs.replace(tropical.unit, limits=limits)
    north = msgspec.structs.replace(tropical, ax1_centre_deg=180.0, unit=unit)
    assert branch_warning(north, JUNE) is None
    said = branch_warning(north, DECEMBER)
    assert said is not None
    assert "AX1 360 and 0 deg" in said


def test_limits_that_shut_out_one_side_leave_nothing_to_cross(tropical: Header) -> None:
    axis1 = msgspec.structs.replace(tropical.unit.limits.axis1, low_deg=0.0)
    limits = msgspec.structs.replace(tropical.unit.limits, axis1=axis1)
    unit = msgspec.structs.replace(tropical.unit, limits=limits)
    assert branch_warning(msgspec.structs.replace(tropical, unit=unit), JUNE) is None


@pytest.mark.parametrize(
    "scenario", ["tijeras-azel", "southern", "polar", "ew-tiltroll", "ns-tiltroll"]
)
def test_other_sites_and_mounts_are_left_in_peace(scenario: str) -> None:
    header = header_of(scenario)
    assert branch_warning(header, JUNE) is None
    assert branch_warning(header, DECEMBER) is None


def test_an_import_without_a_place_says_nothing(tropical: Header) -> None:
    assert branch_warning(msgspec.structs.replace(tropical, unknown=("longitude",)), JUNE) is None


def test_headless_says_it_when_the_session_opens_and_the_evidence_repeats_it() -> None:
    said: list[str] = []
    run = calibrate(
        unit_of("tropical"), Journal.memory, Schedule(points=4, every_min=20.0), say=said.append
    )
    expected = branch_warning(run.session.header, parse_utc(run.session.header.utc))
    assert expected is not None
    assert said.count(expected) == 1
    assert evidence_sentences(run.session).count(expected) == 1
