"""What an inclinometer on the tower tells a fit before the first point."""

import msgspec
import numpy as np

from solarcal.model.methods import DEFAULT_PRIOR
from solarcal.model.prior import Prior
from solarcal.model.terms import LEAN_PRIOR_DEG
from solarcal.mount.geometry import MountGeometry
from solarcal.session.records import Header


def prior_of(header: Header | None) -> Prior:
    """The prior of a session's fit: the usual one, its lean as read where the header has it.

    An inclinometer tells nothing of a base turned about the vertical: on mounts whose primary axis
    is not vertical that part of P1 or P3 keeps the usual width.
    """
    if header is None or header.inclinometer is None:
        return DEFAULT_PRIOR
    reading = header.inclinometer
    basis = MountGeometry(header.geometry, header.site.latitude_deg, header.ax1_centre_deg).basis()
    # A rotation w (east, north, up) moves the tower's top by w x up; P = -(w in native y, x).
    turned_deg = np.array([-reading.lean_north_deg, reading.lean_east_deg, 0.0])
    P3_deg, P1_deg = (-(basis @ turned_deg)[:2]).tolist()
    spread_deg = np.array([reading.sigma_deg, reading.sigma_deg, LEAN_PRIOR_DEG])
    P3_sigma_deg, P1_sigma_deg = np.hypot.reduce(basis[:2] * spread_deg, axis=1).tolist()
    known = DEFAULT_PRIOR.with_inclinometer(P1_deg, P3_deg, reading.sigma_deg)
    zero1, zero2, scale1, scale2 = (known.sigmas[i] for i in (1, 3, 4, 5))
    return msgspec.structs.replace(
        known, sigmas=(P1_sigma_deg, zero1, P3_sigma_deg, zero2, scale1, scale2)
    )
