"""``solarcal void``: strike a record of a session file."""

import argparse

from solarcal.cli.output import print_json
from solarcal.decimals import whole_option
from solarcal.errors import ConfigurationError
from solarcal.timescale import SystemClock, format_utc

HELP = "strike a record of a session (undone by voiding the void)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="session file (.jsonl)")
    parser.add_argument(
        "seq", metavar="SEQ", type=whole_option(), help="sequence number of the record"
    )
    parser.add_argument("--reason", metavar="TEXT", required=True, help="why; written to the file")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.session.reader import refuse_void
    from solarcal.session.records import Void

    reason = args.reason.strip()
    if not reason:
        raise ConfigurationError("--reason is empty; say why the record is struck")
    with Journal.resume(args.file) as journal:
        refuse_void(journal.header, journal.records, args.seq)
        seq = journal.next_seq
        utc = format_utc(SystemClock().utc_s())
        journal.append(Void(seq=seq, utc=utc, voids=args.seq, reason=reason))
    if args.json:
        document = {"file": args.file, "seq": seq, "utc": utc, "voids": args.seq, "reason": reason}
        print_json(document)
    else:
        print(f"record {args.seq} is void; to undo: solarcal void {args.file} {seq} --reason ...")
    return 0
