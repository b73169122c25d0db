"""Dialogs in which an emulated Sun must not run away: its time goes no faster than life."""

from solarcal.station.procedure import Station
from solarcal.tui.screens.dialog import Dialog
from solarcal.tui.widgets.key_button import DialogKey

PACE = "speed"
"""The step's name; its result is the speed as it is then."""

LIFE = 1.0
FASTEST = 10.0
"""Beyond this a jog target expires before it is renewed, and nobody can watch a gathering."""

SPEED_KEYS = (
    DialogKey("faster", "emulator faster", "plus", "+", button=False),
    DialogKey("slower", "emulator slower", "minus", "-", button=False),
)


class PacedDialog(Dialog):
    """Sets a faster emulator to x1 while open, and back unless it was changed meanwhile.

    The keys for an emulator's speed work here too, within reason.
    """

    def __init_subclass__(cls) -> None:
        cls.KEYS = (*cls.KEYS, *SPEED_KEYS)
        super().__init_subclass__()

    def __init__(self) -> None:
        super().__init__()
        self._before: float | None = None

    def on_mount(self) -> None:
        super().on_mount()
        speed = self.station_app.emulated_speed
        if speed is not None and speed > LIFE:
            self._before = speed
            self._pace(LIFE)

    def on_unmount(self) -> None:
        app = self.station_app
        if self._before is not None and app.emulated_speed == LIFE and app.conductor is not None:
            self._pace(self._before)

    def action_faster(self) -> None:
        speed = self.station_app.emulated_speed
        if speed is not None and speed >= FASTEST:
            self.say(f"No faster than x{FASTEST:g} while this is open.", "warning")
        else:
            self.station_app.action_perform("faster")

    def action_slower(self) -> None:
        self.station_app.action_perform("slower")

    def _pace(self, speed: float) -> None:
        # At once, so that a key pressed before the unit has answered counts from here.
        self.station_app.emulated_speed = speed
        self.submit(PACE, lambda station: _set_speed(station, speed))


def _set_speed(station: Station, speed: float) -> float | None:
    emulation = station.tracker.emulation
    return emulation.set_speed(speed) if emulation is not None else None
