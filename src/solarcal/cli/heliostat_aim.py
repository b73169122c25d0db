"""`solarcal heliostat aim` and `drift`: the mirror's normal, and what its offset does."""

import argparse

from solarcal.cli.heliostat import asked_geometry, asked_heliostat, asked_site, asked_sun_deg
from solarcal.cli.output import print_answer, require


def aim(args: argparse.Namespace) -> int:
    """The normal for a Sun and a target, with everything the offset does to it."""
    from solarcal.report.field.heliostat_aim import aim as answer

    return print_answer(
        answer(
            asked_sun_deg(args),
            asked_heliostat(args),
            asked_geometry(args),
            distance_known=args.distance is not None,
            latitude_deg=args.lat or 45.0,
        ),
        args.json,
    )


def drift(args: argparse.Namespace) -> int:
    """What an uncorrected mirror offset does to the beam over a day."""
    from solarcal.cli.sun import asked_day_utc_s
    from solarcal.report.field.heliostat_aim import drift as answer

    site, heliostat = asked_site(args), asked_heliostat(args)
    require(args.distance, "--distance")
    at_utc_s = asked_day_utc_s(args.at, site)
    return print_answer(answer(site, heliostat, at_utc_s, args.refraction), args.json)
