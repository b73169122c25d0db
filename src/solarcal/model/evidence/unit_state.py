"""Does the unit compute the same Sun as this program?

The unit's own algorithm is known, so its ``ideal`` angles can be computed here from the clock, site
and zone it reports. Agreement proves that hour, zone, hemisphere and site are what they say;
disagreement is a wrong setting, and the one that explains it is searched for and named.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from solarcal.decimals import Pair, counted
from solarcal.model.evidence.clocks import CLOCK_TOLERANCE_S
from solarcal.model.finding import Finding
from solarcal.mount.controller import ideal_and_elevation_deg
from solarcal.mount.geometry import MountGeometry, Value
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView, held_instead
from solarcal.site import Site, longitude_apart_deg
from solarcal.timescale import SECONDS_PER_DAY, SECONDS_PER_SUN_DEG, parse_many_utc
from solarcal.unit.tracker import UnitSite
from solarcal.units import Angles

AGREEMENT_DEG = 0.002
"""The wire carries milliseconds and 1e-5 deg; anything above this is another Sun."""

SITE_AGREEMENT_DEG = 0.005
"""A site wrong by this much moves the Sun by as much."""

SUN_AGREEMENT_DEG = 0.01
"""The clocks were compared minutes after the angles were read: 2 s of drift lie between at most."""

MATCH_DEG = 0.02
"""A hypothesis that brings the difference below this explains it."""

SUN_DEG_PER_H = 3600.0 / SECONDS_PER_SUN_DEG
ZONE_APART_H = 3.0
"""No land keeps a time further from that of its Sun, but for summer time at its western edge."""


@dataclass(frozen=True, slots=True)
class UnitSunCheck:
    """Largest difference of the unit's ideal angles from ours on sky, and what explains it."""

    difference_deg: float
    explanation: str

    @property
    def agrees(self) -> bool:
        return self.difference_deg <= AGREEMENT_DEG


def sun_difference_deg(
    unit_site: UnitSite, ideal_deg: tuple[Value, Value], utc_s: Angles, site: Site | None = None
) -> Angles:
    """Ideal angles from those of the unit's own Sun at its site (or another), degrees on sky.

    ``ideal_deg`` and ``utc_s`` are floats or arrays (n,) that broadcast together, as is the answer.
    """
    site = site or unit_site.site
    geometry = MountGeometry(unit_site.geometry, site.latitude_deg, unit_site.ax1_centre_deg)
    ax1, ax2, _ = ideal_and_elevation_deg(geometry, site, utc_s, unit_site.heliostat)
    off_deg: Angles = geometry.sky_separation_deg(*ideal_deg, ax1, ax2)
    return off_deg


def _hypotheses(
    told: Site, ours: Site, utc_s: float, laptop_utc_s: float
) -> Iterator[tuple[str, Site, float]]:
    def moved(latitude_deg: float, longitude_deg: float) -> Site:
        return Site(latitude_deg, longitude_deg, told.elevation_m)

    for hours in (1, -1, *(sign * h for h in range(2, 13) for sign in (1, -1))):
        yield (
            f"its clock or zone is wrong by {hours:+d} h (daylight-saving time, or the zone)",
            told,
            utc_s + 3600.0 * hours,
        )
    yield (
        "it uses the other hemisphere (sign of the latitude)",
        moved(-told.latitude_deg, told.longitude_deg),
        utc_s,
    )
    yield (
        "it takes the longitude with the wrong sign (east for west)",
        moved(told.latitude_deg, longitude_apart_deg(0.0, told.longitude_deg)),
        utc_s,
    )
    yield "it uses our site, not the one it reports", ours, utc_s
    yield "it uses another date or time than it reports (the laptop's fits)", told, laptop_utc_s
    for days in (1, -1):
        yield f"its date is wrong by {days:+d} day", told, utc_s + SECONDS_PER_DAY * days


