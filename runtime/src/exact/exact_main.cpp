#include "hypgen/exact/exact_main.hpp"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "exact_options.hpp"
#include "hypgen/exact/dump.hpp"
#include "hypgen/exact/enumeration.hpp"
#include "hypgen/interrupt.hpp"
#include "hypgen/params.hpp"

namespace hypgen::exact {

namespace {

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2, kInterrupted = 130;

int complain(const ExactDescriptor& model, const std::string& message, int code) {
  std::fprintf(stderr, "%s: %s\n", model.descriptor.name.c_str(), message.c_str());
  return code;
}

// One line on a terminal that tells how far the work is.
class StatusLine {
 public:
  explicit StatusLine(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) != 0) {}
  ~StatusLine() {
    if (shown_) std::fprintf(stderr, "\r\033[K");
  }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void show(const std::string& text) {
    const Clock::time_point now = Clock::now();
    if (!shown_ || now < next_) return;
    next_ = now + std::chrono::milliseconds(100);
    std::fprintf(stderr, "\r\033[K%s", text.c_str());
    std::fflush(stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  bool shown_;
  Clock::time_point next_{};
};

Enumeration enumerate_model(const ExactDescriptor& model, const ExactInstance& instance,
                            const ExactOptions& options) {
  StatusLine line(!options.quiet);
  return enumerate(instance.outcomes(), model.descriptor.discount, model.descriptor.horizon, options.limits,
                   [&](const EnumerationCounts& counts) {
                     line.show(std::to_string(counts.expanded) + " of " + std::to_string(counts.states) +
                               " states so far, " + std::to_string(counts.outcomes) + " outcomes");
                     return !interrupted();
                   });
}

int run(const ExactDescriptor& model, const ExactInstance& instance, const ExactOptions& options) {
  catch_interrupts();
  const Enumeration enumeration = enumerate_model(model, instance, options);
  if (enumeration.stopped) return complain(model, enumeration.problem, kInterrupted);
  if (!enumeration.problem.empty()) return complain(model, enumeration.problem, kFailed);
  if (!options.dump_file.empty()) {
    if (dump(model, enumeration.model, options.dump_file)) return kDone;
    return complain(model, options.dump_file + ": cannot be written", kFailed);
  }
  return kDone;
}

int solve(const ExactDescriptor& model, int argc, char** argv) {
  const ModelDescriptor& descriptor = model.descriptor;
  ExactOptions options;
  std::string error;
  if (!parse_options(argc, argv, options, error)) return complain(model, error, kWrongUse);
  if (options.help) {
    std::fputs(help_text(descriptor, argv[0]).c_str(), stdout);
    return kDone;
  }
  if (options.version) {
    std::printf("%s (model %s, descriptor %d)\n", descriptor.name.c_str(), descriptor.hash.c_str(),
                descriptor.version);
    return kDone;
  }
  ParamValues values(descriptor.params);
  if (!options.param_file.empty() && !read_param_file(options.param_file, descriptor.params, values, error)) {
    return complain(model, error, kWrongUse);
  }
  if (!check_complete(descriptor.params, values, error)) return complain(model, error, kWrongUse);
  const auto instance = model.create(values, error);
  if (!instance) return complain(model, error, kWrongUse);
  return run(model, *instance, options);
}

}  // namespace

int exact_main(const ExactDescriptor& model, int argc, char** argv) {
  try {
    return solve(model, argc, argv);
  } catch (const std::bad_alloc&) {
    return complain(model, "not enough memory; --memory and --max-outcomes lower the need", kFailed);
  } catch (const std::exception& problem) {
    return complain(model, std::string("internal error: ") + problem.what(), kFailed);
  }
}

}  // namespace hypgen::exact
