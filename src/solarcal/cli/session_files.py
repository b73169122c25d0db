"""Session files: made of points (``import``), written out (``export``), ``note`` and ``void``."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.cli.fit import add_point_options, fill_in
from solarcal.cli.process import (
    add_json_option,
    add_replace_option,
    print_json,
    refuse_to_replace,
    warn,
)
from solarcal.decimals import counted, whole_option
from solarcal.errors import ConfigurationError, one_line
from solarcal.timescale import SystemClock, format_utc

if TYPE_CHECKING:
    from solarcal.session.points import PointTable


def add_import_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="IN", help="points .csv, TPOINT .dat or session .jsonl")
    parser.add_argument("target", metavar="OUT.jsonl", help="the new session file")
    add_point_options(parser)
    add_json_option(parser)


def run_import(args: argparse.Namespace) -> int:
    from solarcal.session.interchange import read_table, session_from_table
    from solarcal.station.analysing import stamp_findings

    if Path(args.target).suffix.lower() != ".jsonl":
        raise ConfigurationError(f"{args.target}: a session file ends in .jsonl")
    table = read_table(args.source, **fill_in(args))
    session = session_from_table(table, args.target, utc_s=SystemClock().utc_s())
    warnings = [*table.warnings, *(finding.sentence for finding in stamp_findings(table))]
    return _told(args, "session", table, warnings, list(session.header.unknown))


def _told(
    args: argparse.Namespace,
    target: str,
    table: "PointTable",
    warnings: list[str],
    unknown: list[str] | None = None,
) -> int:
    """Print what was written: points by their status, and what there is to warn of; 0."""
    from solarcal.session.points import STATUSES

    counts = {"total": len(table), **{status: table.count(status) for status in STATUSES}}
    if args.json:
        print_json(
            {
                "source": args.source,
                target: args.target,
                "geometry": table.geometry,
                "points": counts,
                **({} if unknown is None else {"unknown": unknown}),
                "warnings": warnings,
            }
        )
        return 0
    warn(warnings)
    if unknown:
        warn([f"the {' and '.join(unknown)} is not known (--lat, --lon)"])
    points = counted(counts["total"], "point")
    print(one_line(f"{points} ({counts['accepted']} accepted) in {args.target}"))
    return 0


def add_export_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="IN.jsonl", help="session file (or .csv, .dat)")
    parser.add_argument("target", metavar="OUT", help="points .csv, or TPOINT .dat (azel only)")
    add_replace_option(parser)
    add_json_option(parser)


def run_export(args: argparse.Namespace) -> int:
    from solarcal.session.interchange import read_table, write_table

    target = Path(args.target)
    refuse_to_replace(args, target)
    table = read_table(args.source)
    write_table(table, target)
    warnings = list(table.warnings)
    if target.suffix.lower() == ".dat" and table.ideal != "apparent":
        warnings.append(
            f"TPOINT cannot record that the angles are {table.ideal}: a fit of {target} takes them "
            "for the Sun's true place; a .csv records it"
        )
    return _told(args, "target", table, warnings)


def add_note_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="session file (.jsonl)")
    parser.add_argument("text", metavar="TEXT", help="the remark")
    add_json_option(parser)


def run_note(args: argparse.Namespace) -> int:
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


def add_void_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="session file (.jsonl)")
    parser.add_argument(
        "seq", metavar="SEQ", type=whole_option(), help="sequence number of the record"
    )
    parser.add_argument(
        "--reason", metavar="TEXT", required=True, help="reason; recorded in the file"
    )
    add_json_option(parser)


def run_void(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.session.records import Void
    from solarcal.session.view import contradictions, view_session
    from solarcal.session.voids import refuse_void

    reason = args.reason.strip()
    if not reason:
        raise ConfigurationError("--reason is empty; say why the record is struck")
    with Journal.resume(args.file) as journal:
        header = journal.header
        refuse_void(header, journal.records, args.seq)
        known = set(contradictions(view_session(header, tuple(journal.records)), args.file))
        seq = journal.next_seq
        utc = format_utc(SystemClock().utc_s())
        journal.append(Void(seq=seq, utc=utc, voids=args.seq, reason=reason))
        said = contradictions(view_session(header, tuple(journal.records)), args.file)
        warnings = [one for one in said if one not in known]
    if args.json:
        document = {"file": args.file, "seq": seq, "utc": utc, "voids": args.seq, "reason": reason}
        print_json({**document, "warnings": warnings})
    else:
        warn(warnings)
        print(f"record {args.seq} is void; to undo: solarcal void {args.file} {seq} --reason ...")
    return 0