def check_unit_sun(
    unit_site: UnitSite,
    ours: Site,
    unit_utc_s: float,
    ideal_deg: tuple[float, float],
    laptop_utc_s: float,
) -> UnitSunCheck:
    """Compare the ideal angles a unit showed at its own ``unit_utc_s`` with ours for that instant
    and for the site and zone it reports."""
    difference = sun_difference_deg(unit_site, ideal_deg, unit_utc_s)
    if difference <= AGREEMENT_DEG:
        return UnitSunCheck(difference, "the unit's Sun is ours")
    for words, site, utc_s in _hypotheses(unit_site.site, ours, unit_utc_s, laptop_utc_s):
        if sun_difference_deg(unit_site, ideal_deg, utc_s, site) <= MATCH_DEG:
            return UnitSunCheck(difference, f"the unit computes as if {words}")
    return UnitSunCheck(
        difference,
        "no single wrong hour, zone, hemisphere or site explains it; compare the unit's site, "
        "date and time with the truth one by one",
    )


def check_unit_settings(
    unit_site: UnitSite, ours: Site, unit_minus_laptop_s: float
) -> tuple[str, ...]:
    """Sentences about a unit whose site or clock is not ours; empty when they agree.

    A site wrong by 0.01 deg moves the Sun by as much; a clock by 24 s moves it 0.1 deg.
    """
    told = unit_site.site
    said: list[str] = []
    if abs(told.latitude_deg - ours.latitude_deg) > 0.005:
        word = (
            "the other hemisphere"
            if abs(told.latitude_deg + ours.latitude_deg) < 0.01
            else f"{abs(told.latitude_deg - ours.latitude_deg):.3f} deg away"
        )
        said.append(
            f"the unit's latitude is {told.latitude_deg:.4f}, ours {ours.latitude_deg:.4f}: {word}"
        )
    if abs(longitude_apart_deg(told.longitude_deg, ours.longitude_deg)) > 0.005:
        said.append(
            f"the unit's longitude is {told.longitude_deg:.4f}, ours {ours.longitude_deg:.4f} "
            "(positive east)"
        )
    zone_h = unit_site.zone_west_h
    # A clock that runs in UTC, zone 0, may stand anywhere.
    apart_h = longitude_apart_deg(told.longitude_deg, -SUN_DEG_PER_H * zone_h) / SUN_DEG_PER_H
    if zone_h and abs(apart_h) > ZONE_APART_H:
        said.append(
            f"the unit's zone ({zone_h:g} h west) and its longitude ({told.longitude_deg:.4f}, "
            f"positive east) contradict each other by {abs(apart_h):.1f} h: one of them is wrong, "
            "perhaps in its sign"
        )
    hours = round(unit_minus_laptop_s / 3600.0)
    if hours and abs(unit_minus_laptop_s - 3600.0 * hours) < 120.0:
        said.append(
            f"the unit's UTC differs from the laptop's by {hours:+d} h: its hour or its zone "
            f"({unit_site.zone_west_h:g} h west) is wrong, or the laptop's is"
        )
    elif abs(unit_minus_laptop_s) > CLOCK_TOLERANCE_S:
        said.append(
            f"the unit's clock differs from the laptop's by {unit_minus_laptop_s:+z.1f} s, "
            f"{abs(unit_minus_laptop_s) / SECONDS_PER_SUN_DEG:.3f} deg of Sun"
        )
    return tuple(said)


def unlike(now: msgspec.Struct, then: msgspec.Struct) -> str:
    """The numbers of two sets of P or O that are not the same; empty where all are."""
    wanted = msgspec.structs.asdict(then)
    return ", ".join(
        f"{name} {value:g} instead of {wanted[name]:g}"
        for name, value in msgspec.structs.asdict(now).items()
        if value != wanted[name]
    )


def held_evidence(sessions: Sequence[SessionView]) -> tuple[Finding, ...]:
    """Whether the unit held what was uploaded when it was seen last."""
    if (found := held_instead(sessions)) is None:
        return ()
    held, wanted = found
    names = unlike(held, wanted.new_coefficients)
    return (
        Finding(
            kind="not_held",
            subject="unit",
            sentence=f"the unit does not hold what was uploaded ({names or 'other O'}): "
            "upload again",
            direct=True,
        ),
    )


CHECK_NOISE = 1.645
"""A check point whose true error is the tolerance reads more than so many sigmas of its noise above
it once in twenty times."""


def check_limit_deg(tolerance_deg: float, noise_deg: float) -> float:
    """Up to here a check point does not contradict the tolerance; ``noise_deg`` of one point."""
    return tolerance_deg + CHECK_NOISE * noise_deg


