"""Counts to axis angle and back."""

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.units import Angles


class RotaryDrive(msgspec.Struct, frozen=True, tag="rotary"):
    """counts = counts_per_deg * (angle - zero); ``counts_per_deg`` is signed."""

    counts_per_deg: float

    def __post_init__(self) -> None:
        if not np.isfinite(self.counts_per_deg) or self.counts_per_deg == 0.0:
            raise ConfigurationError("a rotary drive needs a gear ratio in counts/deg, not zero")

    def counts(self, angle_deg: Angles) -> Angles:
        return self.counts_per_deg * angle_deg  # type: ignore[return-value]

    def angle_deg(self, counts: Angles) -> Angles:
        return counts / self.counts_per_deg  # type: ignore[return-value]


Drive = RotaryDrive
