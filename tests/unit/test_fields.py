"""What one end writes, the other reads; what is not exactly right is refused by its name."""

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solarcal.errors import ProtocolError
from solarcal.mount.drive import parse_drive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.optics.offset_mirror import MirrorOffset
from solarcal.optics.reflection import Target
from solarcal.site import Site
from solarcal.unit import fields, values
from solarcal.unit.fields import PARAMETER_NAMES, parameters_from_texts, parameters_to_texts
from solarcal.unit.tracker import (
    Mode,
    RefCheckResult,
    Spot,
    Status,
    Truth,
    UnitIdentity,
    UnitParameters,
    UnitSite,
)

every = settings(derandomize=True, deadline=None, max_examples=100)

STATUS = Status(
    mode=Mode.TRACK,
    unit_utc_s=1782057600.125,
    ideal1_deg=-12.34567,
    ideal2_deg=45.67891,
    reading1_deg=-12.1,
    reading2_deg=45.2,
    counts1=-12345,
    counts2=2345,
    target1_deg=-12.05,
    target2_deg=45.25,
    offsets=Offsets(0.1234, -0.2),
    moving=(0, 1),
    approach=(1, -1),
    update_phase=0.42,
    referenced=True,
    unlocked_s=55.0,
    memories_differ=True,
)
STATUS_TEXT = (
    "TRACK 20260621T090000.125 -12.34567 45.67891 -12.10000 45.20000 -12345 2345 "
    "-12.05000 45.25000 0.1234 -0.2000 .+ +- 42 03 55"
)


def test_status_is_written_as_the_protocol_page_says():
    assert fields.status(7.0).write(STATUS) == STATUS_TEXT.split()
    assert fields.status(7.0).read(STATUS_TEXT.split()) == STATUS
    for unlocked_s, text in ((0.0, "0"), (-2.0, "0"), (0.9, "0"), (1.5, "1")):
        now = msgspec.structs.replace(STATUS, unlocked_s=unlocked_s)
        assert fields.status(7.0).write(now)[-1] == text


@pytest.mark.parametrize(
    ("place", "text", "name"),
    [
        (0, "track", "mode"),
        (1, "20260631T090000.125", "local_time"),
        (1, "20260621T090000", "local_time"),
        (2, "nan", "ideal1"),
        (3, "1e3", "ideal2"),
        (4, "+1.0", "reading1"),
        (5, "1.", "reading2"),
        (6, "12.0", "counts1"),
        (7, "0x10", "counts2"),
        (8, "inf", "target1"),
        (9, "1_0", "target2"),
        (10, "--1", "O1"),
        (11, "٣", "O2"),
        (12, "+", "motion"),
        (13, "+0", "approach"),
        (14, "100", "phase"),
        (15, "3", "flags"),
        (15, "0g", "flags"),
        (16, "5.5", "unlocked"),
    ],
)
def test_a_bad_status_field_is_refused_by_its_name(place, text, name):
    texts = STATUS_TEXT.split()
    texts[place] = text
    with pytest.raises(ProtocolError, match=name):
        fields.status(7.0).read(texts)


@pytest.mark.parametrize(
    ("name", "low", "high", "decimals"),
    [
        ("zone", -15, 15, 2),
        ("latitude", -90, 90, 5),
        ("longitude", -180, 360, 5),
        ("elevation_m", -500, 9000, 1),
        ("ax1_centre", -360, 360, 5),
        # On a branch around any centre.
        ("ideal1", -540, 540, 5),
        ("ideal2", 0, 180, 5),
        ("speed", 0, 1_000_000, 3),
        ("seconds", 0, 86400, 6),
        ("pressure", 0, 1200, 1),
        ("temperature", -100, 100, 1),
    ],
)
def test_a_number_is_refused_beyond_what_there_is_of_it(name, low, high, decimals):
    kind = values.KINDS[name]
    for end, beyond in ((low, low - 0.5), (high, high + 0.5)):
        assert kind.read(str(end), name) == end
        with pytest.raises(ProtocolError, match=f"field {name}: {beyond} is not between"):
            kind.read(str(beyond), name)
    assert kind.write(1.0 / 3.0, (4, 6)) == f"{1 / 3:.{decimals}f}"


def test_a_wrong_number_of_fields_is_refused():
    for texts in (STATUS_TEXT.split()[:-1], [*STATUS_TEXT.split(), "1"], []):
        with pytest.raises(ProtocolError, match="17 belong"):
            fields.status(7.0).read(texts)


@every
@given(
    st.integers(0, 4_000_000_000_000),
    st.integers(-60, 60).map(lambda quarters: quarters / 4),
)
def test_local_time_round_trips_to_the_millisecond(utc_ms, zone_west_h):
    utc_s = utc_ms / 1000.0
    text = values.local_time_text(utc_s, zone_west_h)
    assert values.utc_from_local_time(text, zone_west_h) == utc_s


