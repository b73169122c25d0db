"""Sessions of one unit in order of time, and those whose points alternate in time.

What moved between two sessions stays moved: of sessions that overlap in time none is the later one,
and their points are one set. Where they contradict each other nonetheless, they are not of one unit
or not read in one way.
"""

from collections.abc import Sequence

import numpy as np

from solarcal.errors import FitError
from solarcal.model.earlier_sessions import merge_sessions
from solarcal.model.finding import Finding, listed
from solarcal.model.points import Points
from solarcal.model.prior import Prior
from solarcal.model.sky_context import SkyContext


def groups_in_time(parts: Sequence[Points]) -> list[list[int]] | None:
    """Positions of the sessions in order of time, overlapping ones together.

    None where a session has no time: their order is not known.
    """
    times = [np.empty(0) if part.utc_s is None else part.utc_s for part in parts]
    known = [stamps[np.isfinite(stamps)] for stamps in times]
    if not all(len(stamps) for stamps in known):
        return None
    groups: list[list[int]] = []
    end_s = -np.inf
    for at in sorted(range(len(parts)), key=lambda at: float(known[at].min())):
        if known[at].min() < end_s:
            groups[-1].append(at)
        else:
            groups.append([at])
        end_s = max(end_s, float(known[at].max()))
    return groups


def contradictions(
    parts: Sequence[Points],
    names: Sequence[str],
    context: SkyContext,
    prior: Prior,
    limit_deg: float,
) -> tuple[Finding, ...]:
    """Findings on sessions that overlap in time and differ by more than a limit, rms on the sky."""
    found = []
    for group in groups_in_time(parts) or ():
        if len(group) < 2:
            continue
        called = [names[at] for at in group]
        try:
            merged = merge_sessions([parts[at] for at in group], context, prior=prior, names=called)
        except FitError:
            # One of them has no point high enough: nothing to compare.
            continue
        apart = np.einsum("nak,sk->sna", merged.solution.slopes[..., :4], merged.shifts)
        most_deg = float(np.sqrt(np.mean(np.sum(apart**2, axis=2), axis=1)).max())
        if most_deg <= limit_deg:
            continue
        found.append(
            Finding(
                kind="contradiction",
                subject="sessions",
                sentence=f"the points of {listed(called)} alternate in time and differ by "
                f"{most_deg:.3f} deg rms on the sky: a tower does not move to and fro between "
                "points. They are of two trackers, or two persons read differently; fit each file "
                "alone, and find the one that is wrong",
                number=most_deg,
                direct=True,
            )
        )
    return tuple(found)
