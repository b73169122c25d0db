"""What the line says now: clocks, Sun, axes, limits, update cycle, mode. The title has the link."""

from textual.content import Content

from solarcal.session.records import Header
from solarcal.session.view import SessionView
from solarcal.station.question_evidence import ago_text
from solarcal.station.state import LiveView, StationState
from solarcal.station.sun_path import SunNow, sun_now
from solarcal.timescale import clock_face, format_utc, second_of_day
from solarcal.tui.widgets.text_lines import TextLines
from solarcal.unit.tracker import Status
from solarcal.units import format_degrees


def limit_bar(low: float, high: float, value: float, width: int) -> str:
    """Where a read-out stands between its limits: ``├──●─────┤``, the mark outside when beyond."""
    inside = max(1, width - 2)
    share = (value - low) / (high - low)
    place = round(share * (inside - 1))
    if share < 0.0:
        return "●" + "─" * inside + "┤"
    if share > 1.0:
        return "├" + "─" * inside + "●"
    return "├" + "─" * place + "●" + "─" * (inside - 1 - place) + "┤"


def phase_bar(phase: float, width: int) -> str:
    """How far the update cycle is, 0 just after an update, 1 when the next one is due."""
    full = round(min(max(phase, 0.0), 1.0) * width)
    return "█" * full + "░" * (width - full)


Part = str | tuple[str, str]
COLUMN = 17


class LivePane(TextLines):
    """Fifteen lines, written anew with every status; they scroll where a notice needs the room."""

    DEFAULT_CSS = """
    LivePane { width: 1fr; height: 15; padding: 0 1; overflow-x: hidden; }
    """

    def show_state(self, state: StationState) -> None:
        self.show([Content.assemble(*line) for line in live_lines(state)])


def live_lines(state: StationState) -> list[list[Part]]:
    """The pane's lines as parts with styles."""
    live, session = state.live, state.session
    if session is None:
        return []
    sun = sun_now(session, live)
    return [*_clocks(session.header, live, sun), *_suns(sun), *_unit(session, live)]


def _unit(session: SessionView, live: LiveView) -> list[list[Part]]:
    status = live.status
    if status is None:
        return _recorded(session)
    if not live.capabilities.has_link:
        return _typed(session.header, status, live.laptop_utc_s)
    return _axes(session.header, status)


def _clocks(header: Header, live: LiveView, sun: SunNow | None) -> list[list[Part]]:
    if live.laptop_utc_s is None:
        return [["UTC     -"], ["Local   -"]]
    utc = format_utc(live.laptop_utc_s, 0)
    local = second_of_day(live.laptop_utc_s - 3600.0 * header.unit.zone_west_h)
    solar = clock_face(sun.solar_time_h * 3600.0) if sun is not None else "-"
    difference: list[Part] = []
    if live.unit_minus_laptop_s is not None:
        seconds = round(live.unit_minus_laptop_s, 1)
        style = "bold $warning" if abs(seconds) > 1.0 else ""
        shown = f"{seconds:+z.1f} s" if abs(seconds) < 1e4 else f"{seconds / 3600.0:+z.2f} h"
        difference = ["  unit - laptop ", (shown, style)]
    return [
        [f"UTC     {utc[:10]} ", (utc[11:19], "bold"), *difference],
        [f"Local   {local}   apparent solar time {solar}"],
    ]


def _suns(sun: SunNow | None) -> list[list[Part]]:
    if sun is None:
        return [["Sun     -"], [""]]
    lines: list[list[Part]] = [
        [f"Sun     true  az {sun.azimuth_deg:8.3f}  el {sun.elevation_deg:z7.3f}"]
    ]
    if sun.apart_deg is None:
        return [*lines, [""]]
    style = "bold $warning" if sun.apart_deg > 0.1 else ""
    lines.append(
        [
            f"        unit  az {sun.unit_azimuth_deg:8.3f}  el {sun.unit_elevation_deg:z7.3f}  ",
            (f"diff. {sun.apart_deg:.3f}", style),
        ]
    )
    return lines


def _pair(name: str, texts: tuple[str, str], styles: tuple[str, str] = ("", "")) -> list[Part]:
    return [
        f"{name:8}",
        (f"{texts[0]:>{COLUMN}}", styles[0] or "$axis1"),
        "   ",
        (f"{texts[1]:>{COLUMN}}", styles[1] or "$axis2"),
    ]


