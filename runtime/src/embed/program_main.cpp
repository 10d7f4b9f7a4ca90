// SPDX-License-Identifier: Apache-2.0
#include "hypgen/embed/program_main.hpp"

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <utility>

#include "../model/input_text.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/embed/serve.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/solver/solver_main.hpp"

namespace hypgen {

namespace {

enum class Input { kOpen, kEnded, kTooLong };

// The next line of standard input, as far as memory for it is bounded.
Input read_line(std::string& line, std::size_t most) {
  line.clear();
  for (int byte = std::cin.get(); byte != std::char_traits<char>::eof(); byte = std::cin.get()) {
    if (byte == '\n') return Input::kOpen;
    if (line.size() == most) return Input::kTooLong;
    line += static_cast<char>(byte);
  }
  return line.empty() ? Input::kEnded : Input::kOpen;
}

int serve_agent(EmbeddedModel model, const SolverOptions& options) {
  const std::string name = model.descriptor.name;
  const std::size_t most = most_input(value_count(model.visible) + value_count(model.seen));
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
  Input input = Input::kOpen;
  const auto read = [&](std::string& line) { return (input = read_line(line, most)) == Input::kOpen; };
  const auto write_line = [&](const std::string& line) { return out.write(line + "\n"); };
  if (!serve(*agent, read, write_line)) return complain(name, out);
  if (input == Input::kTooLong)
    return complain(name, "a request is larger than " + megabytes(most), kWrongUse);
  return std::cin.bad() ? complain(name, "standard input cannot be read", kFailed) : kDone;
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
    return complain(name, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen
