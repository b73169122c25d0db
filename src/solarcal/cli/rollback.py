"""``solarcal rollback``: the coefficients a unit held before its newest upload."""

import argparse
from pathlib import Path

from solarcal.cli.output import print_json, say
from solarcal.cli.unit_options import add_unit_options, asked_tracker, port_words
from solarcal.cli.upload import demand_session
from solarcal.config import sessions_dir
from solarcal.errors import ProcedureRefused
from solarcal.report.blocks import text_of

HELP = "restore what the newest upload to a unit replaced"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="session file with the upload; default: the newest one in the sessions folder",
    )
    add_unit_options(parser)
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.session.view import view_session
    from solarcal.station.state import newest_upload
    from solarcal.station.uploading import UnitOnTheLine, find_upload

    if args.file is not None:
        demand_session(args.file)
    with asked_tracker(args) as tracker:
        unit = UnitOnTheLine(tracker)
        path = args.file
        if path is None:
            path, unreadable = find_upload(sessions_dir(), unit.identity)
            for sentence in unreadable:
                say(f"passed over: {sentence}")
        with Journal.resume(path) as journal:
            replaced = newest_upload(view_session(journal.header, tuple(journal.records)).uploads)
            if replaced is None:
                raise ProcedureRefused(f"there is no upload in {path} to roll back")
            unit.resume(journal)
            if unit.stored().coefficients != replaced.new_coefficients:
                say(
                    f"the unit holds other coefficients than upload {replaced.seq} of {path} "
                    "wrote; they are in the record of this rollback"
                )
            record = unit.restore(replaced)
            header = journal.header
    if args.json:
        from solarcal.station.documents import upload_document

        print_json({**upload_document(path, header.unit, record), "restores": replaced.seq})
    else:
        from solarcal.report.tables import upload_table

        print(f"Unit {header.unit.model} {header.unit.serial}{port_words(args)}\n")
        print(text_of(*upload_table(record)))
        print(f"\nRecorded in {path} as {record.seq}.")
    return 0 if record.verified else 1
