"""Days on the Sun for the tests of the model, by spherical trigonometry alone."""

import numpy as np

from solarcal.model.points import Points
from solarcal.model.terms import NativeAngles, Term, design_matrix
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.units import FloatArray

JUNE, EQUINOX, DECEMBER = 23.4, 0.0, -23.4
TRUTH = Coefficients(P1=0.31, P2=-0.22, P3=-0.45, P4=0.17, P5=0.0011, P6=-0.0016)


def design_of(
    term: Term, geometry: MountGeometry, ax1_deg: FloatArray, ax2_deg: FloatArray
) -> FloatArray:
    """Axis degrees on (E1, E2) per unit of a term, shape (n, 2)."""
    ax1, ax2 = np.broadcast_arrays(np.atleast_1d(ax1_deg), np.atleast_1d(ax2_deg))
    return design_matrix((term,), NativeAngles.at(geometry, ax1, ax2))[0].T


def sun_axes(
    geometry: MountGeometry, declination_deg: float, n: int, hours: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """AX1, AX2 of the Sun at n equal steps around noon, above 10 deg of elevation all day.

    Around the equinox the declination moves by 0.0164 deg an hour, which alone makes the tilt of
    an east-west tilt-roll move at all.
    """
    lat = np.radians(geometry.latitude_deg)
    dec = np.radians(declination_deg)
    cos_limit = (np.sin(np.radians(10.0)) - np.sin(lat) * np.sin(dec)) / (np.cos(lat) * np.cos(dec))
    half_day = np.degrees(np.arccos(cos_limit)) / 15.0
    half = half_day if hours is None else hours / 2.0
    hour = np.linspace(-half, half, n)
    drift = 0.0164 if abs(declination_deg) < 5.0 else 0.0
    return axes_at(geometry, declination_deg + drift * hour, 15.0 * hour)


def axes_at(
    geometry: MountGeometry, declination_deg: FloatArray, hour_angle_deg: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """AX1, AX2 of a Sun of this declination; hour angle positive in the afternoon."""
    lat, dec, ha = (
        np.radians(angle) for angle in (geometry.latitude_deg, declination_deg, hour_angle_deg)
    )
    east = -np.cos(dec) * np.sin(ha)
    north = np.cos(lat) * np.sin(dec) - np.sin(lat) * np.cos(dec) * np.cos(ha)
    up = np.sin(lat) * np.sin(dec) + np.cos(lat) * np.cos(dec) * np.cos(ha)
    return geometry.axes_from_horizontal(
        np.degrees(np.arctan2(east, north)) % 360.0,
        np.degrees(np.arctan2(np.hypot(east, north), up)),
    )


def year_axes(geometry: MountGeometry) -> tuple[FloatArray, FloatArray]:
    """The Sun above 10 deg over a year: 25 declinations, every half hour."""
    days = [sun_axes(geometry, 23.4 * np.sin(2 * np.pi * k / 25) + 1e-3, 21) for k in range(25)]
    ax1, ax2 = zip(*days, strict=True)
    return np.concatenate(ax1), np.concatenate(ax2)


def points_of_day(
    name: str,
    declination_deg: float,
    n: int,
    *,
    truth: Coefficients = TRUTH,
    noise_deg: float = 0.0,
    sigma_deg: float | None = None,
    seed: int = 1,
    hours: float | None = None,
    latitude_deg: float = 35.0,
) -> Points:
    """Points with errors of the controller's formula and noise on sky, one sigma per axis."""
    geometry = MountGeometry(name, latitude_deg)
    ax1, ax2 = sun_axes(geometry, declination_deg, n, hours)
    e1, e2 = correction_deg(truth, ax1, ax2)
    noise = noise_deg * np.random.default_rng(seed).standard_normal((2, n))
    return Points(
        geometry=geometry,
        ax1_deg=ax1,
        ax2_deg=ax2,
        err1_deg=e1 + noise[0] / np.sin(np.radians(ax2)),
        err2_deg=e2 + noise[1],
        sigma_deg=None if sigma_deg is None else np.full(n, sigma_deg),
    )


def sky_rms_deg(ax2_deg: FloatArray, e1_deg: FloatArray, e2_deg: FloatArray) -> float:
    return float(np.sqrt(np.mean((e1_deg * np.sin(np.radians(ax2_deg))) ** 2 + e2_deg**2)))
