"""``python -m solarcal`` and the ``solarcal`` script."""

import sys


def main() -> int:
    from solarcal.cli import run_command

    return run_command(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
