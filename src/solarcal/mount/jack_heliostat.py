"""A heliostat on two screwjacks: from motor positions to the mirror's normal and centre.

The first axis is fixed to Earth and points East, the second is carried by it and points up where
the first is at zero; the mirror looks South there. In the frame of a `tiltroll-ew` mount the normal
stands at AX1 = joint 1 + 90 deg (0 straight up, positive South) and AX2 = 90 deg - joint 2 (from
East), so that its errors are those of any mechanism: leans of the first axis, zeros, scales, axes
not square.

Each jack closes a triangle with its pivot radius and the distance between the pivots:
L^2 = offset^2 + radius^2 - 2 offset radius cos(corner), L = initial stroke + steps / increment.
"""

from dataclasses import dataclass

import numpy as np

from solarcal.mount.drive import ScrewjackDrive
from solarcal.units import RAD_PER_DEG, FloatArray


@dataclass(frozen=True, slots=True)
class Jack:
    """One linear actuator.

    ``increment``: motor steps per metre. ``initial_stroke``: length at step 0, metres.
    ``offset``: from the axis to the jack's base pivot; ``pivot_radius``: from the axis to its other
    end, metres. ``initial_angle_deg``: the joint's angle at step 0. ``clockwise``: the joint's
    angle shrinks as the jack grows longer.
    """

    increment: float
    initial_stroke: float
    offset: float
    pivot_radius: float
    initial_angle_deg: float
    clockwise: bool

    def joint_deg(self, steps: FloatArray) -> FloatArray:
        """Joint angle at motor positions of any shape, degrees.

        Raises
        ------
        ConfigurationError
            Lengths that no triangle has, or a stroke at which it cannot close.
        """
        jack = ScrewjackDrive(self.offset, self.pivot_radius, 0.0, 0.0, self.increment)
        first = jack.angle_from_length_deg(self.initial_stroke)
        turned = first - jack.angle_from_length_deg(self.initial_stroke + steps / self.increment)
        return self.initial_angle_deg + (turned if self.clockwise else -turned)

    def steps_at(self, joint_deg: FloatArray) -> FloatArray:
        """Motor positions at joint angles: the inverse of ``joint_deg``, not rounded."""
        jack = ScrewjackDrive(self.offset, self.pivot_radius, 0.0, 0.0, self.increment)
        first = jack.angle_from_length_deg(self.initial_stroke)
        turned = joint_deg - self.initial_angle_deg
        corner = first - (turned if self.clockwise else -turned)
        return (jack.length(corner) - self.initial_stroke) * self.increment


@dataclass(frozen=True, slots=True)
class JackHeliostat:
    """Two jacks and where the mirror sits on them.

    ``position_enu``: of the first joint's origin, metres. ``first_joint``, ``second_joint``,
    ``concentrator``: translations (east, north, up) in front of each joint and behind the second,
    metres, in the frame that turns with the joints before.
    """

    jacks: tuple[Jack, Jack]
    position_enu: tuple[float, float, float]
    first_joint: tuple[float, float, float] = (0.0, 0.0, 0.0)
    second_joint: tuple[float, float, float] = (0.0, 0.0, 0.0)
    concentrator: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def readings_deg(self, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(AX1, AX2) of the normal in the frame of a `tiltroll-ew` mount, steps (n, 2)."""
        joint1 = self.jacks[0].joint_deg(steps[:, 0])
        joint2 = self.jacks[1].joint_deg(steps[:, 1])
        return joint1 + 90.0, 90.0 - joint2

    def steps_at(self, ax1_deg: FloatArray, ax2_deg: FloatArray) -> FloatArray:
        """Motor positions (n, 2) at these readings."""
        return np.stack(
            (self.jacks[0].steps_at(ax1_deg - 90.0), self.jacks[1].steps_at(90.0 - ax2_deg)),
            axis=-1,
        )

    def centre_enu(self, ax1_deg: FloatArray, ax2_deg: FloatArray) -> FloatArray:
        """Centre of the mirror (n, 3), metres, with the axes at these readings."""
        joint1, joint2 = (ax1_deg - 90.0) * RAD_PER_DEG, (90.0 - ax2_deg) * RAD_PER_DEG
        east, north, up = self.concentrator
        # Turned about up by joint 2, shifted, turned about East by joint 1.
        x = east * np.cos(joint2) - north * np.sin(joint2) + self.second_joint[0]
        y = east * np.sin(joint2) + north * np.cos(joint2) + self.second_joint[1]
        z = up + self.second_joint[2]
        turned = np.stack(
            (
                x,
                y * np.cos(joint1) - z * np.sin(joint1),
                y * np.sin(joint1) + z * np.cos(joint1),
            ),
            axis=-1,
        )
        return np.asarray(turned + np.add(self.position_enu, self.first_joint))
