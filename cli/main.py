# SPDX-License-Identifier: Apache-2.0
"""The ``hypgen`` command: finds the command's module, runs it, and turns failures into exit codes."""

from __future__ import annotations

import contextlib
import importlib
import io
import keyword
import os
import sys
from collections.abc import Sequence

import click
from click.shell_completion import shell_complete

from hypgen import __version__
from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.interrupts import catch_interrupts, interrupt_code
from hypgen.cli.machine_faults import explain
from hypgen.cli.output import keep_unwritten, last_words, say, show_model_error
from hypgen.dsl.messages.diagnostic import did_you_mean

SECTIONS = {
    "Write a model": ("new", "check", "error", "fmt", "sim", "explain", "lsp"),
    "Solve it": ("compile", "run", "view", "solve", "compare", "verify"),
    "Experiment": ("bench", "report", "tune"),
    "Other formats": ("import", "export"),
    "This machine": ("doctor",),
}
COMMANDS = tuple(name for names in SECTIONS.values() for name in names)


class LazyGroup(click.Group):
    """A group that imports a command only when it is asked for: ``check`` must not pay for ``doctor``."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return all commands' names."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command called ``cmd_name``: ``command`` of the module of that name."""
        if cmd_name not in COMMANDS:
            return None
        own = f"{cmd_name}_" if keyword.iskeyword(cmd_name) else cmd_name  # `import` can name no module
        module = importlib.import_module(f"hypgen.cli.commands.{own}")
        command: click.Command = module.command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that ``args`` start with; name the nearest if there is none."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            nearest = did_you_mean(args[0], COMMANDS)
            message = f"{error.message} {nearest[:1].upper()}{nearest[1:]}".rstrip()
            raise click.UsageError(message, ctx) from None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands, those that belong together under one heading."""
        for heading, names in SECTIONS.items():
            commands = ((name, self.get_command(ctx, name)) for name in names)
            with formatter.section(heading):
                formatter.write_dl([(n, c.get_short_help_str(100)) for n, c in commands if c is not None])


@click.group(
    cls=LazyGroup,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=EXIT_CODES,
)
@click.version_option(__version__, prog_name="hypgen")
def group() -> None:
    """Compile declarative POMDP models into fast native online planners.

    \b
    Examples:
      hypgen new robot --template robot
      hypgen check examples/tiger.pomdp
      hypgen run examples/rock_sample.pomdp --runs 10 --time 0.1
      hypgen compile examples/tag.pomdp -o tag-solver
    """


def main(arguments: Sequence[str] | None = None) -> None:
    """Run hypgen on ``arguments`` (the process's own by default) and exit."""
    catch_interrupts()
    keep_unwritten()
    code = run(arguments)
    last_words(sys.stderr)
    sys.exit(code)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run hypgen on ``arguments`` and return its exit code."""
    if sys.stdin is None:  # closed by whoever started this program
        sys.stdin = io.TextIOWrapper(io.BytesIO())
    code = _run(sys.argv[1:] if arguments is None else list(arguments))
    unwritten = last_words(sys.stdout)
    return _tell(unwritten) if unwritten else code


def _tell(unwritten: OSError) -> int:
    """Say why standard output cannot be written, unless nobody reads it; return the exit code."""
    if isinstance(unwritten, BrokenPipeError):  # as in `hypgen explain ... | head`
        return Exit.READER_IS_GONE
    say(f"error: standard output cannot be written: {unwritten.strerror}")
    return Exit.MISTAKE


def _run(arguments: list[str]) -> int:
    from hypgen.dsl.messages.diagnostic import ModelError
    from hypgen.runtime.builder.errors import BuildError, ToolchainError

    try:
        if instruction := os.environ.get("_HYPGEN_COMPLETE"):
            return shell_complete(group, {}, "hypgen", "_HYPGEN_COMPLETE", instruction)
        # Not `group.main`, which takes signals and closed pipes for its own.
        with group.make_context("hypgen", arguments) as context:
            result = group.invoke(context)
        return int(result) if isinstance(result, int) else Exit.OK
    except click.exceptions.Exit as end:  # of --help and --version
        return end.exit_code
    except click.ClickException as error:
        with contextlib.suppress(OSError):  # as `say` does
            error.show()
    except ModelError as error:
        show_model_error(error)
    except ToolchainError as error:
        say(f"error: {error.message}\nhelp: {error.remedy}")
    except KeyboardInterrupt as error:
        say("interrupted")
        return interrupt_code(error)
    except BuildError as error:
        say(f"error: {error.what} did not compile: this is a bug of hypgen, not of your model")
        say(f"help: please report it with the model and the compiler's log, {error.log}")
        return Exit.BUG
    except Exception as error:
        if isinstance(error, OSError) and (unwritten := last_words(sys.stdout)):
            return _tell(unwritten)
        if os.environ.get("HYPGEN_DEBUG") == "1":
            raise
        if (found := explain(error)) is not None:
            say(f"error: {found[0]}\nhelp: {found[1]}")
            return Exit.MISTAKE
        say(f"error: {type(error).__name__}: {error}: this is a bug of hypgen, not of your model")
        say("help: please report it with the model; HYPGEN_DEBUG=1 shows where it happened")
        return Exit.BUG
    return Exit.MISTAKE
