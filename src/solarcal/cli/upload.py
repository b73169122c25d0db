"""``solarcal upload`` and ``solarcal rollback``: into a unit, read back, and out again."""

import argparse
from pathlib import Path

from solarcal.cli.fit import add_method_option
from solarcal.cli.process import add_json_option, print_json, say
from solarcal.cli.unit_options import add_unit_options, asked_tracker, port_words
from solarcal.config import sessions_dir
from solarcal.errors import ConfigurationError, ProcedureRefused
from solarcal.report.blocks import text_of


def add_upload_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="session file (.jsonl)")
    add_unit_options(parser)
    add_method_option(parser)
    add_force_option(parser)
    add_json_option(parser)


def add_force_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--force",
        metavar="REASON",
        help="upload although the points do not fit, or are no improvement; the reason is recorded",
    )


def forced_reason(args: argparse.Namespace) -> str | None:
    """The reason of ``--force``; None without it.

    Raises
    ------
    ConfigurationError
        It is empty.
    """
    if args.force is None:
        return None
    if not args.force.strip():
        raise ConfigurationError("--force is empty; say why the upload is right all the same")
    return str(args.force.strip())


def run_upload(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.station.analysing import analyse_files, read_files
    from solarcal.station.uploading import UnitOnTheLine, offer_upload, refuse_doubtful

    force = forced_reason(args)
    demand_session(args.file)
    with Journal.resume(args.file) as journal:
        judged = analyse_files(read_files([args.file], {}), method=args.method)
        analysis = judged.of_the_controller()
        # Before the line is opened: what does not fit needs no unit to be refused.
        refuse_doubtful(offer_upload(analysis, journal.header.unit), force)
        with asked_tracker(args) as tracker:
            unit = UnitOnTheLine(tracker)
            unit.resume(journal)
            stored = unit.stored()
            offer = offer_upload(
                analysis, journal.header.unit, (stored.coefficients, stored.offsets)
            )
            forced = refuse_doubtful(offer, force)
            record = unit.upload(offer.rounded, judged.solution.method, forced)
    if args.json:
        from solarcal.station.documents import offer_document, upload_document

        print_json(
            {**upload_document(args.file, journal.header.unit, record), **offer_document(offer)}
        )
    else:
        from solarcal.report.judgement import rounding_blocks, verdict_blocks
        from solarcal.report.tables import upload_table

        print(f"Unit {journal.header.unit.model} {journal.header.unit.serial}{port_words(args)}\n")
        print(text_of(*verdict_blocks(offer.judgement.verdict)), end="\n\n")
        print(text_of(*rounding_blocks(offer)), end="\n\n")
        print(text_of(*upload_table(record)))
        print(
            f"\nRecorded in {args.file} as {record.seq}; `solarcal rollback` restores the "
            "previous ones."
        )
    return 0 if record.verified else 1


def demand_session(path: Path) -> None:
    """An upload belongs to a session: only there can it be recorded."""
    if path.suffix.lower() != ".jsonl":
        raise ConfigurationError(
            f"{path}: uploads are recorded in the session file they come from; name a .jsonl"
        )


def add_rollback_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="session file with the upload; default: the newest one in the sessions folder",
    )
    add_unit_options(parser)
    add_json_option(parser)


def run_rollback(args: argparse.Namespace) -> int:
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
