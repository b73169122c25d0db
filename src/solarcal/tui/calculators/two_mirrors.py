"""Forms about two-mirror trackers: axes, the diode's correction, field of view."""

from typing import TYPE_CHECKING

from solarcal.tui.calculators.form import (
    PLACE_FIELDS,
    REFRACTION_FIELD,
    TIME_FIELD,
    Calculator,
    Form,
    FormField,
)
from solarcal.tui.calculators.heliostats import drawn_latitude_deg, sun_deg

if TYPE_CHECKING:
    from solarcal.report.field.answer import Answer


def _point(form: Form) -> "Answer":
    from solarcal.report.field.two_mirror import point
    from solarcal.two_mirror.mirrors import EulerBase

    base = EulerBase(form.number("alpha"), form.number("beta"), form.number("gamma"))
    return point(*sun_deg(form), base, latitude_deg=drawn_latitude_deg(form))


def _trace(form: Form) -> "Answer":
    from solarcal.report.field.two_mirror import trace
    from solarcal.two_mirror.diode import QuadrantDiode, disc_gain_per_rad

    found = [form.numbers(name, 3) for name in ("mirror1", "mirror2")]
    gain = form.optional("gain")
    diode = QuadrantDiode.with_fixed_mirrors(
        [list(normal) for normal in found if normal is not None],
        gain_per_rad=disc_gain_per_rad() if gain is None else gain,
        set_point1=form.number("set1"),
        set_point2=form.number("set2"),
    )
    signals = form.number("a"), form.number("b"), form.number("c"), form.number("d")
    return trace(signals, form.number("t1"), form.number("t2"), diode)


def _fov(form: Form) -> "Answer":
    from solarcal.report.field.two_mirror import fov
    from solarcal.two_mirror.diode import field_of_view

    return fov(
        field_of_view(
            form.number("diode"),
            form.number("focal"),
            form.number("tracker"),
            form.number("distance"),
            form.number("sun"),
        )
    )


CALCULATORS = (
    Calculator(
        "mirrors-point", "Two-mirror tracker", "Point", "axis angles that look at the Sun",
        (
            FormField("sun", "Sun az, zenith", "deg", "180 40", "by time"),
            FormField("alpha", "Base alpha (z)", "deg", "0"),
            FormField("beta", "Base beta (y)", "deg", "0"),
            FormField("gamma", "Base gamma (x)", "deg", "0"),
            *PLACE_FIELDS, TIME_FIELD, REFRACTION_FIELD,
        ),
        _point,
    ),
    Calculator(
        "mirrors-trace", "Two-mirror tracker", "Trace", "the diode's signals as axis corrections",
        (
            *(FormField(name, f"Signal {name.upper()}", default="1") for name in "abcd"),
            FormField("t1", "Axis 1 (AX1)", "deg", "0"),
            FormField("t2", "Axis 2 (AX2)", "deg", "45"),
            FormField("set1", "Set point e1c", default="0"),
            FormField("set2", "Set point e2c", default="0"),
            FormField("gain", "Gain", "1/rad", hint="disc"),
            FormField("mirror1", "Fixed mirror 1", "normal", hint="none"),
            FormField("mirror2", "Fixed mirror 2", "normal", hint="none"),
        ),
        _trace,
    ),
    Calculator(
        "mirrors-fov", "Two-mirror tracker", "Field of view", "diode and tracker against the Sun",
        (
            FormField("diode", "Diode diameter", "mm", "6"),
            FormField("focal", "Focal length", "mm", "200"),
            FormField("tracker", "Tracker diameter", "m", "0.1"),
            FormField("distance", "Tracker distance", "m", "5"),
            FormField("sun", "Sun diameter", "mrad", "9.3"),
        ),
        _fov,
    ),
)  # fmt: skip
