// SPDX-License-Identifier: Apache-2.0
#include "solve_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "first_report.hpp"
#include "report_text.hpp"

namespace hypgen::exact {

namespace {

std::string interval(double lower, double upper) {
  return outwards(lower, upper) + format(" (gap %.3g)", upper - lower);
}

// A simple bound for people: digits below a millionth of the model's values are those of sweeps that end
// early.
double rounded(double bound, const IntervalResult& result) {
  const double unit = 1e-6 * std::max({result.least_size, std::abs(result.mdp), std::abs(result.lower)});
  return std::round(bound / unit) * unit + 0.0;
}

const char* end_name(IntervalEnd end) {
  switch (end) {
    case IntervalEnd::kConverged:
      return "converged";
    case IntervalEnd::kTime:
      return "time";
    case IntervalEnd::kMemory:
      return "memory";
    case IntervalEnd::kRounding:
      return "rounding";
    case IntervalEnd::kStopped:
      return "interrupted";
  }
  return "unknown";
}

const char* end_text(IntervalEnd end) {
  switch (end) {
    case IntervalEnd::kConverged:
      return "the gap that was asked for is reached";
    case IntervalEnd::kTime:
      return "the time is over; --time gives more";
    case IntervalEnd::kMemory:
      return "the memory is full; --memory gives more";
    case IntervalEnd::kRounding:
      return "no trial changes a bound any more; what is left of the gap is rounding";
    case IntervalEnd::kStopped:
      return "interrupted";
  }
  return "unknown";
}

}  // namespace

std::string table(const ModelDescriptor& model, const SolveReport& report) {
  const IntervalResult& result = report.result;
  return row("model", model.name + format(": %zu states, %d actions, %d observations, %zu outcomes",
                                          report.counts.states, report.actions, report.observations,
                                          report.counts.outcomes)) +
         row("value", interval(result.lower, result.upper)) + first_rows(model, report.first, report.starts) +
         row("upper bounds", format("MDP %.6g, QMDP %.6g, FIB %.6g", rounded(result.mdp, result),
                                    rounded(result.qmdp, result), rounded(result.fib, result))) +
         row("lower bound", format(result.acts_at_random ? "acting at random %.6g" : "best fixed action %.6g",
                                   rounded(result.blind, result))) +
         row("search", format("%llu trials, %zu beliefs, %zu vectors, %zu points",
                              static_cast<unsigned long long>(result.iterations), result.beliefs,
                              result.vectors, result.points)) +
         row("seconds",
             format("%.2f to enumerate, %.2f to solve: ", report.enumeration_seconds, result.seconds) +
                 end_text(result.end));
}

std::string table(const std::string& policy, const Samples& returns) {
  return row(policy, format("%zu episodes, mean return %.6g +- %.3g", returns.size(), returns.mean(),
                            returns.interval95()));
}

std::string json(const ModelDescriptor& model, const SolveReport& report) {
  const IntervalResult& result = report.result;
  nlohmann::ordered_json object = {
      {"type", "solve"},
      {"model", model.name},
      {"hash", model.hash},
      {"status", end_name(result.end)},
      {"lower", result.lower},
      {"upper", result.upper},
      {"gap", result.upper - result.lower},
      {"best_action", nullptr},
      {"states", report.counts.states},
      {"classes", report.classes},
      {"actions", report.actions},
      {"observations", report.observations},
      {"outcomes", report.counts.outcomes},
      {"starts", report.starts},
      {"bounds", {{"mdp", result.mdp}, {"qmdp", result.qmdp}, {"fib", result.fib}, {"blind", result.blind}}},
      {"trials", result.iterations},
      {"beliefs", result.beliefs},
      {"vectors", result.vectors},
      {"points", result.points},
      {"slack", result.slack},
      {"enumeration_seconds", report.enumeration_seconds},
      {"seconds", result.seconds},
      {"first", first_json(model, report.first)}};
  if (!report.first.empty() && report.first[0].decision.action >= 0)
    object["best_action"] = report.first[0].action;
  if (!report.graph.is_null()) object["graph"] = report.graph;
  return object.dump() + "\n";
}

std::string status_line(const IntervalResult& result) {
  return "value " + interval(result.lower, result.upper) +
         format(", %llu trials, %.0f s", static_cast<unsigned long long>(result.iterations), result.seconds);
}

}  // namespace hypgen::exact