def test_a_zone_west_is_added_to_local_time():
    assert values.utc_from_local_time("19700101T000000.000", 7.0) == 7 * 3600.0
    assert values.local_time_text(0.0, -2.0) == "19700101T020000.000"


def test_zero_has_no_sign():
    assert values.number_text(-0.000001) == "0.00000"
    assert values.number_text(-0.00001) == "-0.00001"
    assert values.number_text(-0.4, 0) == "0"
    assert values.number_text(-10.0, 0) == "-10"


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_what_is_no_number_is_never_written(value):
    with pytest.raises(ProtocolError):
        values.number_text(value)


@every
@given(st.floats(-400, 400))
def test_angles_round_trip_to_five_decimals(angle_deg):
    assert values.number(values.number_text(angle_deg), "x") == round(angle_deg, 5)


def test_identity_round_trips():
    emulator = UnitIdentity("SOLARTRAK-EMU", "0007", "1.0", 1, frozenset("X"))
    assert fields.IDENTITY.write(emulator) == ["SOLARTRAK-EMU", "0007", "1.0", "1", "X"]
    assert fields.IDENTITY.read(fields.IDENTITY.write(emulator)) == emulator
    plain = UnitIdentity("SolarTrak", "12", "3")
    assert fields.IDENTITY.write(plain)[-1] == "-"
    assert fields.IDENTITY.read(fields.IDENTITY.write(plain)) == plain
    with pytest.raises(ProtocolError, match="extensions"):
        fields.IDENTITY.read(["a", "b", "c", "1", "X-"])
    with pytest.raises(ProtocolError, match="protocol"):
        fields.IDENTITY.read(["a", "b", "c", "one", "X"])


def test_clock_round_trips():
    assert fields.CLOCK.read(fields.CLOCK.write((1782057600.5, 7.0))) == (
        1782057600.5,
        7.0,
    )
    with pytest.raises(ProtocolError, match="zone"):
        fields.CLOCK.read(["20260621T090000.000", "25.00"])


def test_site_round_trips():
    place = UnitSite(Site(-33.9, 18.4, 12.5), -2.0, "azel", 180.0)
    texts = fields.SITE.write(place)
    assert texts == ["-33.90000", "18.40000", "12.5", "-2.00", "azel", "180.00000"]
    assert fields.SITE.read(texts) == place
    assert fields.SITE_SET.read(texts[:4]) == (place.site, -2.0)
    with pytest.raises(ProtocolError, match="latitude"):
        fields.SITE.read(["95.0", *texts[1:]])


@pytest.mark.parametrize(
    ("result", "text"),
    [
        (RefCheckResult(0, False, 0, 0), "0 NONE 0 0"),
        (RefCheckResult(3, False, 0, 0, running=True), "3 RUNNING 0 0"),
        (RefCheckResult(3, True, 2, -40), "3 DONE 2 -40"),
        (RefCheckResult(3, False, 0, 0), "3 BROKEN 0 0"),
    ],
)
def test_a_reference_check_tells_its_state(result, text):
    assert fields.REF_CHECK.write(result) == text.split()
    assert fields.REF_CHECK.read(text.split()) == result


def test_coefficients_are_written_with_the_decimals_the_unit_keeps():
    p = Coefficients(0.05124, -0.12, 0.3, -0.00001, 0.0003, -0.0000001)
    o = Offsets(-0.00004, 1.5)
    texts = fields.COEFFICIENTS.write((p, o))
    assert " ".join(texts) == "0.0512 -0.1200 0.3000 0.0000 0.000300 0.000000 0.0000 1.5000"
    assert fields.COEFFICIENTS.read(texts) == (p.rounded(4, 6), Offsets(0.0, 1.5))
    assert fields.COEFFICIENTS.write((p, o), (2, 4))[0] == "0.05"
    with pytest.raises(ProtocolError, match="P5"):
        fields.COEFFICIENTS.read([*texts[:4], "NaN", *texts[5:]])


PARAMETERS = UnitParameters(
    drive1=parse_drive("rotary:-250.5"),
    drive2=parse_drive("screwjack:30.0:12.0:1.5:20.0:4000.0:+"),
    limits=Limits(AxisLimits(-120.0, 120.0), AxisLimits(5.0, 95.0)),
    update_range_deg=0.1,
    reference1_deg=-90.0,
    reference2_deg=90.0,
    tilt_decimals=4,
    scale_decimals=6,
)


def test_parameters_round_trip():
    texts = parameters_to_texts(PARAMETERS)
    assert tuple(texts) == PARAMETER_NAMES
    assert texts["axis1.limits"] == "-120.00000:120.00000"
    assert parameters_from_texts(texts) == PARAMETERS
    assert (texts["target"], PARAMETERS.heliostat) == ("-", None)


