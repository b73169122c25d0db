"""What is doubted of a form's answers, and why; each doubt names the field to look at first."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from solarcal.decimals import Pair
from solarcal.errors import ConfigurationError
from solarcal.model.evidence.unit_state import AGREEMENT_DEG, check_unit_sun, sun_difference_deg
from solarcal.mount.formula import Offsets
from solarcal.station.described_unit import TypedControllerModel
from solarcal.station.typed.forms import Doubt, decimals, number, plain_text, time_of_day_s
from solarcal.station.typed.typo_hints import Fit, difference_named, reading_doubts
from solarcal.timescale import SECONDS_PER_SUN_DEG, clock_face
from solarcal.units import wrap_deg

READ_LAG_S = 15.0
"""Between a look at the display and the first key: half of it either way."""

CLOCK_READ_S = 1.5
"""A displayed time is good to this, with the reading beside it."""

ROUNDING_DEG = 0.005
CLOCKS_APART_S = 120.0
"""No unit's clock is off by this unless something is wrong: the hour, the zone, a digit."""

WRONG_MOMENT_S = 120.0
BEYOND_LIMIT_DEG = 1.0

Texts = Mapping[str, str]


def clock_doubts(held: TypedControllerModel, texts: Texts, read_utc_s: float) -> tuple[Doubt, ...]:
    """A clock that is minutes or hours off the laptop's."""
    field = "clock"
    shown_s = _time_s(texts[field])
    if shown_s is None:
        return ()
    off_s = replace(held, unit_minus_laptop_s=0.0).clock_off_s(shown_s, read_utc_s)
    if abs(off_s) < CLOCKS_APART_S:
        return ()
    hours = round(off_s / 3600.0)
    if hours and abs(off_s - 3600.0 * hours) < CLOCKS_APART_S:
        what = (
            f"by {hours:+d} h: daylight-saving time, or the zone "
            f"({held.unit_site.zone_west_h:g} h west in the description)"
        )
    else:
        what = f"by {off_s:+z.0f} s, {abs(off_s) / SECONDS_PER_SUN_DEG:.1f} deg of Sun: look again"
    return (Doubt(f"The unit's clock differs from the laptop's {what}.", field),)


def reading_sheet_doubts(
    held: TypedControllerModel, texts: Texts, read_utc_s: float, *, offset_just_set: bool
) -> tuple[Doubt, ...]:
    """Read-outs, offsets, Sun angles and time of one look at the display.

    ``offset_just_set``: the offsets are new; else they must be those typed before.
    """
    doubts = [*_moment_doubts(held, texts, read_utc_s)]
    fit = reading_fit(held, texts, read_utc_s)
    if not offset_just_set:
        doubts += _changed_offsets(held, texts, fit)
    if not doubts:
        before = _offset_texts(held.offsets) if offset_just_set else None
        doubts += reading_doubts(fit, texts, before)
    doubts += _sun_doubts(held, texts, read_utc_s)
    return tuple(doubts or _limit_doubts(held, texts))


def reading_fit(held: TypedControllerModel, texts: Texts, read_utc_s: float) -> Fit:
    """How far typed read-outs may honestly be from ideal + E + O: the update step, the moment,
    and the decimals of the display."""
    moment_s = _moment_s(held, texts, read_utc_s)
    slack_s = CLOCK_READ_S if texts.get("time") else READ_LAG_S
    rates = held.rates_deg_per_s(moment_s)
    tolerance = [
        held.parameters.update_range_deg
        + abs(rates[axis]) * slack_s
        + ROUNDING_DEG
        + 0.5 * _unit_deg(held, texts, axis)
        + 0.5 * 10.0 ** -decimals(texts[f"o{axis + 1}"])
        for axis in (0, 1)
    ]

    def off_deg(tried: Texts, shift_s: float) -> Pair:
        o1, o2 = number(tried["o1"]), number(tried["o2"])
        if o1 is None or o2 is None:
            return float("nan"), float("nan")
        target = held.target_deg(moment_s + shift_s, Offsets(o1, o2))
        reading = [_reading_deg(held, axis, tried) for axis in (0, 1)]
        return float(wrap_deg(reading[0] - target[0])), reading[1] - target[1]

    return Fit(off_deg, (tolerance[0], tolerance[1]))


def _reading_deg(held: TypedControllerModel, axis: int, texts: Texts) -> float:
    """The read-out of an axis; not a number where the text is none, or counts that no position of
    its screwjack has."""
    text = texts[f"ax{axis + 1}"]
    shown = None if held.shows_counts and "." in text else number(text)
    try:
        return float("nan") if shown is None else held.reading_deg(axis, shown)
    except ConfigurationError:
        return float("nan")


def key_in_doubts(wanted: tuple[tuple[str, str], ...], texts: Texts) -> tuple[Doubt, ...]:
    """Whatever was typed back differs from what was to be keyed in, exactly."""
    doubts = [
        Doubt(
            f"{difference_named(name, texts[name.lower()], value)}. If the unit shows this, key "
            "it in again.",
            name.lower(),
        )
        for name, value in wanted
        if number(texts[name.lower()]) != number(value)
    ]
    if texts.get("stored", "yes").lower() in ("n", "no"):
        doubts.append(Doubt("Not stored: it is lost when the unit is switched off.", "stored"))
    return tuple(doubts)


