"""``solarcal note``: add a remark to a session file."""

import argparse

from solarcal.cli.output import print_json
from solarcal.errors import ConfigurationError
from solarcal.timescale import SystemClock, format_utc

HELP = "add a remark to a session"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="session file (.jsonl)")
    parser.add_argument("text", metavar="TEXT", help="the remark")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.session.records import Note

    text = args.text.strip()
    if not text:
        raise ConfigurationError("the note is empty")
    with Journal.resume(args.file) as journal:
        seq = journal.next_seq
        utc = format_utc(SystemClock().utc_s())
        journal.append(Note(seq=seq, utc=utc, text=text))
    if args.json:
        print_json({"file": args.file, "seq": seq, "utc": utc, "text": text})
    else:
        print(f"noted as record {seq}")
    return 0
