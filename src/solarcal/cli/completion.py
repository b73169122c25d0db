"""``solarcal completion``: the script that makes Tab complete commands, options and file names.

The script asks the program itself at each Tab, so what it offers is never older than the program.
"""

import argparse
import os

from solarcal.cli import build_parser

SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="the shell you use")
    parser.epilog = (
        'bash and zsh: add eval "$(solarcal completion SHELL)" to ~/.bashrc or ~/.zshrc '
        "(zsh: after compinit). fish: solarcal completion fish > "
        "~/.config/fish/completions/solarcal.fish"
    )


def run(args: argparse.Namespace) -> int:
    from argcomplete.shell_integration import shellcode

    print(shellcode(["solarcal"], shell=args.shell), end="")
    return 0


def complete() -> None:
    """Answer one Tab of a shell: writes what fits to the shell's descriptor and exits.

    Called where the variable ``_ARGCOMPLETE`` is set, before anything else is imported.
    """
    import argcomplete

    line = os.environ.get("COMP_LINE", "").split()
    asked = next((word for word in line[1:] if not word.startswith("-")), None)
    parser = build_parser(asked)
    if asked is not None:
        _name_scenarios(parser, asked)
    argcomplete.autocomplete(parser, exclude=["--debug"])


def _name_scenarios(parser: argparse.ArgumentParser, asked: str) -> None:
    """Offer the built-in scenarios where a command takes one; files are offered as well."""
    from argcomplete.completers import FilesCompleter

    from solarcal.emulator.scenario import scenario_names

    def scenarios(prefix: str, **context: object) -> list[str]:
        files = FilesCompleter(("toml",))(prefix)
        return [*(name for name in scenario_names() if name.startswith(prefix)), *files]

    for group in parser._actions:
        if isinstance(group, argparse._SubParsersAction) and asked in group.choices:
            for action in group.choices[asked]._actions:
                if action.dest == "scenario":
                    action.completer = scenarios
