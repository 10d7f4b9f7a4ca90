"""``hypgen inspect``: what each stage of the compiler makes of a model."""

from __future__ import annotations

from pathlib import Path

import click

from hypgen.cli.common import EXIT_CODES, Exit, load, model_options

STAGES = ("ast", "ir", "stages", "layout", "cpp")


@click.command(epilog=EXIT_CODES)
@model_options
@click.option(
    "--stage",
    type=click.Choice(STAGES),
    default="ir",
    show_default=True,
    help="ast: the text's structure. ir: the checked, typed model. stages: the order of updates. "
    "layout: how states are packed. cpp: the generated C++.",
)
def command(model: Path, instance: Path | None, settings: tuple[str, ...], stage: str) -> int:
    """Print what a stage of the compiler makes of MODEL.

    \b
    Examples:
      hypgen inspect examples/tiger.pomdp --stage ir
      hypgen inspect examples/rock_sample.pomdp --stage layout
      hypgen inspect examples/tag.pomdp --stage cpp | less
    """
    click.echo(_dump(model, instance, settings, stage).rstrip("\n"))
    return Exit.OK


def _dump(path: Path, instance: Path | None, settings: tuple[str, ...], stage: str) -> str:
    """Return the text of one stage."""
    loaded = load(path, instance, settings)
    if stage in ("ast", "ir"):
        from hypgen.cli.dump import dump

        return dump(loaded.ast if stage == "ast" else loaded.model)
    if stage == "cpp":
        from hypgen.codegen import driver

        files = driver.generate(loaded.model)
        return "\n".join(
            f"// {name}\n\n{text}" for name, text in sorted(files.items()) if name.startswith("src/")
        )
    from hypgen.codegen import inspect

    return inspect.layout(loaded.model) if stage == "layout" else inspect.stages(loaded.model)
