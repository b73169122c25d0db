"""All field calculators, in the order of the list."""

from solarcal.tui.calculators import devices, heliostats, the_sun, two_mirrors
from solarcal.tui.calculators.form import Calculator

CALCULATORS: tuple[Calculator, ...] = (
    *the_sun.CALCULATORS,
    *heliostats.CALCULATORS,
    *two_mirrors.CALCULATORS,
    *devices.CALCULATORS,
)

BY_ID = {calculator.id: calculator for calculator in CALCULATORS}
