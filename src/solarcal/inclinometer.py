"""A tower's lean as an inclinometer on it reads."""

import msgspec


class Inclinometer(msgspec.Struct, frozen=True, kw_only=True):
    """A reading of the tower's lean, degrees: its top to the north and to the east, one sigma."""

    lean_north_deg: float
    lean_east_deg: float
    sigma_deg: float

    def words(self) -> str:
        return (
            f"inclinometer: lean to the north {self.lean_north_deg:+.3f} deg, "
            f"to the east {self.lean_east_deg:+.3f} deg, sigma {self.sigma_deg:.3f} deg"
        )
