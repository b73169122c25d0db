"""Does the unit compute the same Sun as this program?

The unit's own algorithm is known, so its ``ideal`` angles can be computed here from the clock, site
and zone it reports. Agreement proves that hour, zone, hemisphere and site are what they say;
disagreement is a wrong setting, and the one that explains it is searched for and named.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from solarcal.model.evidence.clocks import CLOCK_TOLERANCE_S
from solarcal.model.finding import Finding
from solarcal.mount.controller import ideal_axes_deg
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import MountGeometry
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView
from solarcal.site import Site
from solarcal.timescale import SECONDS_PER_DAY, SECONDS_PER_SUN_DEG, parse_utc
from solarcal.unit.tracker import Mode, Status, UnitSite

AGREEMENT_DEG = 0.002
"""The wire carries milliseconds and 1e-5 deg; anything above this is another Sun."""

SITE_AGREEMENT_DEG = 0.005
"""A site wrong by this much moves the Sun by as much."""

SUN_AGREEMENT_DEG = 0.01
"""The clocks were compared minutes after the angles were read: 2 s of drift lie between at most."""

MATCH_DEG = 0.02
"""A hypothesis that brings the difference below this explains it."""


@dataclass(frozen=True, slots=True)
class UnitSunCheck:
    """Largest difference of the unit's ideal angles from ours on sky, and what explains it."""

    difference_deg: float
    explanation: str

    @property
    def agrees(self) -> bool:
        return self.difference_deg <= AGREEMENT_DEG


def _geometry(unit_site: UnitSite, latitude_deg: float) -> MountGeometry:
    return MountGeometry(unit_site.geometry, latitude_deg, unit_site.ax1_centre_deg)


def _difference_deg(unit_site: UnitSite, site: Site, utc_s: float, status: Status) -> float:
    geometry = _geometry(unit_site, site.latitude_deg)
    ax1, ax2 = ideal_axes_deg(geometry, site, utc_s, unit_site.heliostat)
    return float(geometry.sky_separation_deg(status.ideal1_deg, status.ideal2_deg, ax1, ax2))


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
        moved(told.latitude_deg, -told.longitude_deg),
        utc_s,
    )
    yield "it uses our site, not the one it reports", ours, utc_s
    yield "it uses another date or time than it reports (the laptop's fits)", told, laptop_utc_s
    for days in (1, -1):
        yield f"its date is wrong by {days:+d} day", told, utc_s + SECONDS_PER_DAY * days


def check_unit_sun(
    unit_site: UnitSite, ours: Site, status: Status, laptop_utc_s: float
) -> UnitSunCheck:
    """Compare the unit's ideal angles with ours for the clock, site and zone it reports."""
    told = unit_site.site
    difference = _difference_deg(unit_site, told, status.unit_utc_s, status)
    if difference <= AGREEMENT_DEG:
        return UnitSunCheck(difference, "the unit's Sun is ours")
    for words, site, utc_s in _hypotheses(told, ours, status.unit_utc_s, laptop_utc_s):
        if _difference_deg(unit_site, site, utc_s, status) <= MATCH_DEG:
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
    if abs(told.longitude_deg - ours.longitude_deg) > 0.005:
        said.append(
            f"the unit's longitude is {told.longitude_deg:.4f}, ours {ours.longitude_deg:.4f} "
            "(positive east)"
        )
    hours = round(unit_minus_laptop_s / 3600.0)
    if hours and abs(unit_minus_laptop_s - 3600.0 * hours) < 120.0:
        said.append(
            f"the unit's UTC differs from the laptop's by {hours:+d} h: its hour or its zone "
            f"({unit_site.zone_west_h:g} h west) is wrong, or the laptop's is"
        )
    elif abs(unit_minus_laptop_s) > CLOCK_TOLERANCE_S:
        said.append(
            f"the unit's clock differs from the laptop's by {unit_minus_laptop_s:+.1f} s, "
            f"{abs(unit_minus_laptop_s) / SECONDS_PER_SUN_DEG:.3f} deg of Sun"
        )
    return tuple(said)


def held_evidence(session: SessionView) -> tuple[Finding, ...]:
    """Whether the unit held what was uploaded when it was compared last."""
    if session.holds_upload:
        return ()
    held, wanted = session.in_force[-1], session.uploads[-1]
    names = [
        f"{name} {now:g} instead of {then:g}"
        for name, now, then in zip(
            COEFFICIENT_NAMES,
            held.coefficients.as_tuple(),
            wanted.new_coefficients.as_tuple(),
            strict=True,
        )
        if now != then
    ]
    return (
        Finding(
            kind="not_held",
            subject="unit",
            sentence=f"the unit does not hold what was uploaded ({', '.join(names) or 'other O'}): "
            "upload again",
            direct=True,
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
    strange: dict[str, list[tuple[int, float]]] = {}
    for point in session.accepted:
        status = _status_at(point)
        if status is not None and point.read_utc is not None:
            told_site = UnitSite(
                told,
                header.unit.zone_west_h,
                header.geometry,
                header.ax1_centre_deg,
                header.unit.heliostat,
            )
            sun = check_unit_sun(told_site, ours, status, parse_utc(point.read_utc))
            if sun.difference_deg > SUN_AGREEMENT_DEG:
                strange.setdefault(sun.explanation, []).append((point.seq, sun.difference_deg))
    for words, points in strange.items():
        worst = max(off for _, off in points)
        said.append(
            Finding(
                kind="unit_sun",
                subject="unit Sun",
                sentence=f"the unit's Sun was {worst:.3f} deg from ours for the clock and site it "
                f"reports, at {len(points)} point{'s' if len(points) > 1 else ''}: {words}",
                number=worst,
                direct=True,
                labels=tuple(seq for seq, _ in points),
            )
        )
    return said


def _status_at(point: PointRecord) -> Status | None:
    """What the unit said when a point's angles were read, as far as the point has stored it."""
    if (
        point.unit_minus_laptop_s is None
        or point.read_utc is None
        or point.ideal_deg is None
        or point.reading_deg is None
        or point.counts is None
        or point.offsets is None
    ):
        return None
    return Status(
        mode=Mode.TRACK,
        unit_utc_s=parse_utc(point.read_utc) + point.unit_minus_laptop_s,
        ideal1_deg=point.ideal_deg[0],
        ideal2_deg=point.ideal_deg[1],
        reading1_deg=point.reading_deg[0],
        reading2_deg=point.reading_deg[1],
        counts1=point.counts[0],
        counts2=point.counts[1],
        target1_deg=point.reading_deg[0],
        target2_deg=point.reading_deg[1],
        offsets=point.offsets,
        moving=(0, 0),
        approach=point.approach or (0, 0),
        update_phase=0.0,
        referenced=True,
        unlocked_s=0.0,
    )
