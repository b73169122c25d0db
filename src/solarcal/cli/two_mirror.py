"""``solarcal two-mirror``: two 45-degree mirrors on an altazimuth mount.

The subcommands and the keys of their JSON documents are in docs/two-mirror.md.

``follow``: points that take themselves, by a unit's sun sensor. Typing the command is the explicit
command. Today only an emulator's wire tells what its sensor sees; a real unit is refused. On the
Moon the unit is jogged: what it computes is the Sun.
"""

import argparse
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from solarcal.cli.calibrate import (
    add_emulator_arguments,
    add_seed_option,
    add_set_option,
    tracker_for,
)
from solarcal.cli.instrument import add_options, answer, watch_folder
from solarcal.cli.process import (
    add_json_option,
    add_replace_option,
    print_json,
    refuse_to_replace,
    say,
    terminal_size,
)
from solarcal.cli.unit_options import (
    add_driver_options,
    add_output_option,
    asks_for_unit,
    journal_creator,
    named_profile,
)
from solarcal.decimals import counted, number_option, whole_option
from solarcal.errors import ConfigurationError
from solarcal.instruments.catalogue import BY_ID
from solarcal.timescale import SystemClock

if TYPE_CHECKING:
    from solarcal.two_mirror.base import MirrorPoints
    from solarcal.two_mirror.mirrors import EulerBase
    from solarcal.unit.tracker import Tracker


PANEL_ROWS = 14

