"""``solarcal fit``: coefficients from session, CSV or TPOINT files."""

import argparse
import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.cli.process import add_json_option, add_replace_option, print_json, refuse_to_replace
from solarcal.decimals import decimal, number_option, option_of, shortened
from solarcal.errors import ConfigurationError
from solarcal.report.blocks import section_text
from solarcal.stopping_rule import DEFAULT_UNMODELLED

if TYPE_CHECKING:
    from collections.abc import Callable

    from solarcal.decimals import Six
    from solarcal.session.interchange import FillIn
    from solarcal.site import BoltCircle
    from solarcal.station.analysing import UnitFiles
    from solarcal.station.judging import Judging, RuleChanges


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_judging_arguments(parser)
    parser.add_argument(
        "--terms", metavar="P1,P2,...", help="error terms to fit; default the six coefficients"
    )
    parser.add_argument(
        "--compare", type=Path, metavar="MODEL.mod", help="compare with a published TPOINT model"
    )
    parser.add_argument(
        "--write-model",
        type=Path,
        metavar="OUT.mod",
        help="write the fitted TPOINT terms as a model file",
    )
    add_replace_option(parser)
    parser.add_argument(
        "--require", choices=("done",), help="exit with 1 unless this is the verdict"
    )
    parser.add_argument(
        "--plot", action="store_true", help="print the error plot against solar time too"
    )


def add_judging_arguments(parser: argparse.ArgumentParser) -> None:
    """Files, and all that has to do with judging them: see ``judging``."""
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="session or points; -: standard input"
    )
    add_method_option(parser)
    add_last_option(parser)
    add_rule_options(parser)
    add_point_options(parser)
    add_json_option(parser)


def add_method_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--method",
        choices=("linear", "robust", "exact", "iterated"),
        help="robust (default): exact geometry, refraction, a physical prior; exact: the same "
        "without prior; linear: six terms by least squares, the original's method; iterated: "
        "TPOINT terms at the encoder places, as SPK's PMFIT",
    )


def add_last_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--last-coefficients",
        metavar="P1..P6|FILE",
        help='last coefficients of the unit, as prior of method robust: six numbers ("0.3 -0.36 '
        '0.5 0.2 0.0008 -0.0006"), a session, or output of `solarcal fit --json`',
    )


def add_bolt_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--bolt-circle",
        type=option_of(bolt_circle),
        metavar="MM,BOLTS[,AZIMUTH]",
        help="print shim heights: diameter of the bolt circle, number of bolts, bearing of one "
        "(default 0, north)",
    )


def bolt_circle(text: str) -> "BoltCircle":
    """The value of ``add_bolt_option``."""
    from solarcal.site import parse_bolt_circle

    return parse_bolt_circle(text)


def last_coefficients(args: argparse.Namespace, geometry: str | None = None) -> "Six | None":
    """The value of ``add_last_option``; a file's must be of this ``geometry``, where it is known.

    Raises
    ------
    ConfigurationError
        It is neither six numbers of a tracker nor a file with them, or the method has no prior.
    """
    text = args.last_coefficients
    if text is None:
        return None
    if getattr(args, "method", None) not in (None, "robust"):
        raise ConfigurationError(
            f"--last-coefficients: the method {args.method} has no prior; robust has"
        )
    from solarcal.profiles import checked_coefficients, parse_coefficients

    if not Path(text).is_file():
        try:
            return parse_coefficients(text)
        except ConfigurationError as error:
            raise ConfigurationError(
                f"--last-coefficients: {error}; give the six numbers P1 to P6, or an existing file"
            ) from None
    from solarcal.station.sun_tracking import read_coefficients

    found = read_coefficients(Path(text))
    if geometry not in (None, found.geometry):
        raise ConfigurationError(
            f"--last-coefficients {text} is of a {found.geometry} mount, this is {geometry}: its "
            "coefficients do not apply here"
        )
    return checked_coefficients(found.coefficients.as_tuple())


def judging(args: argparse.Namespace, files: "UnitFiles") -> "Judging":
    """The values of ``add_judging_arguments`` for these files."""
    from solarcal.mount.formula import Coefficients

    last = last_coefficients(args, files.table.geometry)
    return {
        "method": args.method,
        "last_coefficients": None if last is None else Coefficients(*last),
        "bolt_circle": getattr(args, "bolt_circle", None),
        **rule_changes(args),
    }


def add_rule_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--tolerance",
        type=positive_deg,
        metavar="DEG",
        help="95 %% of the year's pointing must be within this; default the session's, else 0.1",
    )
    parser.add_argument(
        "--done-probability",
        type=share,
        metavar="P",
        help="probability of the tolerance needed for done; default the session's, else 0.95",
    )

    parser.add_argument(
        "--unmodelled",
        action="append",
        type=named_width,
        default=[],
        metavar="NAME=VALUE",
        help="one sigma of a possible error beside P1..P6: clock_s, sag_deg, air, "
        "cross_axis_deg, large_cross_axis_deg, large_chance, large_collimation_chance; spot_deg: "
        "one sigma of a reading of the spot (repeatable)",
    )


