# SPDX-License-Identifier: Apache-2.0
"""Kernels' text as a host compiler reads it: launches become calls, and memory of a block a pointer."""

import re

_LAUNCH = re.compile(r"(\w+<[\w:, ]+>)\s*<<<(.*?)>>>\((.*?)\);", re.DOTALL)
_DYNAMIC = re.compile(r"extern __shared__ __align__\(16\) unsigned char (\w+)\[\];")
_BARRIER = re.compile(r'asm volatile\("barrier\.sync 1, %0;".*?\);')


def on_cpu(text: str) -> str:
    """Return the text of a header with kernels, to be compiled with ``cuda_runtime_api.h`` of this folder."""
    text = _LAUNCH.sub(r"::cuda_on_cpu::Launch(\2).run([&] { \1(\3); });", text)
    text = _DYNAMIC.sub(r"unsigned char* const \1 = ::cuda_on_cpu::dynamic_shared();", text)
    return _BARRIER.sub("::cuda_on_cpu::machine().barrier(1);", text)
