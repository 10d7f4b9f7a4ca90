// SPDX-License-Identifier: Apache-2.0
#include "hypgen/verify/selftest.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "hypgen/belief/belief.hpp"
#include "hypgen/core/output.hpp"
#include "hypgen/core/program.hpp"
#include "hypgen/episode/episode.hpp"
#include "hypgen/episode/world.hpp"
#include "hypgen/lanes/choice.hpp"
#include "hypgen/leaves/device.hpp"
#include "hypgen/leaves/leaf_evaluator.hpp"
#include "hypgen/search/planner.hpp"
#include "hypgen/verify/digest_walks.hpp"
#include "hypgen/verify/leaf_check.hpp"
#include "hypgen/verify/schedule.hpp"

namespace hypgen {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kWarps[] = {2, 3, 4, 8, 16};  // some divide the work of a stage evenly, some do not

constexpr std::size_t kDeviceBytes = std::size_t{1} << 30;  // several self-tests may share a GPU

// What one check came to.
struct Outcome {
  std::string check;
  std::string variant;
  std::uint64_t steps = 0;      // that were compared
  std::uint32_t differing = 0;  // lanes
  std::string remark;           // what differs first, or why nothing was compared
  bool equal() const { return differing == 0; }
};

// A check that has compared nothing yet.
Outcome outcome_of(const std::string& check, const std::string& variant, const std::string& remark = "") {
  Outcome outcome;
  outcome.check = check;
  outcome.variant = variant;
  outcome.remark = remark;
  return outcome;
}

std::string counted_warps(int warps) { return std::to_string(warps) + (warps == 1 ? " warp" : " warps"); }

std::string describe(const ScheduleFault& fault) {
  const std::string where = "lane " + std::to_string(fault.lane) + ", step " + std::to_string(fault.step) +
                            ", stage " + std::to_string(fault.stage) + ": ";
  const std::string word = "word " + std::to_string(fault.word) + " of the state";
  const std::string warp = "warp " + std::to_string(fault.warp);
  switch (fault.kind) {
    case ScheduleFault::Kind::kNone:
      return "";
    case ScheduleFault::Kind::kSharedWord:
      return where + warp + " changes " + word + ", and so does another";
    case ScheduleFault::Kind::kOrder:
      return where + word + " depends on the order of the warps";
    case ScheduleFault::Kind::kDependence:
      return where + warp + " reads or writes what others write, seen in " + word;
  }
  return "";
}

// Writes outcomes as they come, as lines of a table or of JSON.
class Report {
 public:
  explicit Report(const SelftestOptions& options)
      : out_(options.json_file.empty() ? "-" : options.json_file, Output::Kind::kLines),
        json_(!options.json_file.empty()),
        shows_progress_(!options.quiet && isatty(STDERR_FILENO) != 0) {
    if (!json_) out_.write("check                  steps, rows, leaves  differing\n");
  }

  Output& output() { return out_; }

  void write(const Outcome& outcome) {
    clear_progress();
    if (json_) {
      const Json line = {
          {"type", "check"},        {"check", outcome.check},         {"variant", outcome.variant},
          {"steps", outcome.steps}, {"differing", outcome.differing}, {"remark", outcome.remark}};
      out_.write(line.dump() + "\n");
    } else {
      out_.write(row(outcome));
    }
  }

  void progress(const std::string& what, std::uint32_t done, std::uint32_t lanes) const {
    if (!shows_progress_) return;
    std::fprintf(stderr, "\r\033[K%s: %u of %u walks", what.c_str(), done, lanes);
    std::fflush(stderr);
  }

 private:
  static std::string row(const Outcome& outcome) {
    char text[128];
    std::snprintf(text, sizeof text, "%-10s%-12s", outcome.check.c_str(), outcome.variant.c_str());
    const std::string what = text;
    if (outcome.steps == 0) return what + "left out: " + outcome.remark + "\n";
    std::snprintf(text, sizeof text, "%20llu%11u\n", static_cast<unsigned long long>(outcome.steps),
                  outcome.differing);
    return what + text + (outcome.remark.empty() ? "" : "  " + outcome.remark + "\n");
  }

  void clear_progress() const {
    if (shows_progress_) std::fprintf(stderr, "\r\033[K");
  }

  Output out_;
  bool json_;
  bool shows_progress_;
};

// The checks of one model, in order.
class Checks {
 public:
  Checks(const VerifiableModel& model, const VerifiableInstance& instance, const SelftestOptions& options,
         Report& report)
      : checked_(model), model_(model.descriptor), instance_(instance), options_(options), report_(report) {
    range_.key = derive(options.seed, StreamKind::kTest, 0);
    range_.lanes = options.lanes;
    range_.steps = options.steps;
  }

  bool all() {
    plain_ = host_digests("plain", 1);
    bool equal = true;
    for (const int warps : tried_warps()) {
      if (!report_.output().ok()) return false;
      equal = check_schedule(warps) && equal;
    }
    equal = check_lanes() && equal;
    return check_device() && equal;
  }

 private:
  std::vector<int> tried_warps() const {
    if (options_.warps > 0) return {options_.warps};
    return {std::begin(kWarps), std::end(kWarps)};
  }

  std::vector<int> device_warps() const {
    if (options_.warps > 0) return {std::min(options_.warps, checked_.most_warps)};
    std::vector<int> tried;
    for (int warps = 1; warps <= checked_.most_warps; warps *= 2) tried.push_back(warps);
    return tried;
  }

  std::vector<std::uint64_t> host_digests(const std::string& what, int warps) {
    fault_ = {};
    const auto progress = [&](std::uint32_t done) { report_.progress(what, done, range_.lanes); };
    return walk_on_host(instance_, range_, warps, options_.threads, progress, fault_);
  }

  Walker host_walker(int warps) const {
    return [this, warps](const DigestRange& range, std::uint64_t* digests, std::string&) {
      instance_.digests(range, warps, digests);
      return true;
    };
  }

  // A step that warps share, against a plain one, both on the host.
  bool check_schedule(int warps) {
    const auto found = host_digests("schedule, " + counted_warps(warps), warps);
    Outcome outcome = compare("schedule", counted_warps(warps), found, host_walker(warps));
    if (fault_.kind != ScheduleFault::Kind::kNone) {
      outcome.remark = describe(fault_);
      if (outcome.equal()) outcome.differing = 1;  // by luck the digests do not show it
    }
    report_.write(outcome);
    return outcome.equal();
  }

  // Leaves whose rollouts are played side by side, against those whose rollouts are played one by one.
  bool check_lanes() {
    bool equal = true;
    for (const hypgen_lanes::Kernel* const kernel : model_.lanes) {
      if (!has_lanes(*kernel)) {
        report_.write(outcome_of("leaves", kernel->name, "this processor is of another kind"));
        continue;
      }
      for (const bool weighted : {false, true}) equal = check_lanes(*kernel, weighted) && equal;
    }
    return equal;
  }

  bool check_lanes(const hypgen_lanes::Kernel& kernel, bool weighted) {
    const auto with_lanes = [&](const EvaluatorOptions& options, std::string&) {
      EvaluatorOptions wide = options;
      wide.threads = 1;
      wide.lanes = &kernel;
      wide.measures_lanes = false;
      return instance_.make_evaluator(wide);
    };
    Outcome outcome = outcome_of("leaves", kernel.name + std::string(weighted ? ", weighted" : ""));
    check_leaves(with_lanes, weighted, outcome);
    report_.write(outcome);
    return outcome.equal();
  }

  // Steps on each GPU against those on the host.
  bool check_device() {
    std::string error = "this program was built without CUDA";
    std::vector<DeviceInfo> devices;
    if (model_.device != nullptr) devices = model_.device->devices(error);
    if (devices.empty()) {
      report_.write(outcome_of("device", "", error));
      return true;
    }
    bool equal = true;
    for (const DeviceInfo& device : devices) {
      for (const std::size_t in_flight : {1, 16})
        equal = check_search(device.index, in_flight, Observations::kExact) && equal;
      equal = check_search(device.index, 16, Observations::kWeighted) && equal;
      for (const int warps : device_warps()) {
        equal = check_device(device.index, warps) && equal;
        equal = check_leaves(device.index, warps, false) && equal;
      }
      equal = check_leaves(device.index, 0, true) && equal;
    }
    return equal;
  }

