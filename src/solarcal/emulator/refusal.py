"""How the emulated unit says NO."""

from solarcal.unit.refusals import Code


class Refusal(Exception):
    """A request the unit does not carry out; nothing has changed."""

    def __init__(self, code: Code, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text
