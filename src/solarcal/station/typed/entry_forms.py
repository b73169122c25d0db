"""The form of each step, in the field's words."""

from collections.abc import Mapping

from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients, Offsets
from solarcal.station.typed.forms import DisplayField, DisplayForm, Doubt, Doubting, Kind, Moment

LARGEST_OFFSET_DEG = 30.0
OFFSET_NAMES = ("O1", "O2")

CLOCK = DisplayField(
    "clock", "The unit's clock", Kind.TIME, "local", hint="HH:MM:SS, as its display shows it"
)
WHEN = DisplayField(
    "time", "The unit's clock then", Kind.TIME, "local", optional=True,
    hint="empty: as you begin to type",
)  # fmt: skip
STORED = DisplayField(
    "stored", "Stored in permanent memory", Kind.YES_NO, "yes or no", default="yes"
)


def reading_fields(counts: bool) -> tuple[DisplayField, ...]:
    """Both axes as the display shows them: degrees, or counts since the last reference."""
    return tuple(
        DisplayField(f"ax{axis}", f"AX{axis}, counts", Kind.COUNTS, "counts")
        if counts
        else DisplayField(f"ax{axis}", f"AX{axis}, read-out", low=-540.0, high=540.0)
        for axis in (1, 2)
    )


def offset_fields(default: str = "") -> tuple[DisplayField, ...]:
    """Both reference offsets."""
    return tuple(
        DisplayField(
            name.lower(), f"{name}, offset of axis {name[1]}", default=default,
            low=-LARGEST_OFFSET_DEG, high=LARGEST_OFFSET_DEG,
        )
        for name in OFFSET_NAMES
    )  # fmt: skip


def sun_fields(shown: bool) -> tuple[DisplayField, ...]:
    """The Sun's axis angles, for a display that has them."""
    return tuple(
        DisplayField(f"sun{axis}", f"Sun AX{axis}, if shown", optional=True, low=-540.0, high=540.0)
        for axis in (1, 2)
        if shown
    )


def coefficient_fields(default: str = "") -> tuple[DisplayField, ...]:
    """P1..P6 as the display shows them."""
    return tuple(
        DisplayField(name.lower(), name, unit="deg", default=default, low=-90.0, high=90.0)
        if index < 4
        else DisplayField(
            name.lower(), name, Kind.NUMBER, "deg/deg", default=default, low=-1.0, high=1.0
        )
        for index, name in enumerate(COEFFICIENT_NAMES)
    )


def came_field(axis: int, sense: int) -> DisplayField:
    """From which side an axis came; ``sense`` is that of the Sun."""
    forward = "+" if sense > 0 else "-"
    return DisplayField(
        f"came{axis}", f"Axis {axis} came last in sense", Kind.SENSE, "+ or -", optional=True,
        hint=f"{forward} is from behind; empty: not known",
    )  # fmt: skip


def open_form(doubts: Doubting) -> DisplayForm:
    """What the unit holds and what its clock says, before anything is done."""
    return DisplayForm(
        "open",
        "What the unit shows now",
        (
            "Look up P1..P6 and both reference offsets on the unit; type what they show.",
            "Last its clock: type a time it is ABOUT to show; Enter the moment it shows it.",
        ),
        (*coefficient_fields("0"), *offset_fields("0"), CLOCK),
        Moment.ENTER,
        doubts=doubts,
    )


def held_form() -> DisplayForm:
    """What the unit holds, asked again where it is no longer known."""
    return DisplayForm(
        "held",
        "What the unit holds now",
        ("The values keyed in last were not read back. Look up P1..P6 and both offsets again.",),
        (*coefficient_fields(), *offset_fields()),
    )


def clock_form(wanted_local: str, doubts: Doubting) -> DisplayForm:
    """The unit's clock, after it was set."""
    return DisplayForm(
        "clock",
        "Set the unit's clock",
        (
            f"Set the unit's clock by its own keys to the local standard time {wanted_local}.",
            "Then type a time it is ABOUT to show; press Enter the moment it shows it.",
        ),
        (CLOCK,),
        Moment.ENTER,
        doubts=doubts,
    )


