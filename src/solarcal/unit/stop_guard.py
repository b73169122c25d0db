"""Nothing that was asked before a STOP moves a unit after it, on whatever line."""

import contextlib
import threading
from collections.abc import Iterator

from solarcal.errors import ProcedureRefused


class StopGuard:
    """No motion that waited goes out behind a STOP it did not see: a driver writes within it."""

    def __init__(self) -> None:
        self.stops = 0
        """How often the unit was stopped, stowed or parked."""
        self._lock = threading.Lock()

    @contextlib.contextmanager
    def sending(
        self,
        stops: int | None = None,
        *,
        interrupts: bool = False,
        given_up: str = "the motion was given up: the rotator was stopped or parked",
    ) -> Iterator[None]:
        """One lock over the look and the write; ``stops`` as of ``go_to``.

        Raises
        ------
        ProcedureRefused
            It was stopped since: ``given_up``.
        """
        with self._lock:
            if interrupts:
                self.stops += 1
            elif stops is not None and stops != self.stops:
                raise ProcedureRefused(f"{given_up} meanwhile; set its mode again before moving it")
            yield
