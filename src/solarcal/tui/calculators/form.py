"""A form of text fields, and what its texts mean; every error names the field it is about."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solarcal.errors import ConfigurationError

if TYPE_CHECKING:
    from solarcal.report.field.answer import Answer
    from solarcal.site import Site


class FormError(ConfigurationError):
    """A field that cannot be, by its label; ``missing`` where nothing stands in it yet."""

    def __init__(self, field: "FormField", message: str, *, missing: bool = False) -> None:
        super().__init__(f"{field.label}: {message}")
        self.field = field.name
        self.missing = missing


@dataclass(frozen=True, slots=True)
class FormField:
    """One row: what to ask for, in which unit, and what stands there at first.

    ``choices`` make it a field to choose from; ``hint`` says what an empty one means.
    """

    name: str
    label: str
    unit: str = ""
    default: str = ""
    hint: str = ""
    choices: tuple[str, ...] = ()


class Form:
    """The texts of a calculator's fields as numbers.

    Parameters
    ----------
    fields, values : the form, and what stands in it; a field not there holds its default.
    now_utc_s : what an empty time means, POSIX UTC seconds.
    """

    def __init__(
        self, fields: tuple[FormField, ...], values: Mapping[str, str], now_utc_s: float
    ) -> None:
        self._fields = {field.name: field for field in fields}
        self._values = values
        self.now_utc_s = now_utc_s

    def text(self, name: str) -> str:
        """What stands there."""
        return self._values.get(name, self._fields[name].default).strip()

    def choice(self, name: str) -> str:
        """One of the field's choices."""
        text, field = self.text(name), self._fields[name]
        if text not in field.choices:
            raise self.error(name, f"{text!r} is none of {', '.join(field.choices)}")
        return text

    def number(self, name: str) -> float:
        """The number there; a comma is taken for a decimal point."""
        found = self.optional(name)
        if found is None:
            raise FormError(self._fields[name], "is missing", missing=True)
        return found

    def optional(self, name: str) -> float | None:
        """The number there, or None where nothing stands."""
        text = self.text(name)
        return self._parsed(name, text) if text else None

    def numbers(self, name: str, count: int) -> tuple[float, ...] | None:
        """So many numbers with spaces between, or None where nothing stands."""
        text = self.text(name)
        if not text:
            return None
        parts = text.replace(";", " ").split()
        if len(parts) != count:
            raise self.error(name, f"write {count} numbers with spaces between, not {text!r}")
        return tuple(self._parsed(name, part) for part in parts)

    def pair(self, name: str) -> tuple[float, float] | None:
        """Two numbers, or None."""
        found = self.numbers(name, 2)
        return None if found is None else (found[0], found[1])

    def utc_s(self, name: str) -> float:
        """The instant there, POSIX UTC seconds; now where nothing stands."""
        text = self.text(name)
        return self.instant(name, text) if text else self.now_utc_s

    def day_utc_s(self, name: str, site: "Site") -> float:
        """An instant of the day meant there: a date alone is the site's own day, at its noon."""
        from solarcal.site import day_utc_s

        text = self.text(name)
        try:
            return day_utc_s(text, site) if text else self.now_utc_s
        except ConfigurationError as error:
            raise self.error(name, str(error)) from None

    def instant(self, name: str, text: str) -> float:
        """An ISO 8601 text of this field."""
        from solarcal.timescale import parse_utc

        try:
            return parse_utc(text)
        except ConfigurationError as error:
            raise self.error(name, str(error)) from None

    def site(self) -> "Site":
        """The place of the fields lat, lon and elevation."""
        from solarcal.site import Site

        return Site(
            self._within("lat", -90.0, 90.0),
            self._within("lon", -180.0, 360.0),
            self._within("elevation", -500.0, 9000.0),
        )

    def error(self, name: str, message: str) -> FormError:
        """An error of this field, to be raised."""
        return FormError(self._fields[name], message)

    def _within(self, name: str, low: float, high: float) -> float:
        value = self.number(name)
        if not low <= value <= high:
            raise self.error(name, f"{value:g} is not between {low:g} and {high:g}")
        return value

    def _parsed(self, name: str, text: str) -> float:
        try:
            value = float(text.replace(",", "."))
        except ValueError:
            raise self.error(name, f"{text!r} is not a number") from None
        if not abs(value) < float("inf"):
            raise self.error(name, f"{text!r} is not a number")
        return value


@dataclass(frozen=True, slots=True)
class Calculator:
    """A form and what it answers. ``compute`` runs on a thread; it must not draw."""

    id: str
    group: str
    title: str
    purpose: str
    fields: tuple[FormField, ...]
    compute: "Callable[[Form], Answer]"


GEOMETRY_FIELDS = (
    FormField(
        "geometry", "Mount", default="azel",
        choices=("azel", "tiltroll-ew", "tiltroll-ns", "polar"),
    ),
    FormField("centre", "Centre of AX1", "deg", hint="by site"),
)  # fmt: skip

PLACE_FIELDS = (
    FormField("lat", "Latitude", "deg N"),
    FormField("lon", "Longitude", "deg EAST"),
    FormField("elevation", "Elevation", "m", "0"),
)
"""Filled from the connected unit's session, else from the profile."""

TIME_FIELD = FormField("at", "Time (UTC)", hint="now")

REFRACTION_FIELD = FormField(
    "refraction", "Refraction", default="hughes", choices=("hughes", "saemundsson", "none")
)
