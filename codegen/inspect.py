"""Codegen's stages as text, for people: how state is packed and how updates are split up."""

from __future__ import annotations

from hypgen.codegen.layout import Block, pack
from hypgen.codegen.partition import partition
from hypgen.dsl import ir
from hypgen.dsl.types import size_of


def layout(model: ir.Model) -> str:
    """Return a table of the words and bits of every variable."""
    packed = pack(model)
    lines = []
    for name, note, block in (
        ("Fixed", "stored once a scenario", packed.fixed),
        ("State", "copied by every step", packed.state),
    ):
        size = f"{block.words * 4} bytes" if block.fields else "empty"
        lines += [f"{name}: {size}, {note}", *_table(block), ""]
    return "\n".join(lines)


def _table(block: Block) -> list[str]:
    rows = [("variable", "type", "word", "bits")]
    for field in block.fields:
        dims = ", ".join(map(str, field.indices))
        name = f"{field.variable}[{dims}]" if field.indices else field.variable
        last = field.shift + field.length * field.width - 1
        if field.width == 0:
            where = ("-", "none: one value")
        elif last < 32:
            where = (str(field.word), f"{field.shift} .. {last}")
        else:
            where = (f"{field.word} .. {field.word + last // 32}", f"{32 // field.width} a word")
        count = f", {field.length} x {field.width}" if field.indices and field.width else ""
        rows.append((name, str(field.type), where[0], where[1] + count))
    if len(rows) == 1:
        return []
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    return ["  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in rows]


def stages(model: ir.Model) -> str:
    """Return the element updates of each stage; those of one stage are independent of each other."""
    lines = []
    for number, stage in enumerate(partition(model)):
        lines.append(f"stage {number}")
        for update in stage:
            element = update.element
            members = f"[{element.binder.name} in {element.binder.type}]" if element.binder else ""
            count = f", {size_of(element.binder.type)} members" if element.binder else ""
            lines.append(f"  {element.name}{members}{count}")
            for assign in update.assigns:
                reads = f"  after {', '.join(sorted(assign.reads))}" if assign.reads else ""
                seen = "  (seen: the filter takes it from the key)" if update.observed else ""
                lines.append(f"    {assign.variable.rsplit('.', 1)[-1]}'{reads}{seen}")
    return "\n".join(lines) + "\n"
