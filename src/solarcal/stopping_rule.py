"""When a calibration is done: the tolerance, how sure one must be, and what may be beside P1..P6.

Recorded in the header of a session, so that a replay is judged as the day was.
"""

from collections.abc import Mapping

import msgspec

from solarcal.errors import ConfigurationError

TOLERANCE_DEG = 0.1
DONE_PROBABILITY = 0.95
SYNCHRONISED_S = 1.0
"""One sigma of a laptop's clock that its system says it keeps synchronised."""
UNSYNCHRONISED_S = 5.0
"""The same where nothing is known of it: some days without a time service."""
_LEAST_CLOCK_S = 0.05
"""No clock is compared better than that by hand."""


class Unmodelled(msgspec.Struct, frozen=True, kw_only=True):
    """One sigma of what may be there beside the six numbers.

    Attributes
    ----------
    cross_axis_deg, large_cross_axis_deg : of collimation and of squareness: mostly small, now and
        then large.
    large_chance, large_collimation_chance : how often. Axes are machined square, a pointing device
        is bolted on by hand: its chance is a larger one. None as in sessions that know but one
        chance: that of both.
    sag_deg : gravity sag.
    air : refraction, as a part of the standard air's.
    clock_s : the laptop's clock while the points were taken; right afterwards.
    spot_deg : of a reading of the spot, where a point does not bring its own: what points scatter
        by beyond it may be the tracker's own.

    Raises
    ------
    ConfigurationError
        A width that is not above zero and below 1000, or a chance of a half and more.
    """

    cross_axis_deg: float = 0.02
    large_cross_axis_deg: float = 0.2
    large_chance: float = 0.05
    large_collimation_chance: float | None = None
    sag_deg: float = 0.02
    air: float = 0.05
    clock_s: float = SYNCHRONISED_S
    spot_deg: float = 0.03

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            value = getattr(self, name)
            if name.endswith("_chance"):
                if value is not None and not 0.0 <= value < 0.5:
                    raise ConfigurationError(
                        f"unmodelled: {name} {value:g} is not from 0 to below 0.5"
                    )
            elif not 0.0 < value < 1000.0:
                raise ConfigurationError(
                    f"unmodelled: {name} {value:g} is not above zero and below 1000"
                )

    @property
    def large_chances(self) -> tuple[float, float]:
        """That collimation is large, and that squareness is."""
        own = self.large_collimation_chance
        return self.large_chance if own is None else own, self.large_chance

    def changed(self, widths: Mapping[str, float]) -> "Unmodelled":
        """The same with other widths, by name; ``large_chance`` alone is that of both.

        Raises
        ------
        ConfigurationError
            No such name, or a value that cannot be.
        """
        for name in widths:
            if name not in self.__struct_fields__:
                raise ConfigurationError(
                    f"unmodelled: {name} is none of {', '.join(self.__struct_fields__)}"
                )
        both = {"large_collimation_chance": None} if "large_chance" in widths else {}
        return msgspec.structs.replace(self, **{**both, **widths})

    def with_clock(self, sigma_s: float) -> "Unmodelled":
        return msgspec.structs.replace(self, clock_s=max(sigma_s, _LEAST_CLOCK_S))


DEFAULT_UNMODELLED = Unmodelled(large_collimation_chance=0.48)


class StoppingRule(msgspec.Struct, frozen=True):
    """What verdict, plan and every sentence go by.

    Attributes
    ----------
    tolerance_deg : on sky; 95 % of the year's moments are to be within it.
    probability : with which they must be, for this one tracker. It holds although the technician
        looks after every point: it is the posterior's own, and whenever it is reached it is true.
    unmodelled : what may be there beside P1..P6; the bands of a ``robust`` fit hold it.
    """

    tolerance_deg: float = TOLERANCE_DEG
    probability: float = DONE_PROBABILITY
    unmodelled: Unmodelled = DEFAULT_UNMODELLED

    def __post_init__(self) -> None:
        if not self.tolerance_deg > 0.0:
            raise ConfigurationError(f"the tolerance is {self.tolerance_deg:g} deg, not above zero")
        if not 0.5 <= self.probability < 1.0:
            raise ConfigurationError(
                f"the probability asked for done is {self.probability:g}; give at least 0.5 and "
                "less than 1"
            )

    def within_deg(self, value_deg: float) -> str:
        """``value_deg`` with as many decimals as keep it apart from the tolerance."""
        return apart_from(value_deg, self.tolerance_deg)


DEFAULT_RULE = StoppingRule()


def apart_from(value: float, limit: float, digits: int = 3) -> str:
    """``value`` in at least so many decimals that it reads on the side of the limit it is on."""
    for more in range(digits, digits + 6):
        text = f"{value:.{more}f}"
        if (float(text) < limit, float(text) > limit) == (value < limit, value > limit):
            break
    return text


def percent(probability: float, limit: float) -> str:
    """A probability in whole percent, in more digits only beside the limit it is compared with."""
    # Counted in a thousand draws: none or all of them is no certainty.
    if probability < 0.005:
        return "less than 0.5 %"
    if probability > 0.995 > limit:
        return "more than 99.5 %"
    text = apart_from(100.0 * probability, 100.0 * limit, 0)
    return "more than 99.9 %" if float(text) == 100.0 else f"{text} %"
