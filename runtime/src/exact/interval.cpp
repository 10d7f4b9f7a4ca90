// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/interval.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "hypgen/exact/belief_graph.hpp"
#include "hypgen/exact/bounds.hpp"
#include "hypgen/exact/long_run.hpp"
#include "hypgen/exact/refinement.hpp"
#include "hypgen/exact/split_model.hpp"

namespace hypgen::exact {
namespace {

using Clock = std::chrono::steady_clock;

// A trial goes down until what a belief adds to the interval at the start is this part of it.
constexpr double kTrialTarget = 0.5;
// Improvements below this part of the largest value are not worth a vector or a point.
constexpr double kNothing = 1e-12;
// What rounding changes of a reward, of the largest one, where the compiler cannot tell.
constexpr double kUnknown = 0x1p-20;
constexpr double kSecondsBetweenReports = 0.2;
// Nodes may take this part of the memory; they are forgotten when they do, and made again from the start.
constexpr double kNodeShare = 0.6;
// What each first action is worth is found after the search, in this part of its time or this many seconds.
constexpr double kFirstShare = 0.1;
constexpr double kFirstSeconds = 1.0;
// Where loops are closed by equations, a trial of more steps than this, or one that comes back to a belief,
// shows nothing that they would not. A trial that showed nothing at all may be longer the next time.
constexpr std::size_t kLongTrial = 64;
// Seconds of refinement that small models are closed in.
constexpr double kFirstRefining = 0.2;
// Vectors are refined again soon if they closed more than this part of the gap.
constexpr double kWorthIt = 0.01;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

struct Start {
  double probability;
  int of_class;
  ClassBelief belief;
};

std::vector<Start> starts_of(const ExactModel& model) {
  std::vector<Start> starts;
  for (const ExactStart& from : model.starts) {
    Start start{from.probability, -1, {}};
    for (SparseBelief::InnerIterator entry(from.belief); entry; ++entry) {
      if (entry.value() <= 0.0) continue;
      const auto state = static_cast<int>(entry.index());
      start.of_class = model.seen[index(state)];
      start.belief.states.push_back(state - model.class_begin[index(start.of_class)]);
      start.belief.probabilities.push_back(entry.value());
    }
    starts.push_back(std::move(start));
  }
  return starts;
}

// A policy with a vector for each action: columns of a class's Q-values.
AlphaPolicy policy_of(const ExactModel& model, const SplitModel& split, const ActionValues& q) {
  std::vector<AlphaPolicy::Class> all(q.size());
  for (int c = 0; c < split.classes(); ++c) {
    const std::size_t width = split.actions(c).size();
    for (std::size_t a = 0; a < width; ++a) {
      AlphaPolicy::Vector vector{split.actions(c)[a].action, {}, {}};
      for (std::size_t at = a; at < q[index(c)].size(); at += width) {
        vector.values.push_back(q[index(c)][at]);
      }
      all[index(c)].vectors.push_back(std::move(vector));
    }
  }
  return AlphaPolicy(model, std::move(all));
}

class IntervalSearch {
 public:
  IntervalSearch(const ExactModel& model, const IntervalOptions& options, const IntervalProgress& progress)
      : begin_(Clock::now()),
        model_(model),
        split_(model),
        options_(options),
        progress_(progress),
        graph_(split_),
        starts_(starts_of(model)) {
    if (split_.is_endless()) split_.limit_steps(steps_to_end(split_));
    result_.mdp = result_.qmdp = result_.fib = result_.upper = split_.most();
    result_.blind = result_.lower = -split_.most();
  }

  IntervalSolution solve();

 private:
  void bound_simply();
  // An end is worth 0.
  double with_end(double least) const { return split_.ends() ? std::min(least, 0.0) : least; }
  double law_slack(double off, double lost, double span) const;
  double reward_slack() const;
  double start_slack() const;
  double lower_slack(double least) const;
  double upper_slack(double floor) const;
  double find_best_blind(const StateValues& worst);
  void add_first_steps(const StateValues& values);
  void add_vectors(const ClassPolicy& policy, const StateValues& values);
  void find_starts();
  void search();
  void refine();
  bool trial(int start_node, double target);
  int most_uncertain(int node, int choice, double target);
  void bound_start();
  bool make_room();
  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  bool keep_going();
  bool is_close() const;
  double expected_at_start(const StateValues& values) const;
  double best_at_start(const ActionValues& values) const;
  AlphaPolicy alpha_policy() const;
  void look_at_first_actions();

