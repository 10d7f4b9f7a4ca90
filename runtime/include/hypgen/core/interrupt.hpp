// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, SIGTERM and SIGHUP, for programs that then finish what they have begun.
#pragma once

namespace hypgen {

// From now on the first of these signals is remembered, and a second one ends the process. One that comes within
// a tenth of a second counts as the first: `timeout` and shells send theirs twice. What was ignored at the start
// (`nohup`, a shell's background) stays so.
void catch_interrupts();

// Whether there was one since.
bool interrupted();

// 128 and the signal's number: how a program ends after an interrupt.
int interrupt_code();

}  // namespace hypgen