def _degrees(name: str, first: float, second: float) -> list[Part]:
    return _pair(name, (format_degrees(first), format_degrees(second)))


def _motion(sense: int, came_from: int) -> str:
    if sense:
        return "moving up +" if sense > 0 else "moving down -"
    return {1: "at rest, came +", -1: "at rest, came -", 0: "at rest"}[came_from]


def _heading() -> list[Part]:
    return _pair("", ("● axis 1, deg", "◆ axis 2, deg"), ("bold $axis1", "bold $axis2"))


def _recorded(session: SessionView) -> list[list[Part]]:
    """Without a status, where the axes stood at the newest Set Sun Offset of the file."""
    if not session.sun_offsets:
        return [_heading(), ["no status from the unit"]]
    newest = session.sun_offsets[-1]
    return [
        _heading(),
        _degrees("ideal", *newest.ideal_deg),
        _degrees("reading", *newest.reading_deg),
        _pair("counts", (str(newest.counts[0]), str(newest.counts[1]))),
        _degrees("offset", newest.offsets.O1, newest.offsets.O2),
        *_limit_bars(session.header, newest.reading_deg),
        [
            f"as at the Set Sun Offset of {second_of_day(newest.utc)} UTC; "
            "no status from the unit now"
        ],
    ]


def _axes(header: Header, status: Status) -> list[list[Part]]:
    to_go1 = status.target1_deg - status.reading1_deg
    to_go2 = status.target2_deg - status.reading2_deg
    return [
        _heading(),
        _degrees("ideal", status.ideal1_deg, status.ideal2_deg),
        _degrees("target", status.target1_deg, status.target2_deg),
        _degrees("reading", status.reading1_deg, status.reading2_deg),
        _degrees("to go", to_go1, to_go2),
        _pair("counts", (str(status.counts1), str(status.counts2))),
        _degrees("offset", status.offsets.O1, status.offsets.O2),
        _pair(
            "motion",
            (
                _motion(status.moving[0], status.approach[0]),
                _motion(status.moving[1], status.approach[1]),
            ),
        ),
        *_limit_bars(header, status.reading_deg),
        [
            f"{'mode':8} ",
            (f"{status.mode:7}", "bold"),
            f" update {phase_bar(status.update_phase, 12)} {100.0 * status.update_phase:3.0f} %"
            + ("" if status.referenced else "  NO REF CHECK"),
        ],
    ]


def _typed(header: Header, status: Status, laptop_utc_s: float | None) -> list[list[Part]]:
    """A unit without a connection: what was typed last, its age, and where the unit should be."""
    lines: list[list[Part]] = [
        _heading(),
        _degrees("Sun now", status.ideal1_deg, status.ideal2_deg),
        _degrees("expected", status.target1_deg, status.target2_deg),
    ]
    at_s = status.typed_utc_s
    if at_s is None:
        lines += [["typed     nothing yet of the axes"], [""]]
    else:
        lines += [
            _degrees("typed", status.reading1_deg, status.reading2_deg),
            _pair("counts", (str(status.counts1), str(status.counts2))),
        ]
    came = {1: "came +", -1: "came -", 0: "not known"}
    age = ""
    if at_s is not None and laptop_utc_s is not None:
        age = f"typed as read at {second_of_day(at_s)} UTC, {ago_text(laptop_utc_s - at_s)}"
    return [
        *lines,
        _degrees("offset", status.offsets.O1, status.offsets.O2),
        _pair("approach", (came[status.approach[0]], came[status.approach[1]])),
        *_limit_bars(header, (status.target1_deg, status.target2_deg)),
        [age],
        [("No connection to this unit. STOP: press STOP on the UNIT.", "bold $warning")],
    ]


def _limit_bars(header: Header, reading_deg: tuple[float, float]) -> list[list[Part]]:
    limits = header.unit.limits
    lines: list[list[Part]] = []
    for name, axis, reading, tone in (
        ("limits 1", limits.axis1, reading_deg[0], "$axis1"),
        ("limits 2", limits.axis2, reading_deg[1], "$axis2"),
    ):
        distance = axis.distance_deg(reading)
        warn = "bold $error" if distance < 1.0 else ""
        lines.append(
            [
                f"{name:8} {axis.low_deg:z7.1f} ",
                (limit_bar(axis.low_deg, axis.high_deg, reading, 21), tone),
                f" {axis.high_deg:<-z6.1f} ",
                (f"{distance:.1f} left" if distance >= 0.0 else "BEYOND", warn),
            ]
        )
    return lines