def rule_changes(args: argparse.Namespace) -> "RuleChanges":
    """The values of ``add_rule_options``."""
    return {
        "tolerance_deg": args.tolerance,
        "done_probability": args.done_probability,
        "unmodelled": dict(args.unmodelled),
    }


def named_width(text: str) -> tuple[str, float]:
    """NAME=VALUE of one width, for argparse."""
    name, _, value = text.partition("=")
    try:
        width = (name.strip(), decimal(value))
        DEFAULT_UNMODELLED.changed(dict([width]))
    except ConfigurationError as error:
        raise argparse.ArgumentTypeError(f"{shortened(text)}: {error}") from None
    return width


def share(text: str) -> float:
    """A probability to be asked for, for argparse."""
    return _within(text, lambda p: 0.5 <= p < 1.0, "a probability of 0.5 to below 1")


def positive_deg(text: str) -> float:
    """An angle above zero, for argparse."""
    return _within(text, lambda deg: 0.0 < deg < 180.0, "an angle above 0 and below 180 deg")


def _within(text: str, fits: "Callable[[float], bool]", what: str) -> float:
    with contextlib.suppress(ConfigurationError):
        if fits(value := decimal(text)):
            return value
    raise argparse.ArgumentTypeError(f"{shortened(text)} is not {what}")


def add_point_options(parser: argparse.ArgumentParser) -> None:
    """What a points file may leave out, for every command that reads one."""
    missing = parser.add_argument_group("missing keys of a points CSV")
    missing.add_argument("--geometry", choices=("azel", "tiltroll-ew", "tiltroll-ns", "polar"))
    missing.add_argument(
        "--lat", type=number_option(-90, 90), metavar="DEG", help="latitude, north positive"
    )
    missing.add_argument(
        "--lon", type=number_option(-180, 360), metavar="DEG", help="longitude, EAST positive"
    )
    missing.add_argument(
        "--elevation", type=number_option(-500, 9000), metavar="M", help="metres above sea"
    )
    missing.add_argument("--unit", help="name of the unit")
    missing.add_argument(
        "--offsets",
        choices=("plain", "on-sky"),
        help="solaris-pointing files: offset_az is azimuth, or azimuth times cos E",
    )
    missing.add_argument(
        "--ideal",
        choices=("apparent", "airless", "solartrak"),
        help="kind of the ideal angles: with refraction (default), without, or the controller's "
        "own (no refraction, its own ephemeris)",
    )
    paint = parser.add_argument_group("PAINT calibration records")
    paint.add_argument(
        "--heliostat", type=Path, metavar="FILE", help="properties; default ../Properties/*.json"
    )
    paint.add_argument(
        "--tower",
        type=Path,
        metavar="FILE",
        help="default *tower-measurements.json in a folder above",
    )
    paint.add_argument(
        "--spot", choices=("UTIS", "HeliOS"), help="method of the focal spot; default UTIS"
    )


def fill_in(args: argparse.Namespace) -> "FillIn":
    """The values of ``add_point_options``."""
    return {
        "geometry": args.geometry,
        "latitude_deg": args.lat,
        "longitude_deg": args.lon,
        "elevation_m": args.elevation,
        "unit": args.unit,
        "offsets": args.offsets,
        "ideal": args.ideal,
        "heliostat": args.heliostat,
        "tower": args.tower,
        "spot": args.spot,
    }


def run(args: argparse.Namespace) -> int:
    from solarcal.session.interchange.tpoint_model import read_tpoint_model
    from solarcal.station.analysing import analyse_files, read_files
    from solarcal.station.published_model import (
        beam_residuals,
        compare_model,
        fitted_terms,
        write_model,
    )

    refuse_to_replace(args, args.write_model)
    model = None if args.compare is None else read_tpoint_model(args.compare)
    files = read_files(args.files, fill_in(args))
    terms = fitted_terms(args.terms, args.method, model)
    if terms is not None and args.last_coefficients is not None:
        raise ConfigurationError("--last-coefficients: terms of your own choice have no prior")
    judged = analyse_files(files, terms=terms, **judging(args, files))
    if args.require is not None:
        reached = judged.analysis is not None and judged.analysis.verdict.state == args.require
        args.exit_code = 0 if reached else 1
    comparison = None if model is None else compare_model(judged.solution, model)
    beams = beam_residuals(args.files, fill_in(args), judged.solution)
    if args.write_model is not None:
        write_model(judged.solution, args.files, args.write_model)
    if args.json:
        from solarcal.station.documents import fit_document

        document = fit_document(
            args.files,
            judged.table,
            judged.solution,
            judged.analysis,
            findings=judged.findings,
            warnings=judged.warnings,
        )
        if comparison is not None:
            document["comparison"] = comparison.as_json()
        if beams is not None:
            document["beam"] = beams.as_json()
        print_json(document)
    else:
        from solarcal.report.judgement import comparison_blocks
        from solarcal.report.session_report import fit_text

        print(fit_text(judged, plot=args.plot))
        if comparison is not None:
            print("\n" + section_text("Published model", *comparison_blocks(comparison)))
        if beams is not None:
            print("\n" + beams.sentence())
    return int(args.exit_code)
