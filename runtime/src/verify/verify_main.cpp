// SPDX-License-Identifier: Apache-2.0
#include "hypgen/verify/verify_main.hpp"

#include <exception>
#include <new>
#include <string>

#include "../solver/option_table.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/model/params.hpp"
#include "hypgen/solver/options.hpp"
#include "verify_options.hpp"

namespace hypgen {

namespace {

int verify(const VerifiableModel& model, int argc, char** argv) {
  const ModelDescriptor& descriptor = model.descriptor;
  VerifyOptions options;
  std::string error;
  if (!parse_options(argc, argv, this_machine(descriptor.device).cores, options, error))
    return complain(model.descriptor.name, error, kWrongUse);
  if (options.help) return print(descriptor.name, verify_help(descriptor, argv[0]));
  if (options.version) return print(descriptor.name, version_text(descriptor));
  if (options.beliefs.belief == BeliefKind::kFactored && !descriptor.factored) {
    return complain(model.descriptor.name,
                    "--belief: this model's belief does not factor; hypgen explain says why", kWrongUse);
  }
  if (options.beliefs.episodes > 0 && descriptor.hidden_variables.empty())
    return complain(model.descriptor.name, "--check-beliefs: this model has no hidden variables", kWrongUse);
  ParamValues values(descriptor.params);
  if (!options.param_file.empty() && !read_param_file(options.param_file, descriptor.params, values, error))
    return complain(model.descriptor.name, error, kWrongUse);
  if (!check_complete(descriptor.params, values, error))
    return complain(model.descriptor.name, error, kWrongUse);
  const auto instance = model.create(values, error);
  if (!instance) return complain(model.descriptor.name, error, kWrongUse);
  if (!options.trace.file.empty())
    return instance->write_trace(options.trace, error) ? kDone
                                                       : complain(model.descriptor.name, error, kFailed);
  if (options.bounds.beliefs > 0) return check_bounds(descriptor, *instance, options.bounds);
  if (options.beliefs.episodes > 0) return check_beliefs(descriptor, *instance, options.beliefs);
  return selftest(model, *instance, options.selftest);
}

}  // namespace

int verify_main(const VerifiableModel& model, int argc, char** argv) {
  let_writes_fail();
  try {
    return verify(model, argc, argv);
  } catch (const std::bad_alloc&) {
    return complain(model.descriptor.name, "not enough memory; --particles and --lanes lower the need",
                    kFailed);
  } catch (const std::exception& problem) {
    return complain(model.descriptor.name, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen
