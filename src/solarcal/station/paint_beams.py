"""How far beside their focal spots the beams of a fitted PAINT heliostat fall."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from solarcal.model.solution import Solution
from solarcal.session.interchange import FillIn, is_paint, read_paint
from solarcal.session.interchange.paint import beam_residuals_mrad
from solarcal.units import FloatArray


@dataclass(frozen=True, slots=True)
class BeamResiduals:
    """``before_mrad``: with the drawing's mechanism; ``after_mrad``: with the fitted one, (n,)."""

    before_mrad: FloatArray
    after_mrad: FloatArray

    def as_json(self) -> dict[str, Any]:
        return {
            "rms_before_mrad": _rms(self.before_mrad),
            "rms_mrad": _rms(self.after_mrad),
            "max_mrad": float(self.after_mrad.max()),
        }

    def sentence(self) -> str:
        return (
            f"beam beside the spot, as seen from the mirror: rms {_rms(self.after_mrad):.3f} mrad, "
            f"largest {self.after_mrad.max():.3f} (before the fit rms {_rms(self.before_mrad):.3f})"
        )


def beam_residuals(
    files: Sequence[Path], fill_in: FillIn, solution: Solution
) -> BeamResiduals | None:
    """Of a fit of PAINT records alone; None for any other files."""
    if not all(is_paint(path) for path in files):
        return None
    shots = read_paint(files, fill_in).shots()
    if solution.n_points != len(shots.sun_enu):
        return None
    before = (
        shots.readings_deg[0] - shots.ideal_deg[0],
        shots.readings_deg[1] - shots.ideal_deg[1],
    )
    return BeamResiduals(
        beam_residuals_mrad(shots, *before),
        beam_residuals_mrad(shots, solution.residual1_deg, solution.residual2_deg),
    )


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