def check_evidence(session: SessionView, noise_deg: float) -> tuple[Finding, ...]:
    """Check points beyond the tolerance and their noise: with what was uploaded the unit does not
    point.

    A data point taken since is judged by its own residual, and the next upload by its own checks.
    """
    if not session.uploads:
        return ()
    newest = session.accepted[-1].seq if session.accepted else -1
    tolerance_deg = session.header.tolerance_deg
    limit_deg = check_limit_deg(tolerance_deg, noise_deg)
    since = [c for c in session.checks_after(session.uploads[-1]) if c.seq > newest]
    measured = ((check.seq, check.sky_error_deg) for check in since)
    beyond = {seq: sky for seq, sky in measured if sky is not None and sky > limit_deg}
    if not beyond:
        return ()
    worst = max(beyond.values())
    return (
        Finding(
            kind="not_proven",
            subject="check points",
            sentence=f"{len(beyond)} of {counted(len(since), 'check point')} after the upload: "
            f"beyond the tolerance of {tolerance_deg:g} deg, the worst {worst:.3f} deg; do a "
            "reference check, take more points and upload again",
            number=worst,
            direct=True,
            labels=tuple(beyond),
        ),
    )


def unit_evidence(session: SessionView) -> list[Finding]:
    """Site and Sun of the unit, as far as the records have them."""
    header = session.header
    told, ours = header.unit.site, header.site
    said = [
        Finding(
            kind="unit_sun",
            subject="unit site",
            sentence=f"the unit's {name} is {theirs:.4f}, ours {here:.4f}{remark}",
            number=theirs - here,
            direct=True,
        )
        for name, theirs, here, remark in (
            (
                "latitude",
                told.latitude_deg,
                ours.latitude_deg,
                ": the other hemisphere"
                if abs(told.latitude_deg + ours.latitude_deg) < 2.0 * SITE_AGREEMENT_DEG
                else "",
            ),
            ("longitude", told.longitude_deg, ours.longitude_deg, " (positive east)"),
        )
        if abs(theirs - here) > SITE_AGREEMENT_DEG
    ]
    if header.sun_model != "solartrak":
        return said
    told_unit = UnitSite(
        told, header.unit.zone_west_h, header.geometry, header.ax1_centre_deg, header.unit.heliostat
    )
    strange: dict[str, list[tuple[int, float]]] = {}
    for point, read_utc_s, unit_utc_s, ideal_deg in _strange_suns(session, told_unit):
        sun = check_unit_sun(told_unit, ours, unit_utc_s, ideal_deg, read_utc_s)
        strange.setdefault(sun.explanation, []).append((point.seq, sun.difference_deg))
    for words, points in strange.items():
        worst = max(off for _, off in points)
        said.append(
            Finding(
                kind="unit_sun",
                subject="unit Sun",
                sentence=f"the unit's Sun was {worst:.3f} deg from ours for the clock and site it "
                f"reports, at {counted(len(points), 'point')}: {words}",
                number=worst,
                direct=True,
                labels=tuple(seq for seq, _ in points),
            )
        )
    return said


def _strange_suns(
    session: SessionView, told: UnitSite
) -> Iterator[tuple[PointRecord, float, float, Pair]]:
    """Points where the unit's Sun was not ours: laptop's and unit's instant, ideal angles.

    A point on the Moon has no offsets, and one read off a display in degrees no counts: its angles
    were compared when they were typed, with the time that takes.
    """
    seen = [
        (point, point.unit_minus_laptop_s, point.ideal_deg)
        for point in session.accepted
        if point.unit_minus_laptop_s is not None
        and point.read_utc is not None
        and point.ideal_deg is not None
        and point.counts is not None
        and point.offsets is not None
    ]
    if not seen:
        return
    read_utc_s = np.array(parse_many_utc([point.read_utc for point, _, _ in seen]))
    unit_utc_s = read_utc_s + np.array([ahead_s for _, ahead_s, _ in seen])
    ideal1_deg, ideal2_deg = np.array([ideal for _, _, ideal in seen]).T
    off_deg = sun_difference_deg(told, (ideal1_deg, ideal2_deg), unit_utc_s)
    for index in np.flatnonzero(off_deg > SUN_AGREEMENT_DEG).tolist():
        point, _, ideal_deg = seen[index]
        yield point, float(read_utc_s[index]), float(unit_utc_s[index]), ideal_deg
