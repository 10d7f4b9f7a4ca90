# SPDX-License-Identifier: Apache-2.0
"""Finding nvcc and GPUs, with scripts in their place, and choosing what to compile for."""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from support.paths import EXAMPLES

from hypgen.cli import main
from hypgen.runtime.builder import commands, cuda_tools, tools
from hypgen.runtime.builder.cuda_tools import CudaBuild, Nvcc
from hypgen.runtime.builder.errors import ToolchainError
from hypgen.runtime.builder.process_group import ProcessGroup

TIGER = str(EXAMPLES / "tiger.pomdp")
MakeNvcc = Callable[..., Path]


def script(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


@pytest.fixture(autouse=True)
def bare_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine with neither CUDA nor a GPU."""
    for name in ("CUDA_HOME", "CUDA_PATH", "NVCC_CCBIN"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "bin").mkdir()
    for name in ("c++", "g++", "clang++", "as", "ld"):
        if found := shutil.which(name):
            (tmp_path / "bin" / name).symlink_to(found)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr(cuda_tools, "SYSTEM_TOOLKIT", tmp_path / "no-such-toolkit")
    monkeypatch.setattr(cuda_tools, "WSL_SMI", tmp_path / "no-such-program")
    monkeypatch.setattr(cuda_tools, "_wheels", list)
    cuda_tools.find_gpus.cache_clear()
    yield
    cuda_tools.find_gpus.cache_clear()


@pytest.fixture
def make_nvcc(tmp_path: Path) -> MakeNvcc:
    """Makes a toolkit whose nvcc says what it is told to say."""

    def make(
        version: str = "13.0", archs: str = "75 80 90 120", library: str = "lib64", name: str = "cuda"
    ) -> Path:
        root = tmp_path / name
        (root / library).mkdir(parents=True)
        (root / library / "libcudart_static.a").write_text("")
        listed = "; ".join(f"echo compute_{a}" for a in archs.split())
        return script(
            root / "bin" / "nvcc",
            f'case "$*" in --list-gpu-arch) {listed};;\n'
            f"--version) echo Cuda compilation tools, release {version}, V{version}.88;;\n"
            "*) echo 'host_config.h:137: #error -- unsupported GNU version! gcc 15'; exit 1;; esac",
        )

    return make


def gpus(tmp_path: Path, *capabilities: str) -> None:
    lines = "\n".join(f"echo 'NVIDIA X, 580.1, 80 GiB, {c}'" for c in capabilities)
    script(tmp_path / "bin" / "nvidia-smi", lines)


def test_without_nvcc_the_remedy_is_the_extra() -> None:
    with pytest.raises(ToolchainError, match="no nvcc .the CUDA compiler. found") as error:
        cuda_tools.find_nvcc()
    assert "pip install 'hypgen[cuda]'" in error.value.remedy


def test_nvcc_is_looked_for_where_the_user_names_it_first(
    make_nvcc: MakeNvcc, monkeypatch: pytest.MonkeyPatch
) -> None:
    named, home, wheel = (
        make_nvcc(name="named"),
        make_nvcc(name="home"),
        make_nvcc(name="cu13", library="lib"),
    )
    monkeypatch.setattr(cuda_tools, "_wheels", lambda: [wheel.parent.parent])
    found = cuda_tools.find_nvcc()
    assert (found.path, found.library) == (wheel, wheel.parent.parent / "lib")
    assert found.version == "nvcc release 13.0, V13.0.88" and found.architectures == (75, 80, 90, 120)
    monkeypatch.setenv("CUDA_HOME", str(home.parent.parent))
    assert cuda_tools.find_nvcc().path == home
    assert cuda_tools.find_nvcc(str(named)).path == named


def test_an_old_nvcc_is_passed_over_unless_it_is_named(
    make_nvcc: MakeNvcc, monkeypatch: pytest.MonkeyPatch
) -> None:
    old, good = make_nvcc("12.3", name="old"), make_nvcc("12.4", name="good")
    monkeypatch.setenv("CUDA_HOME", str(old.parent.parent))
    with pytest.raises(ToolchainError, match=r"old/bin/nvcc' is too old \(nvcc release 12.3"):
        cuda_tools.find_nvcc()
    monkeypatch.setattr(cuda_tools, "SYSTEM_TOOLKIT", good.parent.parent)
    assert cuda_tools.find_nvcc().path == good
    with pytest.raises(ToolchainError, match="--nvcc: .* is too old") as error:
        cuda_tools.find_nvcc(str(old))
    assert "CUDA 12.4 or newer" in error.value.remedy


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda nvcc: script(nvcc, "exit 1"), "does not run"),
        (lambda nvcc: (nvcc.parent.parent / "lib64" / "libcudart_static.a").unlink(), "has no libcudart"),
        (lambda nvcc: nvcc.unlink(), "is not a program"),
    ],
)
def test_an_nvcc_that_cannot_be_used_says_why(
    spoil: Callable[[Path], object], message: str, make_nvcc: MakeNvcc
) -> None:
    nvcc = make_nvcc()
    spoil(nvcc)
    with pytest.raises(ToolchainError, match=message):
        cuda_tools.find_nvcc(str(nvcc))


def test_auto_is_cuda_where_there_is_a_gpu_and_an_nvcc(
    tmp_path: Path, make_nvcc: MakeNvcc, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cuda_tools.choose() == cuda_tools.Choice(None)
    gpus(tmp_path, "9.0")
    cuda_tools.find_gpus.cache_clear()
    choice = cuda_tools.choose()
    assert choice.build is None and choice.note.startswith("the GPU is left unused: no nvcc")
    with pytest.raises(ToolchainError, match="no nvcc"):
        cuda_tools.choose("both")
    monkeypatch.setenv("CUDA_HOME", str(make_nvcc().parent.parent))
    build = cuda_tools.choose().build
    assert build is not None and build.architectures == (90,)
    assert cuda_tools.choose("cpu").build is None


@pytest.mark.parametrize(
    ("arch", "here", "expected"),
    [
        ("", (), (75, 80, 90)),
        ("all", (), (75, 80, 90, 120)),
        ("sm_90,sm_80", (), (80, 90)),
        ("", ("8.0",), (80,)),
        ("native", ("9.0", "8.0", "9.0"), (80, 90)),
        ("native", ("8.6",), (80,)),  # the newest that this nvcc knows and the GPU runs
    ],
)
def test_architectures(
    arch: str, here: tuple[str, ...], expected: tuple[int, ...], tmp_path: Path, make_nvcc: MakeNvcc
) -> None:
    gpus(tmp_path, *here)
    nvcc = cuda_tools.find_nvcc(str(make_nvcc()))
    assert cuda_tools.architectures_of(arch, nvcc) == expected


@pytest.mark.parametrize(
    ("arch", "here", "message", "remedy"),
    [
        ("sm_20", (), "does not support sm_20", "sm_75, sm_80, sm_90, sm_120"),
        ("90", (), "'90' is not understood", "native, all, or a list"),
        ("native", (), "has no GPU", "for example --arch sm_90"),
        ("native", ("7.0",), r"no longer supports this machine's NVIDIA X \(sm_70\)", "--target cpu"),
    ],
)
def test_a_wrong_architecture(
    arch: str, here: tuple[str, ...], message: str, remedy: str, tmp_path: Path, make_nvcc: MakeNvcc
) -> None:
    gpus(tmp_path, *here)
    with pytest.raises(ToolchainError, match=message) as error:
        cuda_tools.architectures_of(arch, cuda_tools.find_nvcc(str(make_nvcc())))
    assert remedy in error.value.remedy


def test_the_newest_architecture_is_also_given_as_ptx(monkeypatch: pytest.MonkeyPatch) -> None:
    build = CudaBuild(Nvcc(Path("nvcc"), "nvcc", Path("lib"), (80, 90)), (80, 90))
    command = cuda_tools.nvcc_command(build, ["-O3"], Path("g++"), ["-std=c++17", "-fPIC"])
    assert [word for word in command if word.startswith("-gencode")] == [
        "-gencode=arch=compute_80,code=sm_80",
        "-gencode=arch=compute_90,code=sm_90",
        "-gencode=arch=compute_90,code=compute_90",
    ]
    assert command[-3:] == ["-ccbin", "g++", "-Xcompiler=-fPIC"]
    monkeypatch.setenv("NVCC_CCBIN", "g++-13")
    assert "-ccbin" not in cuda_tools.nvcc_command(build, [], Path("g++"), [])


def test_a_host_flag_with_a_comma_stays_one() -> None:
    build = CudaBuild(Nvcc(Path("nvcc"), "nvcc", Path("lib"), (90,)), (90,))
    command = cuda_tools.nvcc_command(build, [], Path("g++"), ["-fsanitize=address,undefined"])
    assert command[-1] == r"-Xcompiler=-fsanitize=address\,undefined"


def call(command: list[str], build: CudaBuild) -> None:
    with ProcessGroup() as group:
        commands.call(group, command, "the model", tools.find_tools(), build)


def test_a_host_compiler_that_nvcc_does_not_take_is_named(
    make_nvcc: MakeNvcc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(tmp_path / "cache"))
    build = CudaBuild(cuda_tools.find_nvcc(str(make_nvcc())), (90,))
    with pytest.raises(ToolchainError, match="its host compiler: unsupported GNU version; see") as error:
        call([str(build.nvcc.path), "-c"], build)
    assert "NVCC_CCBIN" in error.value.remedy and "--nvcc" in error.value.remedy


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("nvcc error   : 'cicc' died due to signal 9 (Kill signal)", "the compiler was killed"),
        ("/tmp/x.ii: No space left on device", "the disk is full"),
    ],
)
def test_a_machine_at_its_limits_is_told_from_a_bug(
    output: str, message: str, make_nvcc: MakeNvcc, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HYPGEN_CACHE_DIR", str(tmp_path / "cache"))
    build = CudaBuild(cuda_tools.find_nvcc(str(make_nvcc())), (90,))
    script(build.nvcc.path, f'echo "{output}"; exit 1')
    with pytest.raises(ToolchainError, match=message):
        call([str(build.nvcc.path), "-c"], build)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--target", "cuda"], "error: no nvcc"),
        (["--target", "gpu"], "'gpu' is not one of"),
        (["--target", "cpu", "--arch", "sm_90"], "leave out --target cpu"),
        (["--nvcc", "no-such-nvcc"], "error: --nvcc: 'no-such-nvcc' is not a program"),
    ],
)
def test_a_users_mistake_ends_with_2(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["compile", TIGER, *options]) == 2
    assert message in capsys.readouterr().err


def test_doctor_says_how_to_get_cuda_and_does_not_insist(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["doctor"]) == 0
    output = capsys.readouterr().out
    assert "no nvcc (the CUDA compiler) found; solvers run on the CPU" in output
    assert "help: for solvers that use a GPU, run `pip install 'hypgen[cuda]'`" in output


@pytest.mark.parametrize(
    ("target", "arch", "expected"),
    [
        ("cuda", "", (75, 80, 90)),
        ("both", "all", cuda_tools.ALL_ARCHITECTURES),
        ("auto", "sm_90,sm_80", (80, 90)),
        ("auto", "", None),
        ("cpu", "", None),
    ],
)
def test_what_is_compiled_elsewhere_needs_no_nvcc_here(
    target: str, arch: str, expected: tuple[int, ...] | None
) -> None:
    assert cuda_tools.architectures_to_emit(target, arch) == expected


def test_an_nvcc_of_this_machine_says_what_it_knows(
    monkeypatch: pytest.MonkeyPatch, make_nvcc: MakeNvcc
) -> None:
    monkeypatch.setenv("CUDA_HOME", str(make_nvcc().parent.parent))
    assert cuda_tools.architectures_to_emit("cuda", "all") == (75, 80, 90, 120)


def test_a_project_for_gpus_is_written_without_an_nvcc(tmp_path: Path) -> None:
    project = tmp_path / "project"
    code = main.run(["compile", TIGER, "--target", "cuda", "--emit-only", "-o", str(project)])
    assert code == 0
    written = "".join(path.read_text() for path in project.glob("*.cmake"))
    assert "set(HYPGEN_CUDA ON" in written and '"75;80;90"' in written
