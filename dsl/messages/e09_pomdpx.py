# SPDX-License-Identifier: Apache-2.0
"""Texts of E0902 to E0912 about files in POMDPX."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hypgen.dsl.messages.diagnostic import Diagnostic, did_you_mean
from hypgen.dsl.messages.source import Span


def unknown_variable(name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A variable that is not declared."""
    remedy = did_you_mean(name, known) or "declare it in <Variable>"
    return Diagnostic("E0902", f"there is no variable '{name[:30]}'", span, remedy)


def unknown_reward(name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A reward that is not declared."""
    remedy = did_you_mean(name, known) or "declare it as <RewardVar>"
    return Diagnostic("E0902", f"there is no reward '{name[:30]}'", span, remedy)


def unknown_value(variable: str, value: str, known: Sequence[str], span: Span) -> Diagnostic:
    """A value that a variable lacks."""
    remedy = did_you_mean(value, known) or f"its values are {', '.join(known[:5])}"
    return Diagnostic("E0902", f"'{variable}' has no value '{value[:30]}'", span, remedy)


def not_of_table(name: str, known: Iterable[str], span: Span) -> Diagnostic:
    """A variable in a diagram that is neither the table's own nor a parent."""
    remedy = did_you_mean(name, known) or "name it in <Parent>"
    return Diagnostic("E0902", f"'{name[:30]}' is no variable of this table", span, remedy)


def unknown_template(span: Span) -> Diagnostic:
    """A template that the diagram lacks."""
    return Diagnostic("E0902", "there is no template of this name", span, "add <SubDAGTemplate> with it")


def wrong_instance(has: int, variables: Sequence[str], span: Span) -> Diagnostic:
    """An entry that names another number of values than the table has variables."""
    message = f"<Instance> names {has} values, and there are {len(variables)} variables"
    return Diagnostic("E0903", message, span, f"name one of each: {' '.join(variables)}")


def misplaced_identity(span: Span) -> Diagnostic:
    """``identity`` where no two variables have the same values."""
    message = "'identity' needs two '-' of like variables"
    return Diagnostic("E0903", message, span, "give the numbers")


def wrong_count(tag: str, has: int, takes: int, span: Span) -> Diagnostic:
    """An entry with another number of numbers than it stands for."""
    message = f"<{tag}> has {has} numbers and takes {takes}"
    return Diagnostic("E0903", message, span, "give one for each combination of the values marked '-'")


def rows_missing(row: str, number: int, span: Span) -> Diagnostic:
    """Rows without any probability, ``number`` of them."""
    more = f" and {number - 1} more rows" if number > 2 else " and 1 more row" if number == 2 else ""
    remedy = "give them, in an <Entry> of its own or with '*'"
    return Diagnostic("E0905", f"there are no probabilities of {row}{more}", span, remedy)


def no_probability(word: str, span: Span) -> Diagnostic:
    """Another word where a probability is expected."""
    return Diagnostic("E0906", f"'{word[:30]}' is no probability", span, "give one from 0 to 1")


def no_number(word: str, span: Span) -> Diagnostic:
    """Another word where a number is expected."""
    return Diagnostic("E0906", f"'{word[:30]}' is no number", span, "correct it")


def wrong_discount(text: str, span: Span) -> Diagnostic:
    """A discount that is no number from 0 to 1."""
    return Diagnostic("E0908", f"the discount is '{text[:30]}'", span, "give one from 0 to 1")


def malformed(reason: str, is_cut: bool, span: Span) -> Diagnostic:
    """A text that is no XML; ``is_cut`` tells whether it may be only the beginning of one."""
    remedy = "complete the file, which may be cut off" if is_cut else "correct the XML"
    return Diagnostic("E0909", f"this is no well-formed XML: {reason}", span, remedy)


def deep_diagram(span: Span) -> Diagnostic:
    """A decision diagram of too many levels."""
    remedy = "a template may not lead to itself"
    return Diagnostic("E0910", "the diagram is nested too deep", span, remedy)


def refused_declaration(span: Span) -> Diagnostic:
    """A document type or an entity."""
    message = "a document type or an entity is declared, which is refused: entities can grow without limit"
    return Diagnostic("E0910", message, span, "remove the declaration")


def deep_elements(most: int, span: Span) -> Diagnostic:
    """Elements of too many levels."""
    message = f"elements are nested more than {most} levels deep"
    return Diagnostic("E0910", message, span, "share parts as templates")


def other_root(tag: str, span: Span) -> Diagnostic:
    """A document of another kind."""
    return Diagnostic("E0911", f"the document's element is '{tag}'", span, "it has to be <pomdpx>")


def lacks_part(tag: str, what: str, instead: str | None, span: Span) -> Diagnostic:
    """An element without a part, ``what``; ``instead`` is a part with a similar name, if there is one."""
    remedy = f"add {what} to it"
    if instead is not None:
        remedy = f"did you mean {what} where <{instead}> stands?"
    return Diagnostic("E0911", f"<{tag}> lacks {what}", span, remedy)


def nameless(tag: str, span: Span) -> Diagnostic:
    """A variable without a name."""
    return Diagnostic("E0911", f"<{tag}> has no name", span, "give it a name of its own")


def duplicate_name(name: str, span: Span) -> Diagnostic:
    """A variable whose name is taken."""
    return Diagnostic("E0911", f"the name '{name}' is taken", span, "give it a name of its own")


def duplicate_value(span: Span) -> Diagnostic:
    """A variable's value that is listed twice."""
    return Diagnostic("E0911", "<ValueEnum> names a value twice", span, "correct it")


def no_value(span: Span) -> Diagnostic:
    """A list of a variable's values that is empty."""
    return Diagnostic("E0911", "<ValueEnum> names no value", span, "correct it")


def no_size(tag: str, text: str, most: int, span: Span) -> Diagnostic:
    """A variable whose number of values is missing or no number."""
    message = f"<{tag}> says not how many values there are, or says '{text[:20]}'"
    return Diagnostic("E0911", message, span, f"give it <NumValues> from 1 to {most}, or <ValueEnum>")


def duplicate_parent(name: str, span: Span) -> Diagnostic:
    """A parent that is listed twice."""
    return Diagnostic("E0911", f"'{name}' is a parent twice", span, "name it once")


def misplaced_law(variable: str, tag: str, span: Span) -> Diagnostic:
    """A law of a variable that is none of the function's."""
    remedy = "name the variable as it is called there, before or after the step"
    return Diagnostic("E0911", f"'{variable}' has no law in <{tag}>", span, remedy)


def law_missing(variable: str, tag: str, span: Span) -> Diagnostic:
    """A variable without a law."""
    return Diagnostic("E0911", f"<{tag}> says nothing of '{variable}'", span, "add a <CondProb> of it")


def wrong_parent(variable: str, parent: str, span: Span) -> Diagnostic:
    """A parent that a law cannot have."""
    message = f"'{variable}' cannot depend on '{parent}' here"
    return Diagnostic("E0911", message, span, "remove that parent")


def circular_laws(span: Span) -> Diagnostic:
    """State variables whose laws need each other."""
    message = "state variables depend on each other in a circle"
    return Diagnostic("E0911", message, span, "remove a parent")


def incomplete_entry(tag: str, lacks: str, span: Span) -> Diagnostic:
    """An entry without its part ``lacks``; its numbers are in an element ``tag``."""
    message = f"<Entry> lacks <{lacks}>"
    return Diagnostic("E0911", message, span, f"give it <Instance> and <{tag}>")


def no_diagram(span: Span) -> Diagnostic:
    """A parameter that is said to be a diagram and has none."""
    return Diagnostic("E0911", "<Parameter> of type DD lacks <DAG>", span, "add it")


def unknown_parameter(kind: str, span: Span) -> Diagnostic:
    """A parameter of another type than a table or a diagram."""
    return Diagnostic("E0911", f"a <Parameter> has the type '{kind[:20]}'", span, "give it TBL or DD")


def misplaced_element(tag: str, span: Span) -> Diagnostic:
    """Another element within a diagram."""
    return Diagnostic("E0911", f"<{tag}> cannot stand here", span, "use Node, Terminal or SubDAG")


def misplaced_sub_diagram(kind: str, span: Span) -> Diagnostic:
    """A sub-diagram of another type than can stand there."""
    message = f"a <SubDAG> of type '{kind[:20]}' cannot stand here"
    return Diagnostic("E0911", message, span, "correct its type")


def misplaced_persistent(span: Span) -> Diagnostic:
    """``persistent`` for a variable that does not depend on what it was."""
    message = "'persistent' needs the variable before the step as a parent"
    return Diagnostic("E0911", message, span, "name it")


def many_rows(sizes: Sequence[int], most: int, span: Span) -> Diagnostic:
    """More rows of a table that differ than can be imported."""
    message = f"a table of {' x '.join(map(str, sizes))} rows has more than {most} to write down"
    return Diagnostic("E0912", message, span, "make the model smaller, or split the variables")


def many_rewrites(span: Span) -> Diagnostic:
    """Entries that write too many numbers, those that are written again included."""
    message = "entries are written again and again, millions of them"
    return Diagnostic("E0912", message, span, "write each entry once")


def large_entry(most: int, span: Span) -> Diagnostic:
    """An entry that stands for too many combinations."""
    return Diagnostic("E0912", f"an entry stands for more than {most}", span, "write them apart")