  Clock::time_point begin_;
  const ExactModel& model_;
  SplitModel split_;
  const IntervalOptions& options_;
  const IntervalProgress& progress_;
  BeliefGraph graph_;
  std::vector<Start> starts_;
  std::vector<int> start_nodes_;
  IntervalSolution solution_;
  IntervalResult& result_ = solution_.result;
  double largest_value_ = 0.0;
  double most_ = 0.0;   // no state is worth more ...
  double worst_ = 0.0;  // ... and no policy is worth less
  double upper_slack_ = 0.0;
  double open_gap_ = 0.0;  // at the start, before slack
  double steps_ = 0.0;     // of an episode, discounted, on the real numbers too
  double rounding_ = 0.0;  // what the solver's own arithmetic can have changed
  double last_report_ = 0.0;
  bool stopped_ = false;
  double trying_ = 0.0;    // seconds of trials ...
  double refining_ = 0.0;  // ... and of refinement
  std::size_t longest_trial_ = kLongTrial;
  UpperPoints points_;   // of the refinement
  int lower_waits_ = 0;  // refinements until the lower bound has its turn
  int lower_rests_ = 1;
};

double IntervalSearch::expected_at_start(const StateValues& values) const {
  double sum = 0.0;
  for (const Start& start : starts_) {
    for (std::size_t i = 0; i < start.belief.states.size(); ++i) {
      sum += start.probability * start.belief.probabilities[i] *
             values[index(split_.first(start.of_class) + start.belief.states[i])];
    }
  }
  return sum;
}

double IntervalSearch::best_at_start(const ActionValues& values) const {
  double sum = 0.0;
  for (const Start& start : starts_) {
    sum += start.probability *
           best_value(split_, values, start.of_class, start.belief.states, start.belief.probabilities);
  }
  return sum;
}

bool IntervalSearch::keep_going() {
  if (stopped_) return false;
  result_.seconds = seconds();
  if (result_.seconds - last_report_ >= kSecondsBetweenReports) {
    last_report_ = result_.seconds;
    stopped_ = !progress_(result_);
    if (stopped_) result_.end = IntervalEnd::kStopped;
  }
  if (!stopped_ && result_.seconds >= options_.seconds) {
    stopped_ = true;
    result_.end = IntervalEnd::kTime;
  }
  return !stopped_;
}

// The bounds that need no search, from the widest to the narrowest.
void IntervalSearch::bound_simply() {
  const KeepGoing going = [this] { return keep_going(); };
  const StateValues mdp = mdp_values(split_, going);
  const StateValues worst = worst_values(split_, going);
  largest_value_ = split_.largest_reward();
  if (largest_value_ > 0.0) result_.least_size = std::min(1.0, largest_value_);
  for (const StateValues* values : {&mdp, &worst}) {
    for (const double value : *values) largest_value_ = std::max(largest_value_, std::abs(value));
  }
  ActionValues q = qmdp_values(split_, mdp);
  result_.qmdp = best_at_start(q);
  solution_.qmdp = policy_of(model_, split_, q);
  q = fib_values(split_, std::move(q), going);
  result_.fib = best_at_start(q);
  result_.mdp = expected_at_start(mdp);
  most_ = split_.ends() ? 0.0 : -split_.most();
  worst_ = split_.ends() ? 0.0 : split_.most();
  for (const auto& of_class : q) {
    for (const double value : of_class) most_ = std::max(most_, value);
  }
  for (const double value : worst) worst_ = std::min(worst_, value);
  graph_.set_worst(worst_);
  rounding_ = split_.rounding() * largest_value_;
  steps_ = split_.steps();
  if (split_.is_long() && split_.ends() && !split_.is_endless()) {
    const double stay = longest_stay(split_, going);
    const double less = 1.0 - stay * model_.rounding.step;
    if (less > 0.0) steps_ = std::min(steps_, stay / less);
  }
  for (int c = 0; c < split_.classes(); ++c) {
    const auto from = worst.begin() + split_.first(c);
    graph_.add_class(AlphaVectors(std::vector<double>(from, from + split_.size(c))),
                     Sawtooth(std::move(q[index(c)]), index(split_.size(c)), split_.actions(c).size()));
  }
  if (split_.is_endless()) {
    add_first_steps(worst);
  } else {
    // Any policy is worth at least the worst values, this one too.
    add_vectors(blind_policy(split_, 0), worst);
  }
  upper_slack_ = upper_slack(find_best_blind(worst));
  result_.mdp += upper_slack_;
  result_.qmdp += upper_slack_;
  result_.upper = result_.fib += upper_slack_;
  result_.slack = std::max(upper_slack_, lower_slack(worst_));
}

// What the model's probabilities can have changed of what a step earns and comes to, where they differ by
// `off` in all and values by `span`; `lost` of it may be outcomes that were never enumerated.
double IntervalSearch::law_slack(double off, double lost, double span) const {
  const TextRounding& text = model_.rounding;
  const double reward = std::isfinite(text.drawn_reward) ? text.drawn_reward : split_.largest_reward();
  const double all = std::isfinite(text.largest_return) ? 2.0 * text.largest_return : most_ - worst_;
  const double seen = std::max(0.0, off - lost);
  return (seen + lost) * reward + 0.5 * split_.discount() * (seen * span + lost * std::max(all, span));
}

double IntervalSearch::reward_slack() const {
  const double text = model_.rounding.reward;
  return std::isfinite(text) ? text : kUnknown * split_.largest_reward();
}

double IntervalSearch::start_slack() const {
  const double all = model_.rounding.largest_return;
  return 0.5 * model_.rounding.start * std::max(std::isfinite(all) ? 2.0 * all : 0.0, most_ - worst_);
}

// What a policy can be worth less on the real numbers of the text, where it is never worth less than `least`
// in what it comes to. In each step its two values differ by what rewards differ, and by half of what
// probabilities differ times the span of what may follow.
double IntervalSearch::lower_slack(double least) const {
  const TextRounding& text = model_.rounding;
  const double in_step = reward_slack() + law_slack(text.step, text.lost, most_ - with_end(least));
  return rounding_ + steps_ * in_step + start_slack();
}

// What the best policy can be worth more on the real numbers. As above; or, where probabilities differ by a
// part of themselves, by that part of what the most is above the policy's value, which is `floor` or more.
double IntervalSearch::upper_slack(double floor) const {
  const TextRounding& text = model_.rounding;
  const double reward = std::isfinite(text.drawn_reward) ? text.drawn_reward : split_.largest_reward();
  const double in_step = reward_slack() + text.relative * (reward + split_.discount() * (most_ - floor)) +
                         law_slack(text.rest, text.rest, most_ - worst_);
  // The policy's value on the real numbers is itself off by what is asked for.
  const double grows = 1.0 - steps_ * text.relative;
  const double by_part =
      grows > 0.5 ? rounding_ + steps_ * in_step / grows + start_slack() : lower_slack(worst_);
  return std::min(lower_slack(worst_), by_part);
}

// Returns what the best policy is worth at least at any belief, on the real numbers too.
double IntervalSearch::find_best_blind(const StateValues& worst) {
  double floor = worst_;
  result_.acts_at_random = split_.is_endless();
  ClassPolicy best_policy = blind_policy(split_, 0);
  StateValues best_values = worst;
  for (int action = 0; action < static_cast<int>(model_.actions.size()) && keep_going(); ++action) {
    ClassPolicy policy = blind_policy(split_, action);
    StateValues values = policy_values(split_, policy, [this] { return keep_going(); });
    if (values.empty()) continue;
    result_.acts_at_random = false;
    add_vectors(policy, values);
    floor = std::max(floor, *std::min_element(values.begin(), values.end()));
    if (expected_at_start(values) <= expected_at_start(best_values)) continue;
    best_policy = std::move(policy);
    best_values = std::move(values);
  }
  const double least = best_values.empty() ? 0.0 : *std::min_element(best_values.begin(), best_values.end());
  result_.lower = result_.blind = expected_at_start(best_values) - lower_slack(least);
  std::vector<AlphaPolicy::Class> classes(index(split_.classes()));
  for (int c = 0; c < split_.classes(); ++c) {
    if (best_policy[index(c)] < 0) continue;
    const auto from = best_values.begin() + split_.first(c);
    classes[index(c)].vectors.push_back({split_.actions(c)[index(best_policy[index(c)])].action,
                                         {},
                                         std::vector<double>(from, from + split_.size(c))});
  }
  solution_.blind = AlphaPolicy(model_, std::move(classes));
  return with_end(floor) - lower_slack(floor);
}

void IntervalSearch::add_vectors(const ClassPolicy& policy, const StateValues& values) {
  const double least = values.empty() ? 0.0 : *std::min_element(values.begin(), values.end());
  for (int c = 0; c < split_.classes(); ++c) {
    const auto from = values.begin() + split_.first(c);
    AlphaVector vector;
    vector.choice = policy[index(c)];
    vector.least = least;
    vector.values.assign(from, from + split_.size(c));
    graph_.add(c, std::move(vector));
  }
}

// A vector for each action, after which the agent acts as `values` say whatever it sees.
void IntervalSearch::add_first_steps(const StateValues& values) {
  const ActionValues q = qmdp_values(split_, values);
  for (int c = 0; c < split_.classes(); ++c) {
    const std::size_t width = split_.actions(c).size();
    if (width == 0)
      graph_.add(c, {0, -1, {}, std::vector<double>(index(split_.size(c)), 0.0), {}, 0.0, worst_});
    for (std::size_t a = 0; a < width; ++a) {
      AlphaVector vector;
      vector.choice = static_cast<int>(a);
      vector.least = worst_;
      for (std::size_t at = a; at < q[index(c)].size(); at += width) vector.values.push_back(q[index(c)][at]);
      graph_.add(c, std::move(vector));
    }
  }
}

void IntervalSearch::find_starts() {
  start_nodes_.clear();
  for (const Start& start : starts_) start_nodes_.push_back(graph_.node_of(start.of_class, start.belief));
  points_ = {start_nodes_, {}};
}

void IntervalSearch::bound_start() {
  double lower = 0.0;
  double upper = 0.0;
  double least = 0.0;
  for (std::size_t i = 0; i < starts_.size(); ++i) {
    lower += starts_[i].probability * graph_.lower(start_nodes_[i]);
    least = std::min(least, graph_[start_nodes_[i]].best->least);
    upper += starts_[i].probability * graph_.upper(start_nodes_[i]);
  }
  open_gap_ = upper - lower;
  result_.lower = std::max(result_.lower, lower - lower_slack(least));
  result_.upper = std::min(result_.upper, upper + upper_slack_);
  result_.beliefs = graph_.nodes();
  result_.points = graph_.points();
  result_.vectors = graph_.vectors();
}

bool IntervalSearch::is_close() const {
  return result_.upper - result_.lower <= options_.gap * result_.size();
}

// The successor whose interval is wider than the target by most, weighted; -1 if none is.
int IntervalSearch::most_uncertain(int node, int choice, double target) {
  int next = -1;
  double most = 0.0;
  const std::size_t successors = graph_[node].choices[index(choice)].successors.size();
  for (std::size_t i = 0; i < successors; ++i) {
    const Successor successor = graph_[node].choices[index(choice)].successors[i];
    const double excess =
        successor.probability * (graph_.upper(successor.node) - graph_.lower(successor.node) - target);
    if (excess <= most) continue;
    most = excess;
    next = successor.node;
  }
  return next;
}

// False if it was cut off.
bool IntervalSearch::trial(int node, double target) {
  std::vector<int> path;
  bool is_cut = false;
  while (node >= 0 && keep_going()) {
    is_cut = split_.closes_loops() && path.size() >= longest_trial_;
    if (is_cut) break;
    path.push_back(node);
    const int choice = graph_.best_choice(node);
    target /= split_.discount();
    node = choice < 0 ? -1 : most_uncertain(node, choice, target);
  }
  for (auto it = path.rbegin(); it != path.rend(); ++it) graph_.back_up(*it, kNothing * largest_value_);
  return !is_cut;
}

// Takes as long as trials do, unless these show little of long episodes. What closed little waits longer.
void IntervalSearch::refine() {
  if (!split_.closes_loops() || (refining_ > trying_ + kFirstRefining && !split_.is_long())) return;
  const KeepGoing going = [this] { return keep_going(); };
  refine_upper(split_, graph_, start_nodes_, points_, going);
  if (--lower_waits_ > 0) return;
  const double before = result_.lower;
  refine_lower(split_, graph_, start_nodes_, points_.nodes, going);
  bound_start();
  const bool helped = result_.lower - before > kWorthIt * (result_.upper - result_.lower);
  lower_rests_ = helped ? 1 : std::min(2 * lower_rests_, 16);
  lower_waits_ = lower_rests_;
}

// Keeps to the memory; false if vectors and points alone do not.
bool IntervalSearch::make_room() {
  graph_.prune_points();
  const auto room = static_cast<double>(options_.bytes);
  if (static_cast<double>(graph_.bound_bytes()) > (1.0 - kNodeShare) * room) return false;
  if (static_cast<double>(graph_.node_bytes()) > kNodeShare * room) {
    graph_.clear();
    find_starts();
  }
  return true;
}

void IntervalSearch::search() {
  find_starts();
  bound_start();
  while (!is_close() && keep_going()) {
    std::size_t widest = 0;
    double width = 0.0;
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      const int node = start_nodes_[i];
      const double now = starts_[i].probability * (graph_.upper(node) - graph_.lower(node));
      if (now > width) widest = i;
      width = std::max(width, now);
    }
    const std::uint64_t before = graph_.changes();
    const double begin = seconds();
    const bool whole = trial(start_nodes_[widest], kTrialTarget * open_gap_);
    ++result_.iterations;
    const double middle = seconds();
    refine();
    trying_ += middle - begin;
    refining_ += seconds() - middle;
    bound_start();
    if (graph_.changes() == before && !whole) longest_trial_ *= 2;
    if (graph_.changes() == before && whole && !is_close() && keep_going()) {
      result_.end = IntervalEnd::kRounding;
      return;
    }
    if (!make_room()) {
      result_.end = IntervalEnd::kMemory;
      return;
    }
  }
  if (is_close()) result_.end = IntervalEnd::kConverged;
}

AlphaPolicy IntervalSearch::alpha_policy() const {
  std::vector<AlphaPolicy::Class> all(index(split_.classes()));
  for (int c = 0; c < split_.classes(); ++c) {
    const AlphaVectors& lower = graph_.lower_bounds()[index(c)];
    bool sparse = false;
    for (const AlphaVector* vector : lower.vectors()) {
      if (vector->choice < 0) continue;
      sparse = sparse || !vector->states.empty();
      const int action = split_.actions(c)[index(vector->choice)].action;
      all[index(c)].vectors.push_back({action, vector->states, vector->values});
    }
    if (sparse) all[index(c)].rest = lower.worst();
  }
  return AlphaPolicy(model_, std::move(all));
}

void IntervalSearch::look_at_first_actions() {
  const bool hurries = result_.end == IntervalEnd::kStopped;
  const double until =
      seconds() + (hurries ? kFirstSeconds : std::max(kFirstSeconds, kFirstShare * options_.seconds));
  const double room = kNodeShare * static_cast<double>(options_.bytes);
  solution_.first = hypgen::exact::look_at_first_actions(
      model_, split_, graph_, start_nodes_, {lower_slack(worst_), upper_slack_}, kNothing * largest_value_,
      [&] { return seconds() < until && static_cast<double>(graph_.node_bytes()) < room; });
  bound_start();
}

IntervalSolution IntervalSearch::solve() {
  bound_simply();
  search();
  look_at_first_actions();
  result_.seconds = seconds();
  solution_.alpha = alpha_policy();
  choose_first_actions(model_, solution_.alpha, result_.lower, solution_.first);
  return std::move(solution_);
}

}  // namespace

IntervalSolution solve_interval(const ExactModel& model, const IntervalOptions& options,
                                const IntervalProgress& progress) {
  return IntervalSearch(model, options, progress).solve();
}

}  // namespace hypgen::exact
