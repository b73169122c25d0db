"""Write the tables of requests in docs/protocol.md anew: ``python -m tools.protocol_page``."""

import re
from pathlib import Path

from solarcal.unit.values import KINDS
from solarcal.unit.verbs import VERBS, Verb

PAGE = Path(__file__).resolve().parent.parent / "docs" / "protocol.md"
HEAD = "| request | reply fields | does |\n|---|---|---|\n"


def table(emulator_only: bool) -> str:
    """The rows of the unit's requests, or of the emulator's own."""
    rows, seen = "", dict[str, str]()
    for verb in VERBS:
        if verb.request.startswith("X ") is emulator_only:
            rows += f"| {_request(verb)} | {_reply(verb, seen)} | {verb.does} |\n"
    return HEAD + rows


def page(text: str) -> str:
    """The page with its two tables as the descriptions have them."""
    tables = iter((table(False), table(True)))
    return re.sub(re.escape(HEAD) + r"(?:\|.*\n)*", lambda old: next(tables), text)


def _request(verb: Verb) -> str:
    return f"`{verb.request}`" + (" *" if verb.unlock else "")


def _reply(verb: Verb, seen: dict[str, str]) -> str:
    """Its fields, or the request that has the same, where they are many."""
    if len(verb.reply.split()) > 3 and verb.reply in seen:
        return f"as `{seen[verb.reply]}`"
    seen[verb.reply] = " ".join(word for word in verb.request.split() if word not in KINDS)
    return f"`{verb.reply}`" if verb.reply else ""


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
