// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/program_main.hpp"

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <utility>

#include "hypgen/core/program.hpp"
#include "hypgen/embed/serve.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/solver/solver_main.hpp"

namespace hypgen {

namespace {

bool read_line(std::string& line) { return static_cast<bool>(std::getline(std::cin, line)); }

int serve_agent(EmbeddedModel model, const SolverOptions& options) {
  const std::string name = model.descriptor.name;
  std::string error;
  ParamValues values(model.descriptor.params);
  if (!options.param_file.empty() &&
      !read_param_file(options.param_file, model.descriptor.params, values, error))
    return complain(name, error, kWrongUse);
  Status status = Status::kOk;
  const auto agent = Agent::create(std::move(model), options, values, status, error);
  if (!agent) return complain(name, error, status == Status::kWrongArgument ? kWrongUse : kFailed);
  if (!agent->device_problem().empty())
    complain(name, agent->device_problem() + "; planning on the CPU", kDone);
  let_writes_fail();
  Output out("-", Output::Kind::kLines);
  const auto write_line = [&](const std::string& line) { return out.write(line + "\n"); };
  if (!serve(*agent, read_line, write_line)) return complain(name, out);
  return std::cin.bad() ? complain(name, "standard input cannot be read", kFailed) : kDone;
}

}  // namespace

int program_main(EmbeddedModel model, int argc, char** argv) {
  // solver_main reads the options itself, and may look for a GPU as it does.
  const bool may_serve =
      std::any_of(argv, argv + argc, [](const char* word) { return std::string(word) == "--serve"; });
  if (!may_serve) return solver_main(model.descriptor, argc, argv);
  SolverOptions options;
  std::string error;  // of wrong options solver_main tells
  const bool is_right = parse_options(argc, argv, this_machine(model.descriptor.device), options, error);
  if (!is_right || !options.serve || options.help || options.version)
    return solver_main(model.descriptor, argc, argv);
  const std::string name = model.descriptor.name;
  try {
    return serve_agent(std::move(model), options);
  } catch (const std::exception& problem) {
    return complain(name, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen
