"""Recompute: another saved session's coefficients and plots, the running one left alone.

The newest file is open at once; Space steps through the names just below the title, Enter opens;
any other file is opened by its path.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Container
from textual.widget import Widget
from textual.widgets import Static

from solarcal.config import sessions_dir
from solarcal.decimals import counted
from solarcal.errors import FitError, SolarcalError, harmless
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.solution import Solution
from solarcal.model.verdict import base_and_shims
from solarcal.report.blocks import Block, Prose, lines_of
from solarcal.report.judgement import coefficients_table, fit_summary, shims_blocks
from solarcal.report.tables import points_table
from solarcal.session.view import SessionView, read_session
from solarcal.station.fitting import last_doubts, solve
from solarcal.station.saved_sessions import session_files
from solarcal.tui.base import StationScreen, Workstation, show_once
from solarcal.tui.dialogs.dialog import Dialog
from solarcal.tui.keys import DialogKey
from solarcal.tui.widgets.footer import ActionFooter, FooterEntry
from solarcal.tui.widgets.lines import Field, NoticeLine
from solarcal.tui.widgets.plot import PLOTS, ExploredPlot
from solarcal.tui.widgets.text_lines import ENDLESS, TextLines

HIGH = 40


def open_screen(app: Workstation) -> None:
    show_once(app, RecomputeScreen, lambda: RecomputeScreen(_files(app)))


def _files(app: Workstation) -> tuple[Path, ...]:
    """Saved sessions, newest first, and those beside the running one."""
    folders = {sessions_dir().resolve()}
    if app.line is not None and app.line.path.name:
        folders.add(app.line.path.resolve().parent)
    return tuple(session_files(folders))


@dataclass(frozen=True, slots=True)
class Recomputed:
    """A file read and fitted, or why not."""

    path: Path
    session: SessionView | None = None
    solution: Solution | None = None
    trouble: str = ""
    warnings: tuple[str, ...] = ()


def recompute(path: Path) -> Recomputed:
    """Read and fit one session file; takes a while, touches nothing."""
    try:
        session = read_session(path)
        trouble, solution = "", None
        try:
            solution = solve(session)
            doubts = last_doubts(session, solution)
        except FitError as error:
            trouble, doubts = str(error), ()
    except SolarcalError as error:
        return Recomputed(path, trouble=str(error))
    return Recomputed(path, session, solution, trouble, (*session.warnings, *doubts))


class PathDialog(Dialog):
    """One path, typed or pasted; it is left with a file that is a session."""

    HEADING = "Recompute a file"
    KEYS: ClassVar[tuple[DialogKey, ...]] = (DialogKey("read", "Open", "enter", "Enter"),)
    AUTO_FOCUS = "Input"
    FIRST_WORDS = "Type or paste the path of a session file (.jsonl). F12 or Ctrl+S stops."

    DEFAULT_CSS = """
    PathDialog Field > .label { width: 14; }
    PathDialog Field > Input { max-width: 100%; }
    """

    def __init__(self, show: Callable[["Recomputed"], None]) -> None:
        super().__init__()
        self._show = show

    def body(self) -> Iterable[Widget]:
        yield Field("path", "Session file")

    def on_input_submitted(self) -> None:
        self.action_read()

    def action_read(self) -> None:
        # A file manager pastes a path in quotes.
        typed = self.query_one(Field).value.strip("'\"")
        if typed:
            self.say("reading ...")
            self.compute(partial(recompute, Path(typed).expanduser()), self._read)

    def _read(self, found: "Recomputed") -> None:
        if found.session is None:
            self.say(found.trouble, "error")
            return
        self.dismiss(None)
        self._show(found)


class RecomputeScreen(StationScreen):
    """The session that runs is not touched: its screens stay up to date behind this one."""

    DEFAULT_CSS = """
    RecomputeScreen #title { height: 1; text-style: bold; background: $panel; color: $accent; }
    RecomputeScreen #file { height: 1; background: $boost; text-style: bold; }
    RecomputeScreen #found { layout: vertical; height: 1fr; }
    RecomputeScreen #table { height: 10; }
    RecomputeScreen.-high #table { height: 19; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "step(1)", "Next file", show=False, priority=True),
        Binding("backspace", "step(-1)", "File before", show=False, priority=True),
        Binding("enter", "open", "Open", show=False, priority=True),
        Binding("a,ctrl+o", "path", "Path of a file", show=False, priority=True),
        Binding("v", "plot", "Next plot", show=False, priority=True),
        Binding("escape", "back", "Back", show=False),
    ]
    AUTO_FOCUS = ""

    def __init__(self, files: tuple[Path, ...]) -> None:
        super().__init__()
        self._files = files
        self._at = 0
        self._plot = 0
        self._shown: Recomputed | None = None

    def compose(self) -> ComposeResult:
        yield Static(
            "RECOMPUTE  coefficients and plots of a saved session", id="title", markup=False
        )
        yield Static("", id="file", markup=False)
        with Container(id="found"):
            yield TextLines(id="table", wrap=True)
            yield ExploredPlot(id="plot")
        yield NoticeLine()
        yield ActionFooter(
            [
                FooterEntry("Spc", "Next", "screen.step(1)"),
                FooterEntry("BkSp", "Prev", "screen.step(-1)"),
                FooterEntry("Ent", "Open", "screen.open"),
                FooterEntry("a", "Path", "screen.path"),
                FooterEntry("v", "Plot", "screen.plot"),
                FooterEntry("Esc", "Back", "screen.back"),
            ]
        )

    def on_mount(self) -> None:
        """The newest file is opened at once; the others wait for Enter."""
        self._name_file()
        if self._files:
            self.action_open()
        else:
            self.query_one(TextLines).show(
                (f"No saved sessions in {sessions_dir()}.", "a opens any other file.")
            )

    def on_resize(self) -> None:
        self.set_class(self.app.size.height >= HIGH, "-high")

    # -- keys --------------------------------------------------------------------------------

    def action_step(self, by: int) -> None:
        if self._files:
            self._at = (self._at + by) % len(self._files)
            self._name_file()

    def action_open(self) -> None:
        if not self._files:
            return
        self._name_file("reading ...")
        self.compute(partial(recompute, self._files[self._at]), self._found)

    def action_path(self) -> None:
        self.app.push_screen(PathDialog(self._opened))

    def action_plot(self) -> None:
        self._plot = (self._plot + 1) % len(PLOTS)
        self._draw()

    # -- showing -----------------------------------------------------------------------------

    def _opened(self, found: Recomputed) -> None:
        """A file by its path stands before those that are listed."""
        self._files = (found.path, *(path for path in self._files if path != found.path))
        self._at = 0
        self._found(found)

    def _found(self, found: Recomputed) -> None:
        self._shown = found
        self._name_file()
        self.query_one(TextLines).show(_lines(found))
        self._draw()

    def _name_file(self, doing: str = "") -> None:
        if not self._files:
            self.query_one("#file", Static).update("no file")
            return
        path = self._files[self._at]
        opened = self._shown is not None and self._shown.path == path
        state = doing or ("OPEN" if opened else "Enter opens it")
        self.query_one("#file", Static).update(
            f"{harmless(path.name)}   ({self._at + 1} of {len(self._files)}, {state})"
        )

    def _draw(self) -> None:
        shown = self._shown
        if shown is None or shown.session is None:
            return
        plot = self.query_one(ExploredPlot)
        plot.show_plot(PLOTS[self._plot], shown.session, shown.solution)


def _lines(found: Recomputed) -> list[str]:
    said = [*found.warnings, *([found.trouble] if found.trouble else [])]
    # The file is named above; its folder would push what is wrong with it off the screen.
    lines = [text.replace(str(found.path), found.path.name) for text in said]
    blocks: list[Block] = []
    if found.solution is not None:
        blocks += [coefficients_table(found.solution), *fit_summary(found.solution)]
        if isinstance(found.solution, MechanismSolution) and found.session is not None:
            circle = found.session.header.bolt_circle
            blocks += shims_blocks(*base_and_shims(found.solution, circle))
    if found.session is not None:
        if found.solution is None and not found.trouble:
            few = f"{counted(len(found.session.accepted), 'accepted point')}: too few for a fit."
            blocks.append(Prose((few,)))
        blocks.append(Prose(("",)))
        blocks += points_table(found.session, found.solution)
    return [*lines, *lines_of(*blocks, width=ENDLESS)]
