"""Counts to angle: gears and linear actuators."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import (
    DEAD_POINT_MARGIN_DEG,
    Drive,
    Jack,
    JackHeliostat,
    RotaryDrive,
    ScrewjackDrive,
    format_drive,
    jack_length,
    parse_drive,
    reading_deg,
    register,
)

PAINT_JACK = Jack(
    increment=154_166.0, initial_stroke=0.078, offset=0.32, pivot_radius=0.34,
    initial_angle_deg=1.5, clockwise=True,
)  # fmt: skip
JACK = ScrewjackDrive(R1=40.0, R2=12.0, R3=2.5, beta_deg=70.0, counts_per_length=1200.0, sign=-1)


@pytest.mark.parametrize("counts_per_deg", [500.0, -123.456])
def test_a_rotary_drive_is_proportional_and_signed(counts_per_deg):
    drive = RotaryDrive(counts_per_deg)
    assert drive.counts(2.0) == 2.0 * counts_per_deg
    assert drive.angle_deg(drive.counts(33.3)) == pytest.approx(33.3, abs=1e-12)
    np.testing.assert_allclose(
        drive.angle_deg(np.array([0.0, 1000.0])), [0.0, 1000.0 / counts_per_deg]
    )


@given(
    R1=st.floats(10.0, 100.0),
    R2=st.floats(5.0, 100.0),
    R3=st.floats(0.0, 3.0),
    beta=st.floats(-90.0, 270.0),
    corner=st.floats(1.0, 179.0),
    counts_per_length=st.sampled_from([800.0, -800.0]),
    sign=st.sampled_from([-1, 1]),
)
@settings(derandomize=True, deadline=None)
def test_counts_of_a_screwjack_lead_back_to_the_angle(
    R1, R2, R3, beta, corner, counts_per_length, sign
):
    jack = ScrewjackDrive(R1, R2, R3, beta, counts_per_length, sign)
    angle = corner - beta
    assume(jack.SJP3 + jack.SJP2 * math.cos(math.radians(corner)) > 0.1)
    assert jack.angle_deg(jack.counts(angle)) == pytest.approx(angle, abs=1e-9)


def test_the_jack_is_the_third_side_of_the_triangle():
    """Law of cosines with the pins laid out in the plane: an oracle without the formula."""
    for sign in (-1, 1):
        jack = ScrewjackDrive(40.0, 12.0, 2.5, 20.0, 1.0, sign)
        for angle in (0.0, 35.0, 110.0):
            corner = math.radians(angle + 20.0)
            # With sign + the moving arm stands on the far side: the corner is its supplement.
            arm = 12.0 * np.array([math.cos(corner), math.sin(corner)]) * -sign
            pin_to_pin = math.dist((40.0, 0.0), tuple(arm))
            assert jack.length(angle) == pytest.approx(jack_length(pin_to_pin, 2.5), abs=1e-12)


@pytest.mark.parametrize(("sign", "grows"), [(-1, True), (1, False)])
def test_sign_says_whether_the_angle_grows_with_the_length(sign, grows):
    jack = ScrewjackDrive(40.0, 12.0, 2.5, 70.0, 1000.0, sign)
    lengths = jack.length(np.linspace(-60.0, 100.0, 50))
    assert np.all((np.diff(lengths) > 0.0) == grows)


def test_negative_gear_ratio_counts_down_as_the_jack_grows():
    drawn_back = ScrewjackDrive(40.0, 12.0, 2.5, 70.0, -1000.0, -1)
    assert drawn_back.counts(50.0) < drawn_back.counts(0.0) < 0.0


def test_the_three_parameters_of_the_field_sheet():
    assert JACK.SJP1 == 70.0
    assert JACK.SJP2 == -2.0 * 40.0 * 12.0
    assert JACK.SJP3 == 1600.0 + 144.0 - 6.25
    assert ScrewjackDrive(40.0, 12.0, 2.5, 70.0, 1.0, 1).SJP2 == 960.0
    assert JACK.length(20.0) == pytest.approx(math.sqrt(JACK.SJP3), abs=1e-12)


def test_pin_to_pin_length_leads_to_the_tube_length():
    assert jack_length(5.0, 3.0) == pytest.approx(4.0)
    with pytest.raises(ConfigurationError, match="L1 = 2 cannot be"):
        jack_length(2.0, 3.0)


@pytest.mark.parametrize("sign", [-1, 1])
def test_beta_from_one_measured_length_holds_at_a_second_angle(sign):
    true = ScrewjackDrive(40.0, 12.0, 2.5, 63.7, 1000.0, sign)
    unknown = msgspec.structs.replace(true, beta_deg=0.0)
    first = unknown.with_beta_from(-20.0, true.length(-20.0))
    second = unknown.with_beta_from(45.0, true.length(45.0))
    assert first.beta_deg == pytest.approx(63.7, abs=1e-9)
    assert second.beta_deg == pytest.approx(63.7, abs=1e-9)


def test_a_wrong_length_gives_itself_away_at_a_second_angle():
    true = JACK
    measured_wrong = msgspec.structs.replace(JACK, R2=12.2)
    betas = [measured_wrong.with_beta_from(s, true.length(s)).beta_deg for s in (-20.0, 45.0)]
    assert abs(betas[0] - betas[1]) > 0.2


def test_arrays_give_what_single_angles_give():
    angles = np.linspace(-60.0, 100.0, 9)
    counts = JACK.counts(angles)
    for angle, count in zip(angles, counts, strict=True):
        assert JACK.counts(float(angle)) == pytest.approx(count, rel=1e-14)
        assert type(JACK.angle_deg(float(count))) is float
    np.testing.assert_allclose(JACK.angle_deg(counts), angles, atol=1e-10)


@pytest.mark.parametrize("angle", [-70.0, 110.0, -100.0, 200.0, np.array([0.0, 110.0])])
def test_dead_points_and_beyond_are_refused(angle):
    with pytest.raises(ConfigurationError, match=r"dead point .* between -69.900 and 109.900 deg"):
        JACK.counts(angle)


def test_just_inside_a_dead_point_the_jack_still_works():
    for angle in (-70.0 + 2.0 * DEAD_POINT_MARGIN_DEG, 110.0 - 2.0 * DEAD_POINT_MARGIN_DEG):
        assert JACK.angle_deg(JACK.counts(angle)) == pytest.approx(angle, abs=1e-8)


@pytest.mark.parametrize("corner", [0.0, 180.0])
def test_the_length_of_a_flat_triangle_is_refused(corner):
    length = math.sqrt(JACK.SJP3 + JACK.SJP2 * math.cos(math.radians(corner))) + (
        1e-9 if corner == 0.0 else -1e-9
    )
    with pytest.raises(ConfigurationError, match="dead point"):
        JACK.angle_from_length_deg(length)


@pytest.mark.parametrize("length", [20.0, 60.0, -30.0, 0.0, np.array([40.0, 60.0])])
def test_a_length_at_which_the_triangle_cannot_close_is_refused(length):
    with pytest.raises(ConfigurationError) as refusal:
        JACK.angle_from_length_deg(length)
    text = str(refusal.value)
    assert "\n" not in text
    for part in ("R1 = 40", "R2 = 12", "R3 = 2.5", "cannot close", "27.8882", "51.9399"):
        assert part in text


def test_pivots_nearer_than_the_tube_offset_are_refused():
    equal_arms = ScrewjackDrive(10.0, 10.0, 8.0, 0.0, 100.0, -1)
    assert equal_arms.length(90.0) > 0.0
    with pytest.raises(ConfigurationError, match=r"cannot close at axis angle 20\.000 deg"):
        equal_arms.length(20.0)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ((10.0, 5.0, 15.0, 0.0, 100.0), "R1 = 10, R2 = 5 .* R3 = 15 cannot close"),
        ((-10.0, 5.0, 1.0, 0.0, 100.0), "R1 = -10, R2 = 5 must be positive"),
        ((10.0, math.nan, 1.0, 0.0, 100.0), "must be positive"),
        ((0.0, 5.0, 1.0, 0.0, 100.0), "R1 = 0, R2 = 5 must be positive"),
        ((-0.5, 5.0, 1.0, 0.0, 100.0), "R1 = -0.5, R2 = 5 must be positive"),
        ((10.0, -0.5, 1.0, 0.0, 100.0), "R1 = 10, R2 = -0.5 must be positive"),
        ((10.0, 5.0, 1.0, math.inf, 100.0), "beta = inf"),
        ((10.0, 5.0, 1.0, 0.0, 0.0), "gear ratio in counts per unit of length"),
        ((10.0, 5.0, 1.0, 0.0, 100.0, 2), "sign is -1"),
    ],
)
def test_a_screwjack_that_cannot_be_is_refused(values, says):
    with pytest.raises(ConfigurationError, match=says):
        ScrewjackDrive(*values)


@pytest.mark.parametrize("ratio", [0.0, math.nan, math.inf])
def test_a_rotary_drive_without_gear_ratio_is_refused(ratio):
    with pytest.raises(ConfigurationError, match="gear ratio in counts/deg"):
        RotaryDrive(ratio)


@pytest.mark.parametrize("drive", [RotaryDrive(-750.0), JACK])
def test_a_register_counts_whole_counts_from_the_reference(drive):
    reference = -30.0
    assert register(drive, reference, reference) == 0
    counts = register(drive, reference, 12.345)
    assert isinstance(counts, int)
    back = reading_deg(drive, reference, counts)
    assert back != 12.345
    one_count = abs(reading_deg(drive, reference, counts + 1) - back)
    assert abs(back - 12.345) <= 0.51 * one_count
    assert register(drive, reference, back) == counts


@pytest.mark.parametrize(
    ("text", "drive"),
    [
        ("rotary:500", RotaryDrive(500.0)),
        ("rotary:-1234.5", RotaryDrive(-1234.5)),
        ("screwjack:40:12:2.5:70:1200:-", JACK),
        (
            "screwjack:40:12:0:-12.25:-800:+",
            ScrewjackDrive(40.0, 12.0, 0.0, -12.25, -800.0, 1),
        ),
    ],
)
def test_drives_are_written_as_the_wire_protocol_says(text, drive):
    assert parse_drive(text) == drive
    assert format_drive(drive) == text


def test_written_numbers_come_back_to_the_last_bit():
    drive = ScrewjackDrive(40.1 / 3.0, 12.0 / 7.0, 0.1 + 0.2, 1e-7, -1e9 / 7.0, 1)
    assert parse_drive(format_drive(drive)) == drive


@pytest.mark.parametrize(
    "text",
    [
        "",
        "rotary",
        "rotary:abc",
        "rotary:1:2",
        "belt:5",
        "screwjack:40:12:2.5:70:1200",
        "screwjack:40:12:2.5:70:1200:x",
        "screwjack:40:twelve:2.5:70:1200:-",
    ],
)
def test_another_notation_is_refused_in_one_line(text):
    with pytest.raises(ConfigurationError, match="is not rotary:COUNTS_PER_DEG or screwjack"):
        parse_drive(text)


def test_numbers_no_drive_has_are_refused_by_the_parser_too():
    with pytest.raises(ConfigurationError, match="cannot close"):
        parse_drive("screwjack:10:5:20:0:100:-")


@pytest.mark.parametrize("drive", [RotaryDrive(500.0), JACK])
def test_a_session_header_tells_the_drives_apart(drive):
    assert msgspec.json.decode(msgspec.json.encode(drive), type=Drive) == drive


@given(st.floats(10.0, 170.0), st.floats(10.0, 170.0))
def test_the_centre_of_a_mirror_on_two_jacks_turns_with_both_joints(ax1_deg, ax2_deg):
    """By scipy's rotations: about up by joint 2, shifted, then about East by joint 1."""
    heliostat = JackHeliostat(
        (PAINT_JACK, PAINT_JACK), (10.0, 20.0, 1.5), (0.0, 0.1, 0.2), (0.3, -0.1, 0.4),
        (0.05, 0.25, -0.15),
    )  # fmt: skip
    about_up = Rotation.from_euler("z", 90.0 - ax2_deg, degrees=True)
    about_east = Rotation.from_euler("x", ax1_deg - 90.0, degrees=True)
    on_second = about_up.apply(heliostat.concentrator) + heliostat.second_joint
    expected = about_east.apply(on_second) + heliostat.first_joint + heliostat.position_enu
    centre = heliostat.centre_enu(np.array([ax1_deg]), np.array([ax2_deg]))
    assert centre[0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("clockwise", [True, False])
def test_a_jack_stands_at_its_first_angle_and_turns_as_its_triangle_says(clockwise):
    jack = replace(PAINT_JACK, clockwise=clockwise)
    steps = np.array([0.0, 5_000.0, 20_000.0])
    # The law of cosines for the sides 0.32, 0.34 and the jack.
    lengths = 0.078 + steps / 154_166.0
    corners = np.degrees(np.arccos((0.32**2 + 0.34**2 - lengths**2) / (2 * 0.32 * 0.34)))
    turned = corners[0] - corners
    expected = 1.5 + (turned if clockwise else -turned)
    np.testing.assert_allclose(jack.joint_deg(steps), expected, atol=1e-9)
    np.testing.assert_allclose(jack.steps_at(expected), steps, atol=1e-4)
