"""``solarcal report``: a calibration on paper, and the zip for the office."""

import argparse
from pathlib import Path

from solarcal.cli.fit import add_method_option, add_point_options, add_tolerance_option, fill_in
from solarcal.cli.output import print_json, say

HELP = "certificate of saved sessions or points, as .html, .md, .svg or .txt"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="OUT", help="the certificate to write"
    )
    parser.add_argument(
        "--zip",
        action="store_true",
        help="beside it a zip for the office: certificate, files, profile, checksums",
    )
    add_method_option(parser)
    add_tolerance_option(parser)
    add_point_options(parser)
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    from solarcal.errors import ConfigurationError
    from solarcal.report.certificate import (
        WRITERS,
        SourceFile,
        certificate_text,
        make_certificate,
        read_sources,
        signed_off,
    )
    from solarcal.report.office import office_zip
    from solarcal.station.judged_files import judge_files

    ending = args.output.suffix.lower()
    if ending not in WRITERS:
        raise ConfigurationError(
            f"{args.output}: a certificate is written as {', '.join(WRITERS)}; choose by the ending"
        )
    sources = read_sources(args.files)
    judged = judge_files(
        args.files, fill_in(args), method=args.method, tolerance_deg=args.tolerance
    )
    if read_sources(args.files) != sources:
        raise ConfigurationError(
            "a session was written to meanwhile; the certificate would not match its checksum: "
            "run this again"
        )
    text = certificate_text(make_certificate(judged, sources), ending)
    certificate = SourceFile(args.output.name, text.encode())
    written = [(args.output, certificate.content)]
    if args.zip:
        archive = office_zip(certificate, sources, judged.header)
        written.append((args.output.with_suffix(".zip"), archive))
    for path, content in written:
        _write(path, content)
    after = signed_off(judged)
    judgement = judged.of_the_controller()
    if args.json:
        print_json(
            {
                "files": [path.name for path in args.files],
                "certificate": str(args.output),
                "sha256": certificate.sha256,
                "zip": str(written[1][0]) if args.zip else None,
                "signed_off": after.signed_off,
                "reason": after.reason,
                "verdict": judgement.verdict.as_json(),
            }
        )
        return 0
    for warning in judged.fitted.warnings:
        say(f"warning: {warning}")
    state = "signed off" if after.signed_off else "not signed off"
    print("\n".join([*(f"wrote {path}" for path, _ in written), f"{state}: {after.reason}"]))
    return 0


def _write(path: Path, content: bytes) -> None:
    """Whole or not at all; an older certificate of the name is replaced."""
    from solarcal.errors import ConfigurationError

    beside = path.with_name(f".{path.name}.part")
    try:
        beside.write_bytes(content)
        beside.replace(path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise ConfigurationError(f"{path} cannot be written: {error.strerror}") from None
