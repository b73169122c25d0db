"""The pages say what is so: commands parse, links lead somewhere, keys are bound."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from solarcal.cli import COMMANDS, build_parser
from solarcal.model.terms import TERMS
from solarcal.report.judgement import meaning
from solarcal.tui.keys import ACTIONS, shown_key
from solarcal.unit.drivers import DRIVERS
from tools.man_page import PAGE as MAN_PAGE
from tools.man_page import man_page

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "sessions" / "README.md", *sorted(ROOT.glob("docs/*.md"))]
PICTURES = ROOT / "docs" / "pictures"
LARGEST_PICTURE_BYTES = 150_000
LARGEST_FILM_BYTES = 1_000_000

PROGRAM = re.compile(r"^(?:\$ )?(?:\.venv[/\\]bin[/\\]|\.venv\\Scripts\\)?solarcal(?= |$)")
PLACEHOLDERS = {"SEQ": "1", "N": "1"}
SHELL_KEYS = {"Ctrl+C", "Ctrl+Q"}
"""Ctrl+C ends the emulator of a shell; Ctrl+Q frees a terminal (and quits)."""


@cache
def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def code_lines(page: Path) -> list[str]:
    """Lines of code blocks, fenced or indented, continued lines joined."""
    lines, fenced = [], False
    for line in text_of(page).replace("\\\n", " ").splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            lines.append(line.strip())
    return lines


def spans(page: Path) -> list[str]:
    """Inline code, outside of fenced blocks."""
    prose = re.sub(r"^```.*?^```", "", text_of(page), flags=re.DOTALL | re.MULTILINE)
    return [span.replace("\\|", "|") for span in re.findall(r"`([^`\n]+)`", prose)]


def commands(page: Path) -> list[tuple[str, bool]]:
    """Command lines after ``solarcal``; True for those of code blocks, which must be complete."""
    found = []
    for lines, complete in ((code_lines(page), True), (spans(page), False)):
        for line in lines:
            if not PROGRAM.match(line):
                continue
            # Two spaces or a `#` begin a remark, `|` and `>` belong to the shell.
            line = re.split(r"\s{2,}(?![\\-])|\s#|\s[|>]\s", PROGRAM.sub("", line).strip())[0]
            found.append((line.strip(), complete))
    return found


def argv_of(line: str) -> list[str]:
    words = []
    for word in shlex.split(line.replace("FILE...", "FILE")):
        if word == "...":
            # More may follow, or the value before it is left to the reader.
            word = "TEXT" if words and words[-1].startswith("--") else ""
        if not word or word.startswith("[") or word.endswith("]"):
            continue
        words.append(PLACEHOLDERS.get(word, word))
    return words


def trouble(line: str, *, complete: bool) -> str:
    """What argparse has against a command line; empty for nothing."""
    argv = argv_of(line)
    if not argv or argv[0] == "COMMAND" or argv == ["--version"]:
        return ""
    name = next((word for word in argv if not word.startswith("-")), "")
    if name not in COMMANDS:
        return f"no command {name!r}"
    if argv == [name] and not complete:
        return ""
    try:
        build_parser(name).parse_args(argv)
    except SystemExit as end:
        return "" if end.code == 0 else "argparse refuses it"
    return ""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_line_parses(page, capsys):
    for line, complete in commands(page):
        said = trouble(line, complete=complete)
        assert not said, f"{page.name}: solarcal {line}: {said}\n{capsys.readouterr().err}"


def test_a_command_line_that_is_wrong_would_be_found(capsys):
    assert trouble("fit FILE --no-such-option", complete=True)
    assert trouble("fitt FILE", complete=True)
    assert trouble("void FILE", complete=True)
    assert not trouble("void FILE 3 --reason TEXT", complete=True)
    capsys.readouterr()


def test_every_command_is_documented():
    shown = {argv_of(line)[0] for page in PAGES for line, _ in commands(page) if argv_of(line)}
    assert set(COMMANDS) - shown == set()


def anchors(page: Path) -> set[str]:
    """The names by which headings can be linked to."""
    headings = re.findall(r"^#+ (.+)$", text_of(page), flags=re.MULTILINE)
    slugs = set()
    for heading in headings:
        words = re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower())
        slugs.add(words.replace(" ", "-"))
    return slugs


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        assert "://" not in target, f"{page.name}: {target} leaves the project"
        path, _, anchor = target.partition("#")
        to = (page.parent / path).resolve() if path else page
        assert to.exists(), f"{page.name}: {target} is not there"
        assert not anchor or anchor in anchors(to), f"{page.name}: no heading for {target}"


def test_every_page_is_in_the_index():
    index = text_of(ROOT / "docs" / "README.md")
    for page in ROOT.glob("docs/*.md"):
        assert page.name == "README.md" or f"]({page.name}" in index, page.name
    assert "](docs/README.md)" in text_of(ROOT / "README.md")


def test_every_key_named_is_bound():
    source = "".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "src/solarcal/tui").rglob("*.py")
    )
    bound = {key.lower() for action in ACTIONS for key in action.keys}
    bound |= set(re.findall(r"\b(?:alt|ctrl|shift)\+\w+", source)) | {"ctrl+p"}
    for page in PAGES:
        prose = text_of(page)
        for key in re.findall(r"\b(?:Alt|Ctrl|Shift)\+(?:F\d+|[A-Z])\b(?!-)|\bF\d{1,2}\b", prose):
            assert key in SHELL_KEYS or key.lower() in bound, f"{page.name}: {key}"


def test_the_table_of_keys_is_that_of_the_program():
    rows = {}
    for line in text_of(ROOT / "docs" / "workstation.md").splitlines():
        for ids, keys in re.findall(r"\| (`\w+`(?:, `\w+`)*) \| ([^|]+) ", line):
            names = re.findall(r"`(\w+)`", ids)
            parts = keys.split(",") if len(names) > 1 else [keys]
            rows |= dict(zip(names, parts, strict=True)) if names[0] in _IDS else {}
    for action in ACTIONS:
        named = set(rows[action.id].replace("`", "").split())
        written = {shown_key(key).replace("^", "Ctrl+") for key in action.keys}
        assert named == written - {"keypad ."}, action.id


_IDS = {action.id for action in ACTIONS}


def test_every_driver_is_in_the_page_on_hardware():
    page = text_of(ROOT / "docs" / "hardware.md")
    for driver in DRIVERS:
        assert f"`{driver}`" in page, driver


def test_the_film_of_the_demo_plays_every_frame_in_its_turn_and_fetches_nothing():
    """Each frame begins where the one before it ends; the last one stays to the end."""
    path = PICTURES / "demo.svg"
    text = path.read_text(encoding="utf-8")
    root = ElementTree.fromstring(text)
    frames = [g for g in root.iter("{http://www.w3.org/2000/svg}g") if g.get("class") == "f"]
    assert len(frames) >= 10
    assert not re.search(r"href|url\(|@import|<script|<image", text)
    ends = 0.0
    for number, frame in enumerate(frames):
        assert frame.get("style") == f"animation-name:f{number}"
        rule = re.search(rf"@keyframes f{number}\{{(.*?)\}}\}}", text)[1]
        seen = float(re.search(r"([\d.]+)%{visibility:visible", rule)[1])
        assert seen == ends, "no gap and no overlap"
        hidden = re.findall(r"([\d.]+)%{visibility:hidden", rule)
        ends = float(hidden[-1]) if number < len(frames) - 1 else 100.0
        assert ends > seen


def test_pictures_are_those_the_program_makes_and_all_are_used():
    scenes = (ROOT / "tools/pictures/scenes.py").read_text(encoding="utf-8")
    made = {
        name.replace("_", "-") for name in re.findall(r"^@scene\nasync def (\w+)", scenes, re.M)
    }
    assert {path.stem for path in PICTURES.glob("*.svg")} == made
    used = {
        Path(target).stem
        for page in PAGES
        for target in re.findall(r"\]\((\S+\.svg)\)", text_of(page))
    }
    assert used == made


@pytest.mark.parametrize("picture", sorted(PICTURES.glob("*.svg")), ids=lambda path: path.stem)
def test_a_picture_is_small_and_fetches_nothing(picture):
    svg = picture.read_text(encoding="utf-8")
    assert len(svg) < (LARGEST_FILM_BYTES if picture.stem == "demo" else LARGEST_PICTURE_BYTES)
    assert set(re.findall(r"https?://[^\"'\s<)]+", svg)) == {"http://www.w3.org/2000/svg"}
    for fetched in ("@font-face", "@import", "<image", "<use", "href", "url("):
        assert fetched not in svg


def test_the_client_of_the_protocol_page_speaks_the_protocol():
    page = text_of(ROOT / "docs" / "protocol.md")
    (example,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    client: dict[str, Any] = {}
    exec(example, client)
    shown = re.findall(r"^    ([<>][0-9A-F]{4} .*)$", page, re.MULTILINE)
    sent, received = shown[0::2], shown[1::2]
    for number, (ask, reply) in enumerate(zip(sent, received, strict=True), start=1):
        text = ask[6:].partition("*")[0]
        assert client["request"](number, text) == ask
        if " NO " in reply:
            with pytest.raises(RuntimeError, match="20 locked"):
                client["answer"](number, reply)
        else:
            assert client["answer"](number, reply) == reply[9:].partition("*")[0].split(" ")
            assert client["answer"](number, reply.replace("OK", "KO")) is None
            assert client["answer"](number + 1, reply) is None


def test_every_scenario_is_in_the_page_on_the_emulator():
    table = text_of(ROOT / "docs" / "emulator.md").partition("## Scenarios")[2].partition("###")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    assert {name for row in rows for name in re.findall(r"`([\w-]+)`", row)} == {
        path.stem for path in (ROOT / "src/solarcal/emulator/scenarios").glob("*.toml")
    }


def test_the_man_page_is_that_of_the_program(monkeypatch):
    """`make man` writes it anew."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    written, made = MAN_PAGE.read_text(encoding="utf-8"), man_page()
    if sys.version_info >= (3, 13):  # argparse lays out options with values in another way
        assert set(written.split()) == set(made.split())
    else:
        assert written == made


@pytest.mark.skipif(shutil.which("man") is None, reason="needs man")
def test_man_opens_the_page():
    shown = subprocess.run(
        ["man", "--warnings", "-l", str(MAN_PAGE)],
        env={"PATH": os.environ["PATH"], "MANWIDTH": "80", "LC_ALL": "C.UTF-8"},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert shown.stderr == ""
    plain = re.sub(".\x08", "", shown.stdout)
    for heading in ("NAME", "SYNOPSIS", "DESCRIPTION"):
        assert f"\n{heading}\n" in f"\n{plain}"
    for command in COMMANDS:
        assert f"solarcal {command}" in plain


def test_coefficients_of_the_examples_have_the_meaning_that_is_printed():
    row = re.compile(r"^(P[1-6]) +[+-][\d.]+ +[\d.]+ +deg\S* +(.+)$", re.MULTILINE)
    rows = [(page.name, *found) for page in PAGES for found in row.findall(text_of(page))]
    assert {page for page, _, _ in rows} >= {"README.md", "what-the-numbers-mean.md"}
    assert [one for one in rows if one[2] != meaning(TERMS[one[1]], "azel")] == []