def test_a_heliostats_target_and_reduced_offsets_round_trip():
    told = msgspec.structs.replace(
        PARAMETERS, target=Target(176.0, 78.0, 120.0), mirror=MirrorOffset(0.001, 0.0, -0.0025)
    )
    texts = parameters_to_texts(told)
    assert texts["target"] == "176.00000:78.00000:120.00000"
    assert texts["mirror"] == "0.001000000:0.000000000:-0.002500000"
    assert parameters_from_texts(texts) == told
    assert told.heliostat is not None
    assert told.heliostat.offset.PivotRefl_Z == pytest.approx(-0.3)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("axis1.drive", "belt:12"),
        ("axis2.drive", "rotary:0"),
        ("axis2.drive", "rotary:nan"),
        ("axis1.limits", "10.0"),
        ("axis1.limits", "10.0:-10.0"),
        ("axis2.limits", "a:b"),
        ("axis1.reference", ""),
        ("update_range", "0,1"),
        ("axis1.limits", "-99999:99999"),
        ("axis2.limits", "0:99999"),
        ("axis2.reference", "1000"),
        ("update_range", "0"),
        ("update_range", "-1"),
        ("update_range", "99999"),
        ("tilt_decimals", "-4"),
        ("tilt_decimals", "999999999"),
        ("tilt_decimals", "1"),
        ("scale_decimals", "0"),
        ("scale_decimals", "99"),
        ("target", "176:78"),
        ("target", "176:78:0"),
        ("mirror", "a:0:0"),
    ],
)
def test_a_bad_parameter_is_refused_by_its_name(name, text):
    with pytest.raises(ProtocolError, match=name):
        parameters_from_texts({**parameters_to_texts(PARAMETERS), name: text})


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("axis1.reference", "-540", "540"),
        ("axis2.reference", "-180", "360"),
        ("update_range", "0.001", "5"),
        ("tilt_decimals", "2", "9"),
        ("scale_decimals", "4", "9"),
    ],
)
def test_a_parameter_may_be_all_that_the_page_says_and_no_more(name, low, high):
    def read(text):
        return parameters_to_texts(
            parameters_from_texts({**parameters_to_texts(PARAMETERS), name: text})
        )[name]

    for bound, beyond in ((low, -1), (high, 1)):
        assert float(read(bound)) == float(bound)
        outside = float(bound) + beyond * (1 if "decimals" in name else 0.0005)
        with pytest.raises(ProtocolError, match=name):
            read(f"{outside:.0f}" if "decimals" in name else f"{outside:.4f}")


@pytest.mark.parametrize(
    ("name", "outermost"), [("axis1.limits", (-540, 540)), ("axis2.limits", (-180, 360))]
)
def test_limits_may_be_all_that_the_page_says_and_no_more(name, outermost):
    texts = parameters_to_texts(PARAMETERS)
    low, high = outermost
    parameters_from_texts({**texts, name: f"{low}.0:{high}.0"})
    for wider in (f"{low}.1:{high}.0", f"{low}.0:{high}.1"):
        with pytest.raises(ProtocolError, match=name):
            parameters_from_texts({**texts, name: wider})


@pytest.mark.parametrize(
    ("name", "place", "text"),
    [
        ("zone", 3, "99.00"),
        ("geometry", 4, "sideways"),
        ("ax1_centre", 5, "1000.0"),
        ("latitude", 0, "91.0"),
    ],
)
def test_a_site_that_no_unit_has_is_refused_by_its_name(name, place, text):
    site = ["35.05000", "-106.48000", "1830.0", "7.00", "azel", "0.00000"]
    site[place] = text
    with pytest.raises(ProtocolError, match=name):
        fields.SITE.read(site)


def test_an_emulated_world_follows_a_sun_that_is_known():
    assert fields.SKY.read(["precise", "820.0", "20.0"]).sun == "precise"
    with pytest.raises(ProtocolError, match="field sun: 'ptolemaic' is not one of precise"):
        fields.SKY.read(["ptolemaic", "820.0", "20.0"])


def test_what_the_emulator_tells_round_trips():
    times = (1782057600.125, 1782057576.0)
    texts = fields.TIMES.write(times)
    assert texts[0] == "2026-06-21T16:00:00.125Z"
    assert fields.TIMES.read(texts) == times
    with_speed = fields.TIMES_AND_SPEED.write((times, 60.0))
    assert fields.TIMES_AND_SPEED.read(with_speed) == (times, 60.0)
    spot = Spot(True, 0.01234, -0.5)
    assert fields.SPOT.read(fields.SPOT.write(spot)) == spot
    truth = Truth(Coefficients(0.1, 0.2, 0.3, 0.4, 0.0005, 0.0006), 0.1, 0.2, 0.3)
    assert fields.TRUTH.read(fields.TRUTH.write(truth)) == truth
    for no_time in ("2026-06-21 16:00", "2026-13-21T16:00:00.000Z"):
        with pytest.raises(ProtocolError, match="true_utc"):
            fields.TIMES.read([no_time, texts[1]])
    with pytest.raises(ProtocolError, match="visible"):
        fields.SPOT.read(["yes", "0.0", "0.0"])