  bool check_device(int device, int warps) {
    const Walker walker = [=](const DigestRange& range, std::uint64_t* digests, std::string& error) {
      return checked_.walk_on_device(instance_.params(), range, warps, device, digests, error);
    };
    const std::string name = "device " + std::to_string(device);
    report_.progress(name, 0, range_.lanes);
    std::vector<std::uint64_t> found(range_.lanes);
    std::string error;
    const Outcome outcome = walker(range_, found.data(), error)
                                ? compare(name, counted_warps(warps), found, walker)
                                : failed(name, counted_warps(warps), error);
    report_.write(outcome);
    return outcome.equal();
  }

  // Leaves expanded on a GPU against those expanded on the host: small and large ones, with and without the
  // horizon in sight.
  bool check_leaves(int device, int warps, bool weighted) {
    const std::string variant = weighted ? "weighted" : counted_warps(warps);
    Outcome outcome = outcome_of("leaves " + std::to_string(device), variant);
    const auto on_device = [&](EvaluatorOptions options, std::string& error) {
      options.warps = warps;
      return model_.device->make_evaluator(instance_.params(), options, device, error);
    };
    check_leaves(on_device, weighted, outcome);
    report_.write(outcome);
    return outcome.equal();
  }

  template <class Make>
  void check_leaves(const Make& make, bool weighted, Outcome& outcome) const {
    for (const std::size_t scenarios : {7, 32, 150}) {
      const bool ends = scenarios == 32;
      const LeafComparison found = compare_leaves_of(make, weighted, scenarios, ends, outcome.remark);
      if (!outcome.remark.empty()) break;
      outcome.steps += found.rows;
      if (found.difference.empty()) continue;
      ++outcome.differing;
      outcome.remark = std::to_string(scenarios) + " scenarios: " + found.difference;
    }
  }

  template <class Make>
  LeafComparison compare_leaves_of(const Make& make, bool weighted, std::size_t scenarios, bool ends,
                                   std::string& error) const {
    constexpr int kDepth = 20, kHorizon = 6;
    constexpr std::size_t kThreads = 5;  // no divisor of a batch: their shares differ
    const std::size_t steps = 20 * std::size_t{options_.lanes} * options_.steps;  // or so, on the host
    EvaluatorOptions options;
    options.max_scenarios = scenarios;
    options.discount = model_.discount;
    options.max_depth = kDepth;
    options.in_flight = kMostInFlight;
    options.may_weigh = weighted;
    options.device_memory_bytes = kDeviceBytes;
    const auto reference = instance_.make_evaluator(options);
    options.threads = kThreads;
    const auto other = make(options, error);
    if (!other) return {};
    const auto belief = instance_.make_belief(options_.seed, 1000, BeliefKind::kAuto);
    const auto world = instance_.make_world(options_.seed);
    std::vector<std::int32_t> visible(static_cast<std::size_t>(model_.visible_count) + 1);
    world->reset(scenarios);
    world->export_visible(visible.data());
    belief->init(visible.data(), scenarios);
    ScenarioBuffer root;
    belief->reserve(root, scenarios);
    const StreamKey key = derive(options_.seed, StreamKind::kPlan, scenarios);
    belief->sample(key, 0, scenarios, root);
    const std::size_t a_leaf = scenarios * static_cast<std::size_t>(model_.action_count * kDepth);
    SearchSetup setup;
    setup.key = key;
    setup.depth_limit = ends ? kHorizon : kDepth;
    setup.at_horizon = ends;
    setup.weighted = weighted;
    return compare_leaves(*reference, *other, root, setup, std::clamp<std::size_t>(steps / a_leaf, 3, 500),
                          options_.seed);
  }

