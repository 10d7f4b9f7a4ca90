// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/enumeration.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "matrices.hpp"

namespace hypgen::exact {

namespace {

// What one step may have: more paths than outcomes are equal outcomes, and cost time alone.
constexpr std::size_t kMostPaths = 1000000;
constexpr std::size_t kStatesBetweenLooks = 256;
constexpr std::size_t kEntryBytes = sizeof(Entry) + sizeof(double) + sizeof(int);  // found, and in the matrix

class Enumerator {
 public:
  Enumerator(const OutcomeModel& model, int horizon, const EnumerationLimits& limits)
      : model_(model), horizon_(horizon), limits_(limits), found_(model), row_(found_width(model)) {}

  // Returns what went wrong, if something did.
  std::string run(const EnumerationProgress& progress, bool& stopped) {
    if (!model_.start(kMostPaths, outcomes_))
      return "there are more than " + number(kMostPaths) + " ways to start" + remedy();
    add_outcomes(0, nullptr);
    found_.starts = merged_;
    for (int state = 0; state < found_.states.size(); ++state) {
      if (counts_.expanded % kStatesBetweenLooks == 0 || state + 1 == found_.states.size()) {
        count();
        if (!progress(counts_)) {
          stopped = true;
          return "enumeration was stopped" + so_far();
        }
      }
      for (int action = 0; action < model_.actions(); ++action) {
        if (const std::string problem = expand(state, action); !problem.empty()) return problem;
      }
      ++counts_.expanded;
      if (const std::string problem = passed_limit(); !problem.empty()) return problem;
    }
    count();
    progress(counts_);
    return "";
  }

  Found& found() { return found_; }
  const BrokenStep& broken() const { return broken_; }

 private:
  static std::size_t found_width(const OutcomeModel& model) {
    return static_cast<std::size_t>(model.state_words()) + 1;
  }

  std::string expand(int state, int action) {
    const std::vector<std::uint32_t> from(found_.states.row(state), found_.states.row(state) + row_.size());
    FoundAction& result = found_.actions[static_cast<std::size_t>(action)];
    if (!model_.is_legal(from.data(), action)) {
      result.reward.push_back(-std::numeric_limits<double>::infinity());
      result.begin.push_back(result.entries.size());
      return "";
    }
    if (!model_.step(from.data(), action, kMostPaths, outcomes_)) {
      return "a step can go in more than " + number(kMostPaths) + " ways" + remedy();
    }
    if (outcomes_.error) {
      broken_.action = action;
      broken_.values.resize(static_cast<std::size_t>(model_.variables()));
      model_.export_state(from.data(), broken_.values.data());
      return "a reward is not a number, or beyond the range of rewards" + so_far();
    }
    const std::uint32_t steps = horizon_ > 0 ? from.back() + 1 : 0;
    const bool ends = horizon_ > 0 && steps == static_cast<std::uint32_t>(horizon_);
    merged_.clear();
    if (!ends) add_outcomes(steps, outcomes_.keys.data());
    result.entries.insert(result.entries.end(), merged_.begin(), merged_.end());
    result.begin.push_back(result.entries.size());
    result.reward.push_back(outcomes_.reward);
    counts_.outcomes += merged_.size();
    return "";
  }

  // Makes merged_ of outcomes_: equal ones added up. Initial states have no keys.
  void add_outcomes(std::uint32_t steps, const std::uint64_t* keys) {
    const auto width = static_cast<std::size_t>(model_.state_words());
    const auto key_width = static_cast<std::size_t>(model_.key_words());
    merged_.clear();
    for (std::size_t i = 0; i < outcomes_.probabilities.size(); ++i) {
      std::copy_n(outcomes_.states.data() + i * width, width, row_.begin());
      row_.back() = steps;
      const int observation = keys == nullptr ? 0 : found_.keys.number(keys + i * key_width);
      merged_.push_back({outcomes_.probabilities[i], observation, found_.states.number(row_.data())});
    }
    const auto place = [](const Entry& entry) { return std::pair(entry.observation, entry.next); };
    std::stable_sort(merged_.begin(), merged_.end(),
                     [&](const Entry& a, const Entry& b) { return place(a) < place(b); });
    std::size_t size = 0;
    for (const Entry& entry : merged_) {
      if (size > 0 && place(merged_[size - 1]) == place(entry)) {
        merged_[size - 1].probability += entry.probability;
      } else {
        merged_[size++] = entry;
      }
    }
    merged_.resize(size);
  }

  void count() {
    counts_.states = static_cast<std::size_t>(found_.states.size());
    const std::size_t of_state = found_.actions.size() * 3 * sizeof(double) +
                                 sizeof(std::int32_t) * static_cast<std::size_t>(model_.variables() + 4);
    counts_.bytes = found_.states.bytes() + found_.keys.bytes() + counts_.states * of_state +
                    counts_.outcomes * kEntryBytes;
  }

  std::string passed_limit() {
    count();
    if (counts_.states > limits_.states)
      return "more than " + some(limits_.states, "state") + remedy("--max-states");
    if (counts_.outcomes > limits_.outcomes)
      return "more than " + some(limits_.outcomes, "outcome") + remedy("--max-outcomes");
    if (counts_.bytes > limits_.bytes)
      return "more than " + number(limits_.bytes >> 20) + " MiB of matrices" + remedy("--memory");
    return "";
  }

  std::string so_far() const {
    return " (" + some(counts_.states, "state") + " found, " + number(counts_.expanded) +
           " of them expanded, " + some(counts_.outcomes, "outcome") + ")";
  }

  std::string remedy(const std::string& option = "") const {
    return so_far() + ": make the model smaller, with --set or --param" +
           (option.empty() ? "" : ", or raise " + option);
  }

  static std::string number(std::size_t value) { return std::to_string(value); }
  static std::string some(std::size_t value, const std::string& noun) {
    return number(value) + " " + noun + (value == 1 ? "" : "s");
  }

  const OutcomeModel& model_;
  int horizon_;
  EnumerationLimits limits_;
  EnumerationCounts counts_;
  Found found_;
  BrokenStep broken_;
  Outcomes outcomes_;               // of the step in work
  std::vector<Entry> merged_;       // of the step in work
  std::vector<std::uint32_t> row_;  // a state's words and the steps taken
};

}  // namespace

Enumeration enumerate(const OutcomeModel& model, double discount, int horizon,
                      const EnumerationLimits& limits, const EnumerationProgress& progress) {
  Enumeration result;
  Enumerator enumerator(model, horizon, limits);
  result.problem = enumerator.run(progress, result.stopped);
  result.broken = enumerator.broken();
  if (!result.problem.empty()) return result;
  result.model.discount = discount;
  result.model.horizon = horizon;
  make_matrices(model, enumerator.found(), result.model);
  return result;
}

}  // namespace hypgen::exact
