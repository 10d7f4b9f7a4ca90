# SPDX-License-Identifier: Apache-2.0
"""C++ names of what the model names: verbatim, unless C++, a macro or the generated struct has them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from hypgen.codegen.layout.history_layout import belief_reads, fields
from hypgen.dsl import ir
from hypgen.dsl.ir.draw_words import words_of
from hypgen.dsl.types import Enum, Record


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


KEYWORDS = _words(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t
    char32_t class compl concept const const_cast consteval constexpr constinit continue co_await
    co_return co_yield decltype default delete do double dynamic_cast else enum explicit export
    extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq
    nullptr operator or or_eq private protected public register reinterpret_cast requires return
    short signed sizeof static static_assert static_cast struct switch template this thread_local
    throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while
    xor xor_eq
    """
)

# Namespaces of generated code, and macros of headers in small letters.
_TAKEN = _words(
    """
    std hypgen math dist bits models D Real main linux unix assert assert_perror errno stdin stdout stderr
    alloca offsetof signbit isnan isinf isfinite issubnormal math_errhandling strdupa strndupa
    sched_priority sigmask sigaction major minor makedev
    """
)
# Most macros have names in capitals, too many to list and others on each system; one letter is none.
_MACRO = re.compile(r"[A-Z][A-Z0-9_]+|[LMP]_\w+|(?:hypgen|pthread)_\w+|[bl]e\d\dtoh|hto[bl]e\d\d")

# What the generated struct is made of.
_CONCEPT = _words(
    """
    Key KeyReader KeyWriter WideKey words_of
    ParamValues StepResult Params Fixed State Site Joint kActionCount kVisibleCount
    kVariableCount kHasLower kLooksUpPolicy kLeastReward kRewardBits kRewardsFit
    kKeyHoldsState kKeyIsContinuous observation_density
    init_visible init_hidden first_value export_visible
    import_visible init_likelihood weigh_start
    export_state is_legal is_terminal is_success step observe filter default_policy choose first_legal lower
    upper tail load joint History NoHistory kHasHistory init_history advance_history roll_history
    declared_upper relaxation exact groups
    remember Posterior NotFactored kFactored kExactUnits kParticleUnits init_posterior advance_posterior
    Part kStages kMaxWarps step_stage step_rewards step_end
    advance_visible unit_size unit_of probability put_unit posteriors
    moments Evidence kUnitValues see draw_unit move_unit copy_unit export_unit
    kHiddenValues hidden_size hidden_value put_hidden init_density weigh_hidden
    """
)

PARAMETERS = _words(
    "params fixed state next draws action key value in out error values weight rest chosen result"
    " history after now weights unit variable seen to_fixed to_state stage part sum run last"
    " FixedWord Tracking redrawn_word is_word_read"
)


def snake_case(name: str) -> str:
    """Return ``RockSample`` as ``rock_sample``."""
    spaced = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", name))
    return spaced.lower()


def base_name(path: str) -> str:
    """Return a model file's name without its folders, fit for a C++ comment."""
    return re.sub(r"[^\w.+ -]", "_", path.replace("\\", "/").rsplit("/", 1)[-1])


def file_stem(model: ir.Model) -> str:
    """Return the name of the model's header and of its executable."""
    stem = snake_case(model.name)
    # Names that a build directory uses itself.
    return f"{stem}_model" if stem in {"hypgen", "cmakefiles", "testing", "src"} else stem


def _is_taken(name: str) -> bool:
    return name in KEYWORDS or name in _TAKEN or name in _CONCEPT or _MACRO.fullmatch(name) is not None


@dataclass
class Scope:
    """Names taken in one C++ scope; ``prefixed`` ones begin as nothing of C++ does."""

    taken: set[str] = field(default_factory=set)
    prefixed: bool = False

    def unique(self, name: str) -> str:
        """Return ``name``, with an underscore if C++ has taken it or a number if the model has; take it.

        What follows a ``%`` tells locals of the IR apart and is left out.
        """
        name = name.partition("%")[0].replace(".", "_").replace(":", "_")
        if not self.prefixed and _is_taken(name):
            name += "_"
        found, number = name, 2
        while found in self.taken:
            found, number = f"{name}_{number}", number + 1
        self.taken.add(found)
        return found


class Names:
    """The C++ names of one model's declarations."""

    def __init__(self, model: ir.Model) -> None:
        self.model = Scope().unique(model.name)
        self.struct = Scope({*PARAMETERS, self.model})
        coded: list[Enum | Record] = [*model.enums, *model.records]
        self.types = {t.name: self.struct.unique(t.name) for t in coded}
        self.members = {t.name: self._type_members(t) for t in coded}
        self.tables = {t.name: self.struct.unique(t.name) for t in model.tables}
        self.functions = {f.name: self.struct.unique(f.name) for f in model.functions}
        self.lets = {e.name: self.struct.unique(e.name) for e in model.all_lets}
        accessors = Scope({"words"})
        self.variables = {v.name: accessors.unique(v.name) for v in model.variables}
        self.setters = {v.name: accessors.unique(f"set_{v.name}") for v in model.variables}
        arrays = [v.name for v in model.variables if v.indices]
        self.bits = {v: accessors.unique(f"{v}_bits") for v in arrays}
        self.bits_setters = {v: accessors.unique(f"set_{v}_bits") for v in arrays}
        kept = Scope({"words"})
        self.history = {f.key: kept.unique(f.name) for f in fields(model)}
        self.beliefs = {n: self.struct.unique(f"belief_{n}") for n in belief_reads(model)}
        self.history_setters = {f.key: kept.unique(f"set_{f.name}") for f in fields(model)}
        self._params = Scope()
        self.params = {p.name: self._params.unique(p.name) for p in model.params}
        sites = Scope({"Site"})
        self.sites = {site.path: sites.unique(site.path) for site in sites_of(model)}
        self.action = self.struct.unique(model.action.name)

    @staticmethod
    def _type_members(type_: Enum | Record) -> dict[str, str]:
        """Name an enum's constants, constructors (``check``), tests (``is_check``) and arguments."""
        scope = Scope({type_.name})
        if isinstance(type_, Record):
            return {"make": scope.unique("make"), **{n: scope.unique(n) for n, _ in type_.fields}}
        result = {v.name: scope.unique(v.name) for v in type_.variants}
        for v in type_.variants:
            if v.argument is not None:
                result[f"is {v.name}"] = scope.unique(f"is_{v.name}")
                result[f"of {v.name}"] = scope.unique(f"argument_of_{v.name}")
        return result

    def derived_table(self, base: str) -> str:
        """Name a table that is computed when params are loaded."""
        return self._params.unique(base)

    def locals(self) -> Scope:
        """Return a scope for one function's locals; names of the struct stay visible in it."""
        return Scope(set(self.struct.taken))


def sites_of(model: ir.Model) -> tuple[ir.Site, ...]:
    """Return the sites of all declarations that draw, in the order of the file's parts."""
    found = [
        *(a.site for a in (*model.inits, *model.updates) if words_of(a.dist)),
        *(let.site for let in model.all_lets if words_of(let.dist)),
        *(o.site for o in model.observations if words_of(o.dist)),
    ]
    if model.policy is None:
        found.append(ir.Site("policy:default"))
    elif words_of(model.policy.dist):
        found.append(model.policy.site)
    return tuple(found)
