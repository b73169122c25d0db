"""Two 45-degree mirrors on an altazimuth mount: what they do to a direction, and how the base lies.

The frame is `azel` native: x South, y East, z Up; t1 = AX1 turns about z, t2 = AX2 is the zenith
angle. A ray that leaves the instrument upwards (+z) meets both mirrors and leaves along

    M_tracker(t1, t2) z^,   M_tracker = Rz(t1) Ry(t2) M_R Ry(-t2) M_R Rz(-t1),
    M_R = I - 2 n n^T,  n = (0, 1, -1)/sqrt 2,

which is the direction (t1, t2). M_tracker(0, 0) = I: at the zenith the image is not turned. The
base of the tracker is rotated by Euler angles, s_tracker = M s with
M = Rx(gamma) Ry(beta) Rz(alpha); for small angles gamma = P3, beta = P1, alpha = P2. All rotations
are right-handed and turn vectors, not frames.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import rotated
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

Components = tuple[float, float, float]
"""Three components of one vector as plain floats: the control loop handles some 1e5 of them."""

IDENTITY: tuple[Components, Components, Components] = (
    (1.0, 0.0, 0.0),
    (0.0, 1.0, 0.0),
    (0.0, 0.0, 1.0),
)


def rotation_x(angle_deg: float) -> FloatArray:
    """Right-handed rotation of vectors about x, (3, 3)."""
    c, s = _cos_sin(angle_deg)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rotation_y(angle_deg: float) -> FloatArray:
    """Right-handed rotation of vectors about y, (3, 3)."""
    c, s = _cos_sin(angle_deg)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rotation_z(angle_deg: float) -> FloatArray:
    """Right-handed rotation of vectors about z, (3, 3)."""
    c, s = _cos_sin(angle_deg)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def mirror_matrix(normal: ArrayLike) -> FloatArray:
    """Reflection I - 2 n n^T in a mirror of this normal (any length but zero), (3, 3).

    Raises
    ------
    ConfigurationError
        The normal is not three finite numbers, or has no length.
    """
    n = np.asarray(normal, dtype=np.float64)
    if n.shape != (3,) or not np.all(np.isfinite(n)):
        raise ConfigurationError("a mirror's normal is three numbers X,Y,Z")
    length = float(np.linalg.norm(n))
    if length < 1e-12:
        raise ConfigurationError("a mirror's normal must not have zero length")
    n = n / length
    return np.eye(3) - 2.0 * np.outer(n, n)


def fixed_mirrors_matrix(normals: Sequence[ArrayLike]) -> FloatArray:
    """F, the product of the fixed mirrors' matrices, (3, 3); the identity without mirrors.

    ``normals`` in the order in which a ray traced from the tracker to the diode meets them.
    """
    product = np.eye(3)
    for normal in normals:
        product = product @ mirror_matrix(normal)
    return product


MOVING_MIRROR = mirror_matrix((0.0, 1.0, -1.0))
"""M_R of both moving mirrors. It exchanges y and z."""


def tracker_matrix(t1_deg: float, t2_deg: float) -> FloatArray:
    """M_tracker: a ray traced back from the instrument to the sky, (3, 3), tracker's frame."""
    turned = rotation_z(t1_deg) @ rotation_y(t2_deg) @ MOVING_MIRROR
    result: FloatArray = turned @ rotation_y(-t2_deg) @ MOVING_MIRROR @ rotation_z(-t1_deg)
    return result


def ray_to_sky(ray: Components, t1_deg: float, t2_deg: float) -> Components:
    """``tracker_matrix(t1, t2) @ ray``, on plain floats."""
    c1, s1 = _cos_sin(t1_deg)
    c2, s2 = _cos_sin(t2_deg)
    x, y, z = ray
    x, y = c1 * x + s1 * y, c1 * y - s1 * x
    # M_R exchanges y and z; then Ry(-t2), then M_R again.
    y, z = z, y
    x, z = c2 * x - s2 * z, s2 * x + c2 * z
    y, z = z, y
    x, z = c2 * x + s2 * z, c2 * z - s2 * x
    return c1 * x - s1 * y, s1 * x + c1 * y, z


