"""Headers, records and tables the session tests are built from."""

import dataclasses

import numpy as np

from solarcal.mount.drive import RotaryDrive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.session.points import PointTable
from solarcal.session.records import Answers, Header, Note, PointRecord, UnitRecord
from solarcal.site import Site

UTC = "2026-06-21T15:30:00.000Z"
SITE = Site(35.05, -106.48, 1830.0, "Tijeras")

UNIT = UnitRecord(
    model="SOLARTRAK-EMU",
    serial="0001",
    firmware="1.0",
    zone_west_h=7.0,
    drive1=RotaryDrive(counts_per_deg=100.0),
    drive2=RotaryDrive(counts_per_deg=-100.0),
    limits=Limits(AxisLimits(-120.0, 120.0), AxisLimits(5.0, 88.0)),
    update_range_deg=0.1,
    reference1_deg=-100.0,
    reference2_deg=85.0,
    tilt_decimals=4,
    scale_decimals=6,
    site=SITE,
)
HEADER = Header(
    utc=UTC,
    software="solarcal test",
    unit=UNIT,
    site=SITE,
    geometry="azel",
    ax1_centre_deg=0.0,
    operator="Ünal",
)


def note(seq: int, text: str = "clouds from the west") -> Note:
    return Note(seq=seq, utc=UTC, text=text)


def point(seq: int, status: str = "accepted", **changes: object) -> PointRecord:
    fields: dict[str, object] = {
        "answers": Answers(ref_check=True, sun_offset=True, tracking=True),
        "basis": "sun_offset",
        "read_utc": "2026-06-21T15:29:58.250Z",
        "ideal_deg": (61.123456789, 54.25),
        "reading_deg": (61.4, 54.5),
        "counts": (16140, -3050),
        "offsets": Offsets(0.2, 0.1),
        "coefficients": Coefficients(P1=0.1),
        "approach": (1, -1),
        "error_deg": (0.276543211, 0.25),
    }
    return PointRecord(seq=seq, utc=UTC, status=status, **{**fields, **changes})  # type: ignore[arg-type]


def table(n: int = 3, **changes: object) -> PointTable:
    """Points of an azel unit, nothing special about them; ``changes`` replaces fields."""
    rng = np.random.default_rng(n)
    plain = PointTable(
        geometry="azel",
        latitude_deg=35.05,
        longitude_deg=-106.48,
        elevation_m=1830.0,
        unit="tower 3",
        ax1_centre_deg=0.0,
        ideal="apparent",
        utc_s=1782055800.0 + 1800.0 * np.arange(n),
        ax1_deg=rng.uniform(-90.0, 90.0, n),
        ax2_deg=rng.uniform(15.0, 80.0, n),
        err1_deg=rng.normal(0.0, 0.5, n),
        err2_deg=rng.normal(0.0, 0.5, n),
        sigma_deg=None,
        status=("accepted",) * n,
        approach=((0, 0),) * n,
        note=("",) * n,
        labels=tuple(range(2, n + 2)),
        sources=("points.csv",) * n,
    )
    return dataclasses.replace(plain, **changes)  # type: ignore[arg-type]


COLUMNS = ("utc_s", "ax1_deg", "ax2_deg", "err1_deg", "err2_deg")


def assert_same_points(a: PointTable, b: PointTable) -> None:
    """Equal to the last bit in everything but labels, sources and warnings."""
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    assert (a.sigma_deg is None) == (b.sigma_deg is None)
    if a.sigma_deg is not None:
        np.testing.assert_array_equal(a.sigma_deg, b.sigma_deg)
    for name in (
        "geometry", "latitude_deg", "longitude_deg", "elevation_m", "unit", "ax1_centre_deg",
        "ideal", "status", "approach", "note",
    ):  # fmt: skip
        assert getattr(a, name) == getattr(b, name), name