def _half_typed(texts: Mapping[str, str], read_utc_s: float) -> tuple[Doubt, ...]:
    """Counts of one axis say nothing: a display shows both, or none."""
    del read_utc_s
    missing = [name for name in ("found1", "found2") if not texts[name]]
    if len(missing) != 1:
        return ()
    return (Doubt("Type the counts of both axes, or of none.", missing[0]),)


def ref_check_form() -> DisplayForm:
    """A reference check, done at the unit."""
    return DisplayForm(
        "reference",
        "Reference check",
        (
            "Start it at the unit (Alt-F5 or its RESET key); watch BOTH axes reach their switches.",
            "Note the counts its display shows there just before they become zero: at the "
            "first check and after a restart any number; later 0, or counts were missed.",
        ),
        (
            DisplayField("complete", "Did both reach their switches", Kind.YES_NO, "yes or no"),
            *(
                DisplayField(
                    f"found{axis}", f"Counts found, axis {axis}", Kind.COUNTS, "counts",
                    optional=True, hint="empty: the display does not show them",
                )
                for axis in (1, 2)
            ),
        ),
        doubts=_half_typed,
    )  # fmt: skip


def offset_form(counts: bool, sun: bool, senses: tuple[int, int], doubts: Doubting) -> DisplayForm:
    """A Set Sun Offset, done at the unit."""
    first, second = ("+" if sense > 0 else "-" for sense in senses)
    return DisplayForm(
        "offset",
        "Set Sun Offset",
        (
            f"At the unit: the Sun moves axis 1 {first}, axis 2 {second}. Go behind it, come "
            "forward, centre the spot, press Set Sun Offset. Type what the display shows then.",
        ),
        (
            *reading_fields(counts),
            *offset_fields(),
            came_field(1, senses[0]),
            came_field(2, senses[1]),
            *sun_fields(sun),
            WHEN,
        ),
        doubts=doubts,
    )


def point_form(counts: bool, sun: bool, doubts: Doubting) -> DisplayForm:
    """A data point or check point: what the display shows while the unit tracks."""
    return DisplayForm(
        "point",
        "Type what the display shows",
        (
            "While the unit tracks with the spot centred, read the offsets on the display again: "
            "typing them twice detects errors.",
        ),
        (*reading_fields(counts), *offset_fields(), *sun_fields(sun), WHEN),
        doubts=doubts,
    )


def key_in_form(
    wanted: Coefficients, offsets: Offsets, decimals: tuple[int, int], doubts: Doubting
) -> DisplayForm:
    """New coefficients, to be keyed in and read back."""
    return DisplayForm(
        "upload",
        "Key in the coefficients",
        (
            "Key these in at the unit, set the offsets as shown, store to permanent memory. Then "
            "type what its DISPLAY shows.",
        ),
        (*coefficient_fields(), *offset_fields(), STORED),
        key_in=key_in_texts(wanted, offsets, decimals),
        doubts=doubts,
    )


def zero_form(offsets: Offsets, decimals: tuple[int, int], doubts: Doubting) -> DisplayForm:
    """The offsets alone, where P1..P6 stay: after a check point."""
    return DisplayForm(
        "zero",
        "Set both offsets back",
        ("P1..P6 stay as they are. At the unit set both reference offsets as shown, and store.",),
        (*offset_fields(), STORED),
        key_in=key_in_texts(None, offsets, decimals),
        doubts=doubts,
    )


def key_in_texts(
    coefficients: Coefficients | None, offsets: Offsets, decimals: tuple[int, int]
) -> tuple[tuple[str, str], ...]:
    """Names and values as the unit keeps them, to be keyed in.

    ``decimals``: how many the unit keeps of P1..P4 and O; and of P5, P6.
    """
    tilt, scale = decimals
    named = []
    if coefficients is not None:
        digits = (tilt,) * 4 + (scale,) * 2
        for name, value, places in zip(
            COEFFICIENT_NAMES, coefficients.as_tuple(), digits, strict=True
        ):
            named.append((name, signed(value, places)))
    for name, value in zip(OFFSET_NAMES, (offsets.O1, offsets.O2), strict=True):
        named.append((name, signed(value, tilt)))
    return tuple(named)


def signed(value: float, decimals: int) -> str:
    """A value to key in: its sign always shown, but for zero."""
    text = f"{value:+z.{decimals}f}"
    return text if float(text) else text[1:]
