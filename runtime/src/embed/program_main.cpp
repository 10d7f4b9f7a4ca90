// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/program_main.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <utility>

#include "hypgen/embed/serve.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/solver/solver_main.hpp"

namespace hypgen {

namespace {

bool read_line(std::string& line) { return static_cast<bool>(std::getline(std::cin, line)); }

bool write_line(const std::string& line) {
  return std::fprintf(stdout, "%s\n", line.c_str()) >= 0 && std::fflush(stdout) == 0;
}

int serve_agent(EmbeddedModel model, const SolverOptions& options) {
  const std::string name = model.descriptor.name;
  const auto complain = [&](const std::string& text, int code) {
    std::fprintf(stderr, "%s: %s\n", name.c_str(), text.c_str());
    return code;
  };
  std::string error;
  ParamValues values(model.descriptor.params);
  if (!options.param_file.empty() &&
      !read_param_file(options.param_file, model.descriptor.params, values, error))
    return complain(error, 2);
  Status status = Status::kOk;
  const auto agent = Agent::create(std::move(model), options, values, status, error);
  if (!agent) return complain(error, status == Status::kWrongArgument ? 2 : 1);
  if (!agent->device_problem().empty()) complain(agent->device_problem() + "; planning on the CPU", 0);
  std::signal(SIGPIPE, SIG_IGN);  // a write that fails says so
  if (!serve(*agent, read_line, write_line)) return complain("standard output cannot be written", 1);
  return std::cin.bad() ? complain("standard input cannot be read", 1) : 0;
}

}  // namespace

int program_main(EmbeddedModel model, int argc, char** argv) {
  // solver_main reads the options itself, and may look for a GPU as it does.
  const bool may_serve =
      std::any_of(argv, argv + argc, [](const char* word) { return std::string(word) == "--serve"; });
  if (!may_serve) return solver_main(model, argc, argv);
  SolverOptions options;
  std::string error;  // of wrong options solver_main tells
  const bool is_right = parse_options(argc, argv, this_machine(model.descriptor.device), options, error);
  if (!is_right || !options.serve || options.help || options.version) return solver_main(model, argc, argv);
  const std::string name = model.descriptor.name;
  try {
    return serve_agent(std::move(model), options);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s: internal error: %s\n", name.c_str(), problem.what());
    return 1;
  }
}

}  // namespace hypgen
