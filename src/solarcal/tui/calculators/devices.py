"""Forms about screwjacks and the sunspot device."""

from typing import TYPE_CHECKING

from solarcal.tui.calculators.form import Calculator, Form, FormField

if TYPE_CHECKING:
    from solarcal.report.field.answer import Answer

MEASUREMENTS = 4


def _screwjack(form: Form) -> "Answer":
    from solarcal.mount.screwjack_setup import measured
    from solarcal.report.field.screwjack import Asked, screwjack

    R1, R2, R3 = (form.number(name) for name in ("R1", "R2", "R3"))
    found = [form.pair(f"at{number}") for number in range(1, MEASUREMENTS + 1)]
    if not any(found):
        form.number("at1")
    pins = form.choice("pins") == "pin to pin"
    return screwjack(
        Asked(
            R1=R1,
            R2=R2,
            R3=R3,
            observations=[measured(*one, R3, pin_to_pin=pins) for one in found if one is not None],
            grows=form.choice("sense") == "grows",
            counts=form.optional("counts"),
            limits=form.pair("limits"),
            reference_deg=form.optional("reference"),
            unit=form.choice("unit"),
            wrong_R1=form.optional("wrong_R1"),
        )
    )


def _spot(form: Form) -> "Answer":
    from solarcal.report.field.sunspot import error

    return error(
        form.number("height"),
        form.number("hole"),
        form.number("spot"),
        form.number("edge"),
        form.optional("edge_up"),
        form.optional("turned"),
    )


def _design(form: Form) -> "Answer":
    from solarcal.optics.sunspot import design_for, design_from_size
    from solarcal.report.field.sunspot import design

    hole, shift = form.number("hole"), form.number("shift")
    if form.choice("from") == "a wish":
        wish = form.number("resolution"), form.number("range")
        return design(design_for(*wish, hole, shift))
    return design(design_from_size(form.number("height"), hole, form.number("plate"), shift))


CALCULATORS = (
    Calculator(
        "screwjack", "Drives and devices", "Screwjack", "SJP#1-3 from measured lengths",
        (
            FormField("R1", "R1, axis to pivot", "length"),
            FormField("R2", "R2, axis to pivot", "length"),
            FormField("R3", "R3, tube offset", "length", "0"),
            *(
                FormField(f"at{number}", f"{number}: angle, length", hint="deg length")
                for number in range(1, MEASUREMENTS + 1)
            ),
            FormField(
                "pins", "Lengths are", default="centreline", choices=("centreline", "pin to pin")
            ),
            FormField("sense", "Angle, with length", default="grows", choices=("grows", "shrinks")),
            FormField("unit", "Unit of length", default="in", choices=("in", "mm", "cm", "m")),
            FormField("counts", "Counts per length", hint="none"),
            FormField("limits", "Angles from, to", "deg", hint="all"),
            FormField("reference", "Reference switch", "deg", hint="high limit"),
            FormField("wrong_R1", "R1 longer by", "length", hint="5 mm"),
        ),
        _screwjack,
    ),
    Calculator(
        "sunspot", "Drives and devices", "Sunspot device", "pointing error from where the spot is",
        (
            FormField("height", "H, plate to mirror", "length", "500"),
            FormField("hole", "Do, hole diameter", "length", "4"),
            FormField("spot", "Ds, spot diameter", "length", "13"),
            FormField("edge", "E, edge to edge", "length", "4.5"),
            FormField("edge_up", "E, upwards", "length", hint="not read"),
            FormField("turned", "E, turned by 180", "length", hint="not read"),
        ),
        _spot,
    ),
    Calculator(
        "sunspot-design", "Drives and devices", "Sunspot design", "its resolution and range",
        (
            FormField("from", "Begin with", default="its size", choices=("its size", "a wish")),
            FormField("hole", "Do, hole diameter", "length", "4"),
            FormField("shift", "E is read to", "length", "0.5"),
            FormField("height", "H, plate to mirror", "length", "500"),
            FormField("plate", "Plate diameter", "length", "60"),
            FormField("resolution", "wish: resolution", "deg", "0.02"),
            FormField("range", "wish: range", "deg", "1.5"),
        ),
        _design,
    ),
)  # fmt: skip
