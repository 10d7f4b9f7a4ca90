# SPDX-License-Identifier: Apache-2.0
"""``hypgen lsp``: a language server for editors."""

from __future__ import annotations

import sys

import click

from hypgen.cli.exit_codes import EXIT_CODES, Exit
from hypgen.cli.output import say


@click.command(epilog=EXIT_CODES)
def command() -> int:
    """Serve an editor over standard input and output, by the language server protocol.

    Editors start it by themselves; docs/guide/editors.md says how. It needs the extra `editor`.

    \b
    Examples:
      hypgen lsp
    """
    try:
        from hypgen.editor.server import make_server
    except ModuleNotFoundError as error:
        if error.name not in ("pygls", "lsprotocol"):
            raise
        say(f"error: `hypgen lsp` needs the package {error.name}")
        say("help: install it: pip install 'hypgen[editor]'")
        return Exit.MISTAKE
    with open(sys.stdout.fileno(), "wb", closefd=False) as output:  # the server closes it when it ends
        make_server().start_io(stdout=output)
    return Exit.OK
