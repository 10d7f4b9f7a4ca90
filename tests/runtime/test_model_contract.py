# SPDX-License-Identifier: Apache-2.0
"""A struct that is not a model fails to compile, with a text that names what it lacks."""

import subprocess
from pathlib import Path

from hypgen.runtime.builder import tools as toolchain

HERE = Path(__file__).parent
INCLUDE = HERE.parents[1] / "runtime" / "include"

# Structs that hide a member of a model, and what the compiler says of each.
LACKING = {
    "struct Wanting {};": "the type Params, Fixed, State or Key is missing",
    "struct Wanting : Tiger { struct State { double x; float y; }; };": "State is not made of 32-bit words",
    "struct Wanting : Tiger { void kActionCount(); };": "kActionCount, kVisibleCount or kVariableCount",
    "struct Wanting : Tiger { static void load(); };": "load is missing or has another signature",
    "struct Wanting : Tiger { static int init_hidden; };": "init_hidden is missing",
    "struct Wanting : Tiger { static int export_state; };": "export_state is missing",
    "struct Wanting : Tiger { static int init_likelihood; };": "init_likelihood has another signature",
    "struct Wanting : CoinSeenFirst { static int weigh_start; };": "and particle units lacks weigh_start",
    "struct Wanting : CoinSeenFirst { static void init_posterior(const Params&, const Fixed&, const State&, "
    "Posterior&); };": "init_posterior of a model with init_likelihood does not return a bool",
    "struct Wanting : Tiger { static int is_legal; };": "is_legal is missing",
    "struct Wanting : Tiger { static int step; };": "step is missing or has another signature",
    "struct Wanting : Tiger { static int observe; };": "observe is missing",
    "struct Wanting : Tiger { static int filter; };": "filter is missing",
    "struct Wanting : Tiger { static int observation_density; };": "observation_density is missing",
    "struct Wanting : Tiger { static double upper(const Params&, const Fixed&, const State&); };": (
        "upper is missing or has another signature"
    ),
    "struct Wanting : Tiger { static int tail; };": "tail is missing",
    "struct Wanting : Tiger { static int lower; };": "kHasLower or lower is missing",
    "struct Wanting : Tiger { static int default_policy; };": "default_policy is missing",
    "struct Wanting : Tiger { static int roll_history; };": "advance_history or roll_history is missing",
    "struct Wanting : Tiger { static int init_posterior; };": "or advance_posterior is missing",
    "struct Wanting : Tiger { using Tracking = Tiger; };": "a model with Tracking lacks kRedrawnWords",
    "struct Wanting : Tiger { static constexpr int kHiddenValues = 1; };": "a model with kHiddenValues lacks",
    "struct Wanting : CoinAndLevel { static int unit_of; };": "a model with kFactored lacks kParticleUnits",
    "struct Wanting : CoinAndLevel { static int put_unit; };": "lacks unit_size, probability or put_unit",
    "struct Wanting : CoinAndLevel { static int copy_unit; };": (
        "lacks Evidence, kUnitValues, see, draw_unit, move_unit, copy_unit or export_unit"
    ),
}


def messages(folder: Path, includes: list[str], text: str) -> str:
    """Return what the compiler says of a source; empty where it compiles."""
    source = folder / "source.cpp"
    headers = "".join(f'#include "{name}"\n' for name in includes)
    source.write_text(headers + text, encoding="utf-8")
    compiler = str(toolchain.find_tools().compiler.path)
    command = [compiler, "-std=c++17", "-fsyntax-only", f"-I{INCLUDE}", f"-I{HERE}", str(source)]
    return subprocess.run(command, capture_output=True, text=True).stderr


def test_models_hold(tmp_path: Path) -> None:
    text = "".join(
        f"static_assert(hypgen::ModelContract<hypgen::testing::{name}>::kHolds);\n"
        for name in ("Tiger", "CoinAndLevel", "CoinSeenFirst", "RockSample<4, 3>")
    )
    assert not messages(tmp_path, ["hypgen/model/model_contract.hpp", "factored_models.hpp"], text)


def test_text_names_what_is_missing(tmp_path: Path) -> None:
    cases = "".join(
        f"namespace case_{i} {{ using namespace hypgen::testing; {struct}\n"
        f"static_assert(hypgen::ModelContract<Wanting>::kHolds); }}\n"
        for i, struct in enumerate(LACKING)
    )
    found = messages(tmp_path, ["hypgen/model/model_contract.hpp", "factored_models.hpp"], cases)
    missing = [text for text in LACKING.values() if text not in found]
    assert not missing, found[:20000]


def test_device_asks_for_parts_of_a_step(tmp_path: Path) -> None:
    text = "static_assert(hypgen::DeviceModelContract<hypgen::testing::Tiger>::kHolds);\n"
    found = messages(tmp_path, ["hypgen/model/model_contract.hpp", "test_models.hpp"], text)
    assert "a model for GPUs lacks kStages" in found


def test_solver_checks_its_model(tmp_path: Path) -> None:
    text = (
        "struct Wanting : hypgen::testing::Tiger { static int filter; };\n"
        "const auto model = hypgen::make_descriptor<Wanting>();\n"
    )
    found = messages(tmp_path, ["hypgen/solver/model_instance.hpp", "test_models.hpp"], text)
    assert "model contract: filter is missing or has another signature" in found
