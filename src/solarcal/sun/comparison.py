"""Two models of the Sun over years at one site: how far they differ in altitude and azimuth."""

from dataclasses import dataclass

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.site import Site
from solarcal.sun.position import sun_position
from solarcal.timescale import parse_utc
from solarcal.units import FloatArray, wrap_deg

EVERY_S = 3600.0 * 5.0
"""Not a part of a day, so that all hours come in turn."""
_MOST_YEARS = 100


@dataclass(frozen=True, eq=False, slots=True)
class ModelDifference:
    """First model minus second, where the second has the Sun above ``lowest_deg``; (n,) each.

    ``cross_deg``: azimuth times the cosine of altitude: on the sky.
    """

    utc_s: FloatArray
    altitude_deg: FloatArray
    azimuth_deg: FloatArray
    cross_deg: FloatArray

    def summary(self) -> dict[str, float]:
        """Worst and rms, degrees, and the number of positions."""
        columns = {
            "altitude": self.altitude_deg, "azimuth": self.azimuth_deg, "cross": self.cross_deg
        }  # fmt: skip
        found = {"positions": float(len(self.utc_s))}
        for name, values in columns.items():
            found[f"{name}_worst_deg"] = float(np.abs(values).max())
            found[f"{name}_rms_deg"] = float(np.sqrt(np.mean(values**2)))
        return found

    def by_year(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Years, and the worst altitude and azimuth of each on the sky, degrees."""
        years = self.utc_s.astype("datetime64[s]").astype("datetime64[Y]").astype(int) + 1970
        every = np.unique(years)
        return (
            every.astype(np.float64),
            np.array([np.abs(self.altitude_deg[years == year]).max() for year in every]),
            np.array([np.abs(self.cross_deg[years == year]).max() for year in every]),
        )


def compare_models(
    first: str, second: str, site: Site, from_year: int, to_year: int, lowest_deg: float = 0.0
) -> ModelDifference:
    """Both models from the start of one year to the end of another, every five hours.

    Raises
    ------
    ConfigurationError
        Years the wrong way round, more than a hundred of them, or a Sun that is never so high.
    """
    if not 0 <= to_year - from_year < _MOST_YEARS:
        raise ConfigurationError(
            f"the years {from_year} to {to_year} must be in order and at most {_MOST_YEARS}"
        )
    utc_s = np.arange(parse_utc(f"{from_year}-01-01"), parse_utc(f"{to_year + 1}-01-01"), EVERY_S)
    a, b = (sun_position(model, utc_s, site) for model in (first, second))
    up = b.elevation_deg > lowest_deg
    if not up.any():
        raise ConfigurationError(f"the Sun is never higher than {lowest_deg:g} deg there")
    azimuth = np.asarray(wrap_deg(a.azimuth_deg - b.azimuth_deg))[up]
    return ModelDifference(
        utc_s=utc_s[up],
        altitude_deg=np.asarray(a.elevation_deg - b.elevation_deg)[up],
        azimuth_deg=azimuth,
        cross_deg=azimuth * np.cos(np.radians(b.elevation_deg[up])),
    )