_INSTRUMENTS = {
    "point": "axis angles for the Sun, and the matrix of the mirrors",
    "trace": "the diode's four signals traced back to axis corrections",
    "camera": "the disc in a camera's image as axis corrections",
    "fov": "field of view of diode and tracker against the Sun's 9 mrad",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The subcommands and their options."""
    kinds = parser.add_subparsers(dest="kind", metavar="WHAT", required=True)

    def kind(name: str, help_line: str) -> argparse.ArgumentParser:
        one = kinds.add_parser(name, help=help_line, description=help_line)
        add_json_option(one)
        return one

    for name, help_line in _INSTRUMENTS.items():
        one = kind(name, help_line)
        add_options(one, [BY_ID[f"mirrors-{name}"]])
        if name == "camera":
            one.add_argument(
                "--images",
                type=whole_option(1, 1_000_000),
                metavar="N",
                help="folder: wait for this number of new images, print a line for each",
            )

    fit = kind("fit", "Euler angles of the base from points (CSV, azel)")
    fit.add_argument("file", metavar="FILE", help="points CSV: axis angles on the Sun")
    fit.add_argument(
        "--plot",
        action="store_true",
        help="plot calculated against actual angles of both axes, before and after the fit",
    )

    for name, text in (
        ("simulate", "simulate a clear day in closed loop, and fit the base from its log"),
        ("tune", "Ziegler-Nichols gains by experiment on the simulated loop"),
    ):
        one = kind(name, text)
        one.add_argument("--scenario", default="maido", metavar="NAME|FILE")
        add_set_option(one, "loop.control=step")
        one.add_argument("--target", choices=("sun", "moon"), help="(default: the scenario's, sun)")
        one.add_argument("--day", metavar="DATE", help="the local date, like 2026-11-25")
        add_seed_option(one)
        if name == "simulate":
            one.add_argument("--log", metavar="FILE", help="write the log as a points CSV")
            add_replace_option(one)
        else:
            one.add_argument("--axis", type=whole_option(), choices=(1, 2), default=2)

    add_follow_arguments(
        kind("follow", "take calibration points automatically with a unit's sun sensor")
    )


def run(args: argparse.Namespace) -> int:
    """Compute, and print text or the document; 1 when a simulated loop had to stop itself."""
    if args.kind == "camera" and args.images is not None:
        return watch_folder(BY_ID["mirrors-camera"], args, SystemClock())
    if args.kind in _INSTRUMENTS:
        return answer(BY_ID[f"mirrors-{args.kind}"], args)
    kinds: dict[str, Callable[[argparse.Namespace], tuple[dict[str, Any], list[str]]]] = {
        "fit": _fit,
        "simulate": _simulate,
        "tune": _tune,
        "follow": follow,
    }
    document, lines = kinds[args.kind](args)
    args.exit_code = 1 if document.get("stopped") else 0
    if args.json:
        print_json(document)
    else:
        print("\n".join(lines))
    return int(args.exit_code)


def _fit(args: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    from solarcal.session.interchange.csv_points import read_points_csv
    from solarcal.station.analysing import stamp_findings
    from solarcal.two_mirror.base import MirrorPoints, fit_base
    from solarcal.two_mirror.mirrors import EulerBase

    table = read_points_csv(args.file, geometry=None)
    if table.geometry != "azel":
        raise ConfigurationError(
            f"{args.file}: geometry {table.geometry}; a two-mirror tracker's points are azel"
        )
    table = table.accepted()
    warnings = [*table.warnings, *(finding.sentence for finding in stamp_findings(table))]
    points = MirrorPoints(
        table.ax1_deg,
        table.ax2_deg,
        table.ax1_deg + table.err1_deg,
        table.ax2_deg + table.err2_deg,
        table.labels,
    )
    solution = fit_base(points)
    before_deg = points.sky_deg(EulerBase())
    document: dict[str, Any] = {
        "file": str(args.file),
        "points": solution.n_points,
        "base": asdict(solution.base),
        "sigma_deg": solution.sigma_deg,
        "start": asdict(solution.start),
        "before_rms_deg": float((before_deg @ before_deg / len(points)) ** 0.5),
        "before_max_deg": float(before_deg.max()),
        "sky_rms_deg": solution.sky_rms_deg,
        "sky_max_deg": solution.sky_max_deg,
        "worst_line": solution.worst_label,
        "warnings": warnings,
    }
    sigmas = solution.sigma_deg or (None, None, None)
    lines = [*warnings, f"{counted(solution.n_points, 'point')} of {args.file}"]
    begun = document["start"]
    for (name, value), sigma in zip(document["base"].items(), sigmas, strict=True):
        known = "" if sigma is None else f" +- {sigma:.4f}"
        lines.append(
            f"  {name.removesuffix('_deg'):5} {value:+z9.4f}{known} deg   (from three points "
            f"{begun[name]:+z9.4f})"
        )
    lines.append(
        f"left on the sky: rms {solution.sky_rms_deg:.4f}, at most {solution.sky_max_deg:.4f} deg "
        f"(line {solution.worst_label})"
    )
    lines.append(
        f"by a level base:  rms {document['before_rms_deg']:.4f}, at most "
        f"{document['before_max_deg']:.4f} deg"
    )
    if args.plot:
        lines += _panels(points, solution.base)
    return document, lines


def _panels(points: "MirrorPoints", base: "EulerBase") -> list[str]:
    """Calculated against actual angles, axis by axis, by a level base and by the fitted one."""
    from solarcal.report.instrument_plots import Curve, curve_plot
    from solarcal.report.scales import Sheet
    from solarcal.two_mirror.mirrors import EulerBase

    width, colour = terminal_size()
    sheet = Sheet(width, PANEL_ROWS, colour)
    panels = []
    for axis in (0, 1):
        actual = (points.axis1_deg, points.axis2_deg)[axis]
        for name, by in (("before", EulerBase()), ("after", base)):
            curves = [
                Curve("equal", actual, "·"),
                Curve("calculated", points.calculated_deg(by)[axis], "●"),
            ]
            title = f"axis {axis + 1} {name} the fit, deg"
            panels.append(curve_plot(title, actual, curves, "actual, deg", sheet))
    return panels


def _simulate(args: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    from solarcal.two_mirror.day import day_document, day_lines, day_table, simulate_day

    refuse_to_replace(args, args.log)
    day = simulate_day(_scenario(args), seed=args.seed or 0)
    if args.log:
        from solarcal.session.interchange.csv_points import write_points_csv

        write_points_csv(day_table(day), args.log)
    return day_document(day), day_lines(day)


def _tune(args: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    from solarcal.two_mirror.tuning import tune

    tuning = tune(_scenario(args), seed=args.seed or 0, axis=args.axis)
    gains = tuning.gains
    document = {
        "axis": tuning.axis,
        **tuning.gains_document(),
        "reduced": tuning.reduced,
        "trials": [{"gain_per_s": gain, "growth": growth} for gain, growth in tuning.trials],
    }
    lines = [
        f"axis {tuning.axis}: oscillation after a displacement of 1 mrad, by proportional gain"
    ]
    lines += [
        f"  {gain:8.4f} 1/s  {'lost' if growth == float('inf') else f'{growth:.3f} times'}"
        for gain, growth in sorted(tuning.trials)
    ]
    lines += [
        f"critical gain Kc {tuning.critical_gain:.4f} 1/s, period Tc "
        f"{tuning.critical_period_s:.3f} s",
        f"Kp = 0.6 Kc = {gains.kp:.4f} 1/s, Ki = 2 Kp/Tc = {gains.ki:.4f} 1/s2, "
        f"Kd = Kp Tc/8 = {gains.kd:.4f}",
    ]
    if tuning.reduced < 1.0:
        lines[-1] = (
            f"this sampled loop oscillates with the Ziegler-Nichols gains; it settles with "
            f"{tuning.reduced:.2f} of them: Kp {gains.kp:.4f}, Ki {gains.ki:.4f}, Kd {gains.kd:.4f}"
        )
    return document, lines


def _scenario(args: argparse.Namespace) -> Any:
    from solarcal.two_mirror.scenario import load_mirror_scenario

    settings = list(args.settings)
    if args.target:
        settings.append(f"target={args.target}")
    if args.day:
        settings.append(f'day="{args.day}"')
    return load_mirror_scenario(args.scenario, settings)


def add_follow_arguments(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scenario", metavar="NAME|FILE", help="an emulated tracker, in process")
    where.add_argument("--port", metavar="URL", help="an emulator on a line")
    add_driver_options(parser)
    add_emulator_arguments(parser)
    parser.add_argument(
        "--target",
        choices=("sun", "moon"),
        default="sun",
        help="light of the sensor (default sun); an emulator in process gets the same light",
    )
    parser.add_argument(
        "--points", type=whole_option(1), default=12, help="points to take (default 12)"
    )
    parser.add_argument(
        "--every", type=number_option(0.0), default=30.0, metavar="MINUTES", help="(default 30)"
    )
    add_output_option(parser)


def follow(args: argparse.Namespace) -> tuple[dict[str, Any], list[str]]:
    """Prepare the unit as the procedure asks, then let the sensor take the points."""
    if not asks_for_unit(args):
        args.settings = [*args.settings, f"truth.light={args.target}"]
    with tracker_for(args) as (tracker, name, noise_deg):
        return _followed(args, tracker, name, noise_deg)


def _followed(
    args: argparse.Namespace, tracker: "Tracker", name: str, noise_deg: float | None
) -> tuple[dict[str, Any], list[str]]:
    from solarcal.station.headless import emulated_station
    from solarcal.station.moon_following import MoonFollower
    from solarcal.station.sensor_following import FollowPlan, SensorFollower
    from solarcal.station.technician import AutomaticTechnician, Schedule

    plan = FollowPlan(args.points, args.every)
    station, emulation = emulated_station(
        tracker,
        "does not report a sun sensor; take points by eye with `solarcal run`",
        named_profile(args),
        operator="sun sensor",
        pointing_device="emulated sun sensor",
        target=args.target,
        say=say,
    )
    path = station.open_session(journal_creator(args.output, name)).path
    kind: type[SensorFollower]
    if args.target == "moon":
        station.set_unit_clock()
        station.ref_check()
        station.initialise(confirmed=True)
        kind = MoonFollower
    else:
        AutomaticTechnician(station, emulation.spot, Schedule(), say=say).prepare()
        kind = SensorFollower
    sigma_deg = 0.02 if noise_deg is None else noise_deg
    follower = kind(station, emulation.spot, sensor_sigma_deg=sigma_deg, say=say)
    followed = follower.follow(plan, commanded=True)
    taken = len(followed.points)
    lines = [f"{counted(taken, 'point')} by the sun sensor"]
    if followed.stopped:
        lines.append(f"STOPPED: {followed.stopped}")
    lines.append(f"session: {path}")
    station.close("following the sun sensor finished")
    document = {"session": str(path), "points": taken, "stopped": followed.stopped or None}
    return document, lines
