// SPDX-License-Identifier: Apache-2.0
#include "hypgen/solver/run_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "hypgen/search/signature.hpp"

namespace hypgen {

namespace {

constexpr double kLate = 1e-3;  // seconds past its period from which a cycle is late

__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...) {
  char text[256];
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string row(const char* name, const std::string& value) { return format("%-28s", name) + value + "\n"; }

// A return or its interval: four decimals, or six digits where these would not tell the scale of rewards.
std::string worth(double value, double returns) {
  const double size = std::abs(returns);
  return format(size != 0.0 && (size < 0.1 || size >= 1e9) ? "%.6g" : "%.4f", value);
}

std::string counted(const std::map<Status, std::uint64_t>& statuses) {
  std::string text;
  for (const auto& [status, count] : statuses) {
    text += format("%s%s %llu", text.empty() ? "" : ", ", status_name(status),
                   static_cast<unsigned long long>(count));
  }
  return text;
}

// What a GPU did, and where the time of the searches went.
std::string device_rows(const RunTotals& totals) {
  const EvaluatorStats& stats = totals.evaluator;
  const auto share = [&](double seconds) {
    return totals.search_seconds > 0 ? 100.0 * seconds / totals.search_seconds : 0.0;
  };
  return row("leaves a batch", format("%.1f", totals.a_batch())) +
         row("device steps a second", format("%.3g", totals.a_second(stats.steps))) +
         row("read back [MB]", format("%.1f", static_cast<double>(stats.bytes_read) * 1e-6)) +
         row("time of the searches",
             format("kernels %.0f%%, waiting %.0f%%, tree %.0f%%", share(stats.busy_seconds),
                    share(totals.waiting_seconds), share(totals.tree_seconds)));
}

std::string thread_row(const RunTotals& totals) {
  const std::string late = totals.late_searches == 0
                               ? ""
                               : format("; in %llu searches some were late",
                                        static_cast<unsigned long long>(totals.late_searches));
  const double collisions = static_cast<double>(totals.collisions) /
                            static_cast<double>(std::max<std::uint64_t>(1, totals.expansions));
  return row("threads", format("%zu, %zu trials in flight, %.3f collisions an expansion", totals.threads,
                               totals.in_flight, collisions) +
                            late);
}

// How the steps were decided, and what to do where there was no time to look ahead.
std::string decided_rows(const RunTotals& totals) {
  const std::uint64_t steps = totals.seconds.size(), blind = steps - totals.trees - totals.compared;
  const auto count = [](std::uint64_t number) { return static_cast<unsigned long long>(number); };
  const double scenarios =
      totals.trees > 0 ? static_cast<double>(totals.tree_scenarios) / static_cast<double>(totals.trees) : 0.0;
  std::string text =
      row("steps decided by", format("tree %llu, one-ply rollouts %llu, default policy %llu",
                                     count(totals.trees), count(totals.compared), count(blind)));
  if (totals.comparisons > 0) {
    text += row("actions compared", format("mean %.1f", static_cast<double>(totals.compared_actions) /
                                                            static_cast<double>(totals.comparisons)));
  }
  if (totals.trees > 0) text += row("scenarios of a tree", format("mean %.1f", scenarios));
  if (totals.pruned > 0) {
    text += row("pruning", format("mean %.3g, in %llu of the trees",
                                  totals.pruning / static_cast<double>(totals.pruned), count(totals.pruned)));
  }
  if (totals.plan_statuses.count(Status::kModelNan) > 0) return text;
  const std::string advice = totals.period > 0.0 ? "raise --period, or lower --depth or --particles"
                                                 : "raise --time, or lower --depth";
  if (2 * totals.trees < steps && totals.mode != "rollout") {
    text += row("", "most steps had no time for a tree: " + advice);
  }
  if (blind > 0) {
    text += row("", format("no time for a single comparison: %llu; ", count(blind)) + advice);
  }
  return text;
}

// One warning where the belief should not be trusted.
std::string doubt_rows(const RunTotals& totals) {
  if (totals.depleted + totals.surprised + totals.unexplained == 0) return "";
  const auto count = [](std::uint64_t number) { return static_cast<unsigned long long>(number); };
  const char* const advice =
      totals.unexplained > 0 ? "particles are too few where none explains what was seen: raise --particles"
                             : "do not trust the belief there: raise --particles, or mend the model's noise";
  return row("doubtful beliefs",
             format("unexplained %llu, surprised %llu, few values left %llu, of %zu steps",
                    count(totals.unexplained), count(totals.surprised), count(totals.depleted),
                    totals.seconds.size())) +
         row("", advice);
}

}  // namespace

void RunTotals::add(const StartRecord& start) {
  const bool is_kept = start.belief_status != Status::kNotKept;
  if (is_kept && start.belief_status != Status::kOk) ++belief_statuses[start.belief_status];
}

void RunTotals::add(const StepRecord& step) {
  const Decision& decision = step.decision;
  seconds.add(decision.search_seconds);
  search_seconds += decision.search_seconds;
  waiting_seconds += decision.waiting_seconds;
  tree_seconds += decision.tree_seconds;
  descent_seconds += decision.descent_seconds;
  backup_seconds += decision.backup_seconds;
  trials += decision.trials;
  expansions += decision.expansions;
  nodes += decision.nodes;
  children += decision.children;
  collisions += decision.collisions;
  simulations += decision.simulations;
  leaf_scenarios += decision.leaf_scenarios;
  late_searches += decision.late_threads > 0;
  trees += decision.looked == Looked::kTree;
  tree_scenarios += decision.looked == Looked::kTree ? decision.scenarios : 0;
  pruned += decision.pruning > 0.0;
  pruning += decision.pruning;
  compared += decision.looked == Looked::kOneStep;
  comparisons += decision.compared_actions > 0;
  compared_actions += decision.compared_actions;
  ++plan_statuses[decision.status];
  broken += step.is_broken || decision.status == Status::kModelNan;
  ++belief_statuses[step.belief_status];
  updates.add(step.update_seconds);
  cycles.add(step.cycle_seconds);
  late_cycles += period > 0.0 && step.cycle_seconds > period + kLate;
  bool is_depleted = false, is_surprised = false;
  for (const UnitHealth& unit : step.units) {
    is_depleted = is_depleted || unit.is_depleted;
    is_surprised = is_surprised || unit.surprise > Belief::kDoubtfulSurprise;
  }
  depleted += is_depleted;
  surprised += is_surprised;
  unexplained += step.belief_status != Status::kOk && step.belief_status != Status::kNotKept;
  if (decision.signature != 0) {
    Signature hash(signature);
    hash.add(decision.signature);
    signature = hash.value();
  }
}

void RunTotals::add(const EpisodeRecord& episode) {
  returns.add(episode.discounted_return);
  episode_steps.add(episode.steps);
  successes += episode.success;
  ++episode_statuses[episode.status];
}

std::string hexadecimal(std::uint64_t signature) {
  return format("%016llx", static_cast<unsigned long long>(signature));
}

std::vector<std::string> faults(const RunTotals& totals, const ModelDescriptor& model) {
  if (totals.broken == 0) return {};
  const auto nan = totals.plan_statuses.find(Status::kModelNan);
  const std::uint64_t blind = nan == totals.plan_statuses.end() ? 0 : nan->second;
  std::vector<std::string> lines = {
      format("in %llu of %zu steps a bound or reward was no number (NaN), or beyond all rewards",
             static_cast<unsigned long long>(totals.broken), totals.seconds.size())};
  if (blind > 0) {
    lines.push_back(format("%llu of them were not searched: the default policy acted",
                           static_cast<unsigned long long>(blind)));
  }
  std::string terms;
  for (const std::string& term : model.doubtful) terms += (terms.empty() ? "" : ", ") + term;
  if (!terms.empty()) lines.push_back("what may be no number: " + terms);
  lines.push_back("`hypgen check " + model.file + " --samples 1000` shows a state where it is so");
  return lines;
}

std::string table(const RunTotals& totals, const ModelDescriptor& model,
                  const std::vector<std::uint64_t>& leaf_sizes) {
  const double episodes = static_cast<double>(totals.returns.size());
  std::string text =
      row("episodes", format("%zu (%s)", totals.returns.size(), counted(totals.episode_statuses).c_str()));
  const double mean = totals.returns.mean();
  const std::string interval = totals.returns.size() < 2
                                   ? "(no interval: one episode)"
                                   : "+- " + worth(totals.returns.interval95(), mean) + " (95%)";
  text += row("discounted return", worth(mean, mean) + " " + interval);
  if (model.has_success && episodes > 0) {
    text += row("success rate", format("%.3f", static_cast<double>(totals.successes) / episodes));
  }
  text += row("steps an episode", format("%.1f", totals.episode_steps.mean()));
  text += row("time a step [s]", format("mean %.4f, p99 %.4f, worst %.4f", totals.seconds.mean(),
                                        totals.seconds.quantile(0.99), totals.seconds.largest()));
  if (totals.updates.largest() >= 5e-5) {
    text += row("time an update [s]", format("mean %.4f, p99 %.4f, worst %.4f", totals.updates.mean(),
                                             totals.updates.quantile(0.99), totals.updates.largest()));
  }
  if (totals.period > 0.0) {
    text +=
        row("update and plan [s]",
            format("mean %.4f, p99 %.4f, worst %.4f; over the period of %g by 1 ms or more: %llu of %zu",
                   totals.cycles.mean(), totals.cycles.quantile(0.99), totals.cycles.largest(), totals.period,
                   static_cast<unsigned long long>(totals.late_cycles), totals.cycles.size()));
  }
  text += row("mode", totals.mode);
  const char* name = "THE MODEL IS BROKEN";
  for (const std::string& line : faults(totals, model)) {
    text += row(name, line);
    name = "";
  }
  if (totals.belief_statuses.size() > 1) text += row("beliefs", counted(totals.belief_statuses));
  text += doubt_rows(totals);
  if (totals.mode != "default") text += decided_rows(totals);
  if (totals.expansions > 0) {
    text += row("searches", counted(totals.plan_statuses));
    if (totals.threads > 1) text += thread_row(totals);
    text += row("trials a step", format("%.1f", totals.a_step(totals.trials)));
    text += row("expansions a second", format("%.0f", totals.a_second(totals.expansions)));
    text += row("nodes a second", format("%.0f", totals.a_second(totals.nodes)));
    text += row("simulations a second", format("%.3g", totals.a_second(totals.simulations)));
    text += row("scenarios a leaf",
                format("mean %.1f, median %.0f", totals.a_leaf(), histogram_median(leaf_sizes)));
  }
  if (totals.evaluator.batches > 0) text += device_rows(totals);
  return text;
}

}  // namespace hypgen