# -- single looks --------------------------------------------------------------------------


def _moment_doubts(held: TypedControllerModel, texts: Texts, read_utc_s: float) -> list[Doubt]:
    shown_s = _time_s(texts.get("time", ""))
    if shown_s is None:
        return []
    off_s = held.clock_off_s(shown_s, read_utc_s)
    if abs(off_s) <= WRONG_MOMENT_S:
        return []
    should = clock_face(held.unit_day_s(read_utc_s))
    return [
        Doubt(
            f"The unit's clock was typed {texts['time']}, but as you typed it must have shown "
            f"about {should}: {off_s:+z.0f} s.",
            "time",
        )
    ]


def _changed_offsets(held: TypedControllerModel, texts: Texts, fit: Fit) -> list[Doubt]:
    """Offsets that were typed otherwise a moment ago; the read-outs may tell which are right."""
    before = _offset_texts(held.offsets)
    different = [name for name in ("o1", "o2") if number(texts[name]) != number(before[name])]
    if not different:
        return []
    if number(texts["o1"]) == number(before["o2"]) and number(texts["o2"]) == number(before["o1"]):
        return [Doubt("O1 and O2 exchanged?", "o1")]
    now_fits, before_fits = all(fit.holds(texts)), all(fit.holds({**texts, **before}))
    told = ""
    if now_fits != before_fits:
        told = f" The read-outs fit what was typed {'now' if now_fits else 'before'}."
    return [
        Doubt(
            f"{difference_named(name.upper(), texts[name], before[name])} as typed before.{told}",
            name,
        )
        for name in different
    ]


def _limit_doubts(held: TypedControllerModel, texts: Texts) -> list[Doubt]:
    doubts = []
    limits = (held.parameters.limits.axis1, held.parameters.limits.axis2)
    for axis in (0, 1):
        left = float(limits[axis].distance_deg(_reading_deg(held, axis, texts)))
        if left < -BEYOND_LIMIT_DEG:
            field = f"ax{axis + 1}"
            doubts.append(
                Doubt(f"{field.upper()} is {-left:.1f} deg beyond a software limit.", field)
            )
    return doubts


def _sun_doubts(held: TypedControllerModel, texts: Texts, read_utc_s: float) -> list[Doubt]:
    """The Sun angles of the display against ours, for the clock and site it has."""
    shown = [number(texts.get(f"sun{axis}", "")) for axis in (1, 2)]
    if shown == [None, None]:
        return []
    if shown[0] is None or shown[1] is None:
        return [Doubt("Type both Sun angles, or none.", "sun1" if shown[0] is None else "sun2")]
    moment_s = _moment_s(held, texts, read_utc_s)
    slack_s = CLOCK_READ_S if texts.get("time") else READ_LAG_S
    half_digit = 0.5 * 10.0 ** -min(decimals(texts["sun1"]), decimals(texts["sun2"]))
    allowed_deg = AGREEMENT_DEG + np.hypot(half_digit, half_digit)
    # The Sun they show moved on between the look and the key: any moment within it will do, at
    # steps so close that none moves it by a milli-degree.
    moments_s = moment_s + np.arange(-slack_s, slack_s + 0.25, 0.25)
    off_deg = sun_difference_deg(held.unit_site, (shown[0], shown[1]), held.unit_utc_s(moments_s))
    if off_deg.min() <= allowed_deg:
        return []
    check = check_unit_sun(
        held.unit_site,
        held.unit_site.site,
        held.unit_utc_s(moment_s),
        (shown[0], shown[1]),
        moment_s,
    )
    return [
        Doubt(
            f"The Sun angles are {check.difference_deg:.3f} deg from ours: {check.explanation}.",
            "sun1",
        )
    ]


# -- texts -----------------------------------------------------------------------------------


def _unit_deg(held: TypedControllerModel, texts: Texts, axis: int) -> float:
    """What the last digit of a read-out is worth, degrees."""
    text = texts[f"ax{axis + 1}"]
    if not held.shows_counts:
        return 10.0 ** -decimals(text)
    shown = number(text)
    if shown is None:
        return 0.0
    try:
        return abs(held.reading_deg(axis, shown + 1.0) - held.reading_deg(axis, shown))
    except ConfigurationError:
        return 0.0


def _moment_s(held: TypedControllerModel, texts: Texts, read_utc_s: float) -> float:
    return held.moment_s({"time": _time_s(texts.get("time", ""))}, read_utc_s)


def _time_s(text: str) -> float | None:
    return time_of_day_s(plain_text(text))


def _offset_texts(offsets: Offsets) -> dict[str, str]:
    return {"o1": _text(offsets.O1), "o2": _text(offsets.O2)}


def _text(value: float) -> str:
    return f"{value:.6f}".rstrip("0").rstrip(".")