def ray_from_sky(direction: Components, t1_deg: float, t2_deg: float) -> Components:
    """``tracker_matrix(t1, t2).T @ direction``, on plain floats: where the light goes."""
    c1, s1 = _cos_sin(t1_deg)
    c2, s2 = _cos_sin(t2_deg)
    x, y, z = direction
    x, y = c1 * x + s1 * y, c1 * y - s1 * x
    x, z = c2 * x - s2 * z, s2 * x + c2 * z
    y, z = z, y
    x, z = c2 * x + s2 * z, c2 * z - s2 * x
    y, z = z, y
    return c1 * x - s1 * y, s1 * x + c1 * y, z


def direction(t1_deg: Angles, t2_deg: Angles) -> FloatArray:
    """Unit vectors of axis angles, shape (..., 3), components South, East, Up."""
    t1, t2 = np.asarray(t1_deg) * RAD_PER_DEG, np.asarray(t2_deg) * RAD_PER_DEG
    sin2 = np.sin(t2)
    parts = np.broadcast_arrays(sin2 * np.cos(t1), sin2 * np.sin(t1), np.cos(t2))
    return np.stack(parts, axis=-1)


def direction_components(t1_deg: float, t2_deg: float) -> Components:
    """``direction`` of one pair of angles as plain floats."""
    c1, s1 = _cos_sin(t1_deg)
    c2, s2 = _cos_sin(t2_deg)
    return s2 * c1, s2 * s1, c2


def axes_of(vector: Components) -> tuple[float, float]:
    """(t1 in (-180, 180], t2) of a direction of any length but zero, degrees.

    Raises
    ------
    ConfigurationError
        The vector has no length, or is not finite.
    """
    x, y, z = vector
    across = math.hypot(x, y)
    length = math.hypot(across, z)
    if not math.isfinite(length) or length < 1e-12:
        raise ConfigurationError("a direction must be a finite vector, not one of zero length")
    return math.atan2(y, x) / RAD_PER_DEG, math.atan2(across, z) / RAD_PER_DEG


def sun_axes_deg(azimuth_deg: float, zenith_deg: float) -> tuple[float, float]:
    """The Sun's (AX1, AX2) from its azimuth (North through East) and zenith angle.

    Raises
    ------
    ConfigurationError
        The Sun is below the horizon.
    """
    if not (math.isfinite(azimuth_deg) and math.isfinite(zenith_deg)):
        raise ConfigurationError("azimuth and zenith angle of the Sun must be numbers")
    if not 0.0 <= zenith_deg <= 90.0:
        raise ConfigurationError(
            f"the Sun at zenith angle {zenith_deg:.2f} deg is below the horizon; "
            "give a moment when it is up (zenith angle 0 to 90)"
        )
    return 180.0 - azimuth_deg, zenith_deg


@dataclass(frozen=True)
class EulerBase:
    """How the tracker's base is turned: s_tracker = Rx(gamma) Ry(beta) Rz(alpha) s."""

    alpha_deg: float = 0.0
    beta_deg: float = 0.0
    gamma_deg: float = 0.0

    def matrix(self) -> FloatArray:
        """M, (3, 3)."""
        result: FloatArray = (
            rotation_x(self.gamma_deg) @ rotation_y(self.beta_deg) @ rotation_z(self.alpha_deg)
        )
        return result

    @classmethod
    def of_matrix(cls, matrix: FloatArray) -> "EulerBase":
        """The Euler angles of a rotation matrix; beta in [-90, 90]."""
        m = matrix
        return cls(
            float(np.arctan2(-m[0, 1], m[0, 0])) / RAD_PER_DEG,
            float(np.arctan2(m[0, 2], np.hypot(m[0, 0], m[0, 1]))) / RAD_PER_DEG,
            float(np.arctan2(-m[1, 2], m[2, 2])) / RAD_PER_DEG,
        )

    def axes_deg(self, sun1_deg: float, sun2_deg: float) -> tuple[float, float]:
        """Calculated mode: the axis angles (t1 in (-180, 180], t2) that look at the Sun."""
        return axes_of(self.of_tracker(direction_components(sun1_deg, sun2_deg)))

    def of_tracker(self, of_earth: Components) -> Components:
        """A vector of the Earth's frame in the tracker's."""
        found: Components = rotated(self._rows, of_earth)
        return found

    @cached_property
    def _rows(self) -> tuple[Components, Components, Components]:
        a, b, c = self.matrix().tolist()
        return a, b, c


def _cos_sin(angle_deg: float) -> tuple[float, float]:
    angle = angle_deg * RAD_PER_DEG
    return math.cos(angle), math.sin(angle)
