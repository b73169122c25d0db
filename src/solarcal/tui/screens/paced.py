"""Dialogs in which an emulated Sun must not run away: its time goes no faster than life."""

from solarcal.station.procedure import Station
from solarcal.tui.screens.dialog import Dialog
from solarcal.tui.widgets.key_button import DialogKey

PACE = "speed"
"""The step's name; its result is the speed as it is then."""

SPEED_KEYS = (
    DialogKey("app.perform('faster')", "emulator faster", "plus", "+", button=False),
    DialogKey("app.perform('slower')", "emulator slower", "minus", "-", button=False),
)


class PacedDialog(Dialog):
    """Sets a faster emulator to x1 while open, and back unless it was changed meanwhile.

    The keys for an emulator's speed work here too.
    """

    def __init_subclass__(cls) -> None:
        cls.KEYS = (*cls.KEYS, *SPEED_KEYS)
        super().__init_subclass__()

    def __init__(self) -> None:
        super().__init__()
        self._pace = _Pace()

    def on_mount(self) -> None:
        super().on_mount()
        self.submit(PACE, self._pace.slow)

    def on_unmount(self) -> None:
        conductor = self.station_app.conductor
        if conductor is not None:
            conductor.submit(PACE, self._pace.restore)


class _Pace:
    def __init__(self) -> None:
        self._before: float | None = None

    def slow(self, station: Station) -> float | None:
        emulation = station.tracker.emulation
        if emulation is None:
            return None
        speed = emulation.speed()
        if speed <= 1.0:
            return speed
        self._before = speed
        return emulation.set_speed(1.0)

    def restore(self, station: Station) -> float | None:
        emulation = station.tracker.emulation
        if emulation is None:
            return None
        if self._before is None or emulation.speed() != 1.0:
            return emulation.speed()
        return emulation.set_speed(self._before)