  // Searches of the first steps of an episode with leaves from a GPU against the same with leaves from the
  // host: the trees have to be equal, bit for bit.
  bool check_search(int device, std::size_t in_flight, Observations observations) {
    const bool weighted = observations == Observations::kWeighted;
    const std::string variant = weighted ? "weighted" : std::to_string(in_flight) + " at once";
    Outcome outcome = outcome_of("search " + std::to_string(device), variant);
    PlannerOptions planning = search_options(in_flight);
    planning.observations = observations;
    const EvaluatorOptions options = evaluator_options(planning, model_);
    auto evaluator = model_.device->make_evaluator(instance_.params(), options, device, outcome.remark);
    if (evaluator) {
      const auto expected = trees(planning, instance_.make_evaluator(options), outcome.steps);
      std::uint64_t expansions = 0;
      if (trees(planning, std::move(evaluator), expansions) != expected) {
        outcome.differing = 1;
        outcome.remark = "the trees of one of the first steps differ";
      }
    }
    report_.write(outcome);
    return outcome.equal();
  }

  PlannerOptions search_options(std::size_t in_flight) const {
    constexpr std::size_t kScenarios = 60;
    constexpr int kDepth = 20;
    const std::size_t steps = 5 * std::size_t{options_.lanes} * options_.steps;  // or so, on the host
    const std::size_t a_leaf = kScenarios * static_cast<std::size_t>(model_.action_count * kDepth);
    PlannerOptions planning;
    planning.mode = in_flight > 1 ? Mode::kGpu : Mode::kDespot;
    planning.seed = options_.seed;
    planning.scenarios = kScenarios;
    planning.depth = kDepth;
    planning.in_flight = in_flight;
    planning.trial_limit = std::clamp<std::size_t>(steps / a_leaf, 3, 300);
    planning.signature = true;
    planning.device_memory_bytes = kDeviceBytes;
    return planning;
  }

  std::vector<std::uint64_t> trees(const PlannerOptions& planning, std::unique_ptr<LeafEvaluator> evaluator,
                                   std::uint64_t& expansions) const {
    constexpr int kSteps = 3;
    const auto belief = instance_.make_belief(options_.seed, 1000, BeliefKind::kAuto);
    const auto world = instance_.make_world(options_.seed);
    Planner planner(std::move(evaluator), model_, planning);
    planner.prepare(*belief);
    std::vector<std::uint64_t> signatures;
    const auto note = [&](const StepRecord& step) {
      signatures.push_back(step.decision.signature);
      expansions += step.decision.expansions;
    };
    EpisodeLimits limits;
    limits.steps = kSteps;
    limits.discount = model_.discount;
    limits.interrupted = [] { return false; };
    run_episode(planner, *belief, *world, model_.visible_count, 0, limits, note);
    return signatures;
  }

  Outcome failed(const std::string& check, const std::string& variant, const std::string& error) const {
    Outcome outcome = outcome_of(check, variant, error);
    outcome.steps = std::uint64_t{range_.lanes} * range_.steps;
    outcome.differing = range_.lanes;
    return outcome;
  }

  Outcome compare(const std::string& check, const std::string& variant,
                  const std::vector<std::uint64_t>& found, const Walker& walker) const {
    WalkComparison comparison;
    std::string error;
    if (!compare_walks(range_, plain_, found, host_walker(1), walker, comparison, error)) {
      return failed(check, variant, error);
    }
    Outcome outcome = outcome_of(check, variant);
    outcome.steps = std::uint64_t{range_.lanes} * range_.steps;
    outcome.differing = comparison.differing;
    if (!outcome.equal()) {
      outcome.remark = "first: lane " + std::to_string(comparison.lane) + ", step " +
                       std::to_string(comparison.step) + " (--seed " + std::to_string(options_.seed) + ")";
    }
    return outcome;
  }

  const VerifiableModel& checked_;
  const ModelDescriptor& model_;
  const VerifiableInstance& instance_;
  const SelftestOptions& options_;
  Report& report_;
  DigestRange range_;
  std::vector<std::uint64_t> plain_;
  ScheduleFault fault_;
};

}  // namespace

int selftest(const VerifiableModel& model, const VerifiableInstance& instance,
             const SelftestOptions& options) {
  Report report(options);
  const bool equal = Checks(model, instance, options, report).all();
  if (!report.output().close()) return complain(model.descriptor.name, report.output());
  return equal ? kDone : kFailed;
}

}  // namespace hypgen
