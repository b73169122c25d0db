"""Time in a dialog: how long a drive still takes, and an emulator that is not faster than life."""

from solarcal.station.jogging import JogView
from solarcal.station.news import SpeedTold
from solarcal.station.procedure import Station
from solarcal.tui.dialogs.dialog import Dialog

SPEED_KNOWN_FROM = 0.02
"""Share of the way; before it the axes still gather speed, and an hour is foretold for seconds."""

FAR_DEG = 1.0
"""From so far on the drive of a jog is shown, with the time it takes."""


class DriveWatch:
    """How far a drive is and how long it still takes, from one look to the next."""

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None
        self.fraction = 0.0
        self.left_s: float | None = None

    def at(self, utc_s: float, to_go_deg: float) -> None:
        """``to_go_deg`` of the axis that has the longer way; more than before begins anew."""
        if self._first is None or to_go_deg > self._first[1]:
            self._first = (utc_s, to_go_deg)
        since_s, whole_deg = self._first
        driven_deg = whole_deg - to_go_deg
        self.fraction = driven_deg / whole_deg if whole_deg > 0.0 else 1.0
        self.left_s = None
        if driven_deg > SPEED_KNOWN_FROM * whole_deg and utc_s > since_s:
            self.left_s = to_go_deg * (utc_s - since_s) / driven_deg

    def words(self) -> str:
        """``, about 40 s`` once the speed is known."""
        return "" if self.left_s is None else f", about {self.left_s:.0f} s"

    def jog_words(self, view: JogView) -> str:
        """How far and how long the axes still drive, nothing where they are near."""
        status = view.status
        to_go = max(map(abs, status.off_target_deg))
        if to_go < FAR_DEG or status.moving == (0, 0):
            self._first = None
            return ""
        self.at(status.unit_utc_s, to_go)
        if view.aim is None:
            where = "to the Sun"
        else:
            where = "behind the Sun" if any(view.aim.behind) else "to the aim"
        return f"Driving {where}: {to_go:.0f} deg to go{self.words()}."


BAR_CELLS = 30


def progress_bar(fraction: float) -> str:
    """``[######....]  60 %``; nothing of it is shown by colour."""
    share = min(max(fraction, 0.0), 1.0)
    done = round(BAR_CELLS * share)
    return "[" + "#" * done + "." * (BAR_CELLS - done) + f"] {100.0 * share:3.0f} %"


LIFE = 1.0
FASTEST = 10.0
"""Beyond this a jog target expires before it is renewed, and a gathering cannot be watched."""


class PacedDialog(Dialog):
    """Sets a faster emulator to x1 while open, and back unless it was changed meanwhile.

    The keys for an emulator's speed work here within reason.
    """

    def __init__(self) -> None:
        super().__init__()
        self._before: float | None = None

    def on_mount(self) -> None:
        super().on_mount()
        speed = self.workstation.emulated_speed
        if speed is not None and speed > LIFE:
            self._before = speed
            self._pace(LIFE)

    def on_unmount(self) -> None:
        app = self.workstation
        if self._before is not None and app.emulated_speed == LIFE and app.worker is not None:
            self._pace(self._before)

    def action_faster(self) -> None:
        speed = self.workstation.emulated_speed
        if speed is not None and speed >= FASTEST:
            self.warn(f"No faster than x{FASTEST:g} while this is open.")
        else:
            super().action_faster()

    def _pace(self, speed: float) -> None:
        # At once, so that a key pressed before the unit has answered counts from here.
        self.workstation.emulated_speed = speed
        if self.is_running:
            self._show_speed()
        self.submit(SpeedTold, lambda station: _set_speed(station, speed))


def _set_speed(station: Station, speed: float) -> float | None:
    emulation = station.tracker.emulation
    return emulation.set_speed(speed) if emulation is not None else None
