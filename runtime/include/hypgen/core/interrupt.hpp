// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, for programs that then finish what they have begun.
#pragma once

namespace hypgen {

// From now on the first interrupt is remembered, and the second ends the process.
void catch_interrupts();

// Whether there was one since.
bool interrupted();

}  // namespace hypgen
