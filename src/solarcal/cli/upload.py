"""``solarcal upload``: the coefficients of a session into its unit, read back and compared."""

import argparse
from pathlib import Path

from solarcal.cli.fit import add_method_option
from solarcal.cli.output import print_json
from solarcal.cli.unit_options import add_unit_options, asked_tracker, port_words
from solarcal.errors import ConfigurationError
from solarcal.report.blocks import text_of

HELP = "write the fit of a session into its unit, read back, compare"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="session file (.jsonl)")
    add_unit_options(parser)
    add_method_option(parser)
    add_force_option(parser)
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def add_force_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--force",
        metavar="REASON",
        help="upload although the points do not fit, or are no better than what is in force; "
        "written to the file",
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


def run(args: argparse.Namespace) -> int:
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
        print(f"\nRecorded in {args.file} as {record.seq}; `solarcal rollback` restores the old.")
    return 0 if record.verified else 1


def demand_session(path: Path) -> None:
    """An upload belongs to a session: only there can it be recorded."""

    if path.suffix.lower() != ".jsonl":
        raise ConfigurationError(
            f"{path}: uploads are recorded in the session file they come from; name a .jsonl"
        )
