// SPDX-License-Identifier: Apache-2.0
#include "hypgen/core/program.hpp"

#include <csignal>
#include <cstdio>

namespace hypgen {

void let_writes_fail() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

int complain(const std::string& name, const std::string& message, int code) {
  std::fprintf(stderr, "%s: %s\n", name.c_str(), message.c_str());
  return code;
}

int complain(const std::string& name, const Output& out) {
  return out.reader_is_gone() ? kReaderIsGone : complain(name, out.problem(), kFailed);
}

int print(const std::string& name, const std::string& text, const std::string& file) {
  Output out(file, Output::Kind::kWhole);
  return out.write(text) && out.close() ? kDone : complain(name, out);
}

}  // namespace hypgen
