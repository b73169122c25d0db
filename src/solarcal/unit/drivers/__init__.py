"""One driver per kind of controller, chosen by name. ``station.connect`` opens them."""

from solarcal.errors import ConfigurationError

DRIVERS: dict[str, str] = {
    "solartrak": "a unit that speaks the documented protocol",
    "typed": "no line at all: a person types what the controller's display shows",
    "rotctld": "any azimuth-elevation rotator of Hamlib, over its rotctld",
}
"""Name -> what it is for, in the order a technician would look for it."""


def demand_driver(name: str) -> None:
    """Refuse a name that is no driver's.

    Raises
    ------
    ConfigurationError
        Names those there are.
    """
    if name not in DRIVERS:
        raise ConfigurationError(f"no driver {name!r}; there is: {', '.join(DRIVERS)}")
