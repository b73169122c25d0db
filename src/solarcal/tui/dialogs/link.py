"""The line to the unit: how it is, who answers, reconnect now, what went over it."""

from collections.abc import Iterable
from typing import ClassVar

from textual.widget import Widget

from solarcal.session.records import LinkLost, LinkRestored
from solarcal.station.news import Progress, Reconnected
from solarcal.station.state import LinkState, StationState
from solarcal.tui.base import Workstation, is_typed
from solarcal.tui.dialogs.dialog import Dialog, DialogKey, open_dialog
from solarcal.tui.widgets.lines import Words
from solarcal.tui.widgets.text_lines import TextLines

TRAFFIC_EVERY_S = 0.5


def open_screen(app: Workstation) -> None:
    open_dialog(app, LinkDialog())
    if app.state.live.link is LinkState.LOST:
        app.station_worker().reconnect_now()


class LinkDialog(Dialog):
    HEADING = "Link"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (
        DialogKey("reconnect", "Reconnect now", "enter,r", "Enter r"),
    )

    DEFAULT_CSS = """
    LinkDialog #link { height: auto; margin-bottom: 1; }
    LinkDialog #traffic { height: 9; border-top: solid $primary; }
    """

    def body(self) -> Iterable[Widget]:
        yield Words("", id="link", markup=False)
        yield TextLines(id="traffic", follow=True)

    def on_mount(self) -> None:
        super().on_mount()
        traffic = self.query_one("#traffic")
        traffic.border_title = (
            "Typed last"
            if is_typed(self.workstation)
            else "Last over the line (> sent, < received)"
        )
        self.set_interval(TRAFFIC_EVERY_S, self._show_traffic)
        self._show_traffic()

    def action_reconnect(self) -> None:
        if self._lost:
            self.say("Trying now ...")
            self.worker.reconnect_now()
        else:
            self.say("The link is up; nothing to reconnect.")

    def state_changed(self, state: StationState) -> None:
        live = state.live
        who = live.identity
        state_words = _words(live.link)
        if is_typed(self.workstation):
            state_words = "no line: what the unit's display shows is typed"
        lines = [f"State     {state_words}"]
        if who is not None:
            emulated = ", an EMULATOR" if live.capabilities.emulated else ""
            lines.append(f"Unit      {who.model} {who.serial}, firmware {who.firmware}{emulated}")
        if kept := live.capabilities.kept_by_station:
            lines.append(f"Station   {kept}")
        line = self.workstation.line
        if line is not None and line.choice.port:
            lines.append(f"Port      {line.choice.port} ({line.choice.driver})")
        session = state.session
        if session is not None:
            counted = live.losses_unrecorded + sum(
                r.losses for r in session.records if isinstance(r, LinkRestored)
            )
            lost = counted + sum(isinstance(r, LinkLost) for r in session.records)
            back = lost - (live.link is LinkState.LOST)
            lines.append(f"Recorded  lost {lost} times, restored {back} times in this session")
        if live.link is LinkState.LOST:
            lines.append(f"Reason    {live.link_message}")
        self.query_one("#link", Words).update("\n".join(lines))
        self.offer(*(["reconnect"] if live.link is LinkState.LOST else []))

    def show_progress(self, progress: Progress) -> None:
        if progress.kind is Reconnected and self._lost:
            self.say(f"LINK LOST: {progress.words}.", "error")

    def _show_traffic(self) -> None:
        self.query_one(TextLines).show(self.worker.station.tracker.recent_traffic())


def _words(link: LinkState) -> str:
    return {
        LinkState.CONNECTED: "CONNECTED",
        LinkState.LOST: "LOST; it reconnects automatically, with growing pauses",
        LinkState.CLOSED: "closed",
    }[link]
