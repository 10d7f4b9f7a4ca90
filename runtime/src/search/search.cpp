// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/search.hpp"

#include <algorithm>

namespace hypgen {

namespace {

// The time after its deadline that a search waits for threads that have lost their core.
constexpr std::chrono::microseconds kGrace{500};

// How long a search whose own thread has ended waits for the others.
Clock::time_point end_of_wait(const Deadline& deadline) {
  if (deadline.is_cancelled()) return Clock::now() + kGrace;
  return deadline.is_limited() ? deadline.time() + kGrace : deadline.time();
}

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

Search::Search(const PlannerOptions& options, const TreeOptions& tree)
    : shared_(options, tree), workers_(tree.threads - 1, [this](std::size_t thread) { work(thread); }) {
  const std::size_t threads = workers_.size() + 1;
  for (std::size_t i = 0; i < threads; ++i) {
    // Each thread needs at least one trial to do anything.
    const std::size_t share = options.in_flight / threads + (i < options.in_flight % threads ? 1 : 0);
    shared_.threads.push_back(std::make_unique<SearchThread>(shared_, i, std::max<std::size_t>(1, share)));
  }
}

void Search::work(std::size_t thread) {
  if (job_ == nullptr) return shared_.run_thread(thread);
  do_jobs();
}

void Search::do_jobs() {
  for (std::size_t number = next_job_.fetch_add(1, std::memory_order_relaxed); number < job_count_;
       number = next_job_.fetch_add(1, std::memory_order_relaxed)) {
    (*job_)(number);
  }
}

std::size_t Search::share_until(std::size_t count, const Job& job, Clock::time_point deadline) {
  has_left_jobs_ = has_left_jobs_ && park(Clock::now()) > 0;
  if (count <= 1 || workers_.size() == 0 || has_left_jobs_) {
    hypgen::share(nullptr, count, job);
    return 0;
  }
  job_ = &job;
  job_count_ = count;
  next_job_.store(0, std::memory_order_relaxed);
  workers_.start();
  do_jobs();
  const std::size_t late = workers_.park_round(deadline);
  has_left_jobs_ = late > 0;
  return late;
}

void Search::run(LeafEvaluator& evaluator, const RootResult& root, const SearchSetup& setup,
                 Span<const int> actions, Decision& decision) {
  const Clock::time_point start_time = Clock::now();
  shared_.begin(evaluator, root, setup, actions);
  const bool is_alone = workers_.size() == 0 || shared_.is_stopped();
  job_ = nullptr;
  if (!is_alone) workers_.start();
  shared_.run_thread(0);
  decision.late_threads = is_alone ? 0 : workers_.park(end_of_wait(setup.deadline));
  // Threads that end because all trials are done do not stop the search.
  Status status = shared_.is_stopped() ? shared_.status.load() : Status::kTrialLimit;
  // A status that the planner has to act on goes before crossed bounds.
  if (shared_.has_crossed_at_root && !is_failure(status) && status != Status::kDeviceLost)
    status = Status::kCrossedBounds;
  decision.status = status;
  decision.lower = shared_.tree.root().child->lower;
  decision.upper = shared_.tree.root().child->upper;
  add_counts(decision);
  decision.tree_seconds = seconds_since(start_time) - decision.waiting_seconds;
}

// Late threads count too, with what they have done so far.
void Search::add_counts(Decision& decision) const {
  for (std::size_t i = 0; i < shared_.threads.size(); ++i) {
    shared_.threads[i]->counts().add_to(decision);
    decision.nodes += shared_.tree.nodes(i);
    decision.crossed += shared_.tree.crossed(i);
  }
  const auto searching = static_cast<double>(std::min(shared_.threads.size(), shared_.evaluator->threads()));
  decision.waiting_seconds /= searching;
  decision.descent_seconds /= searching;
  decision.backup_seconds /= searching;
}

void Search::add_leaf_sizes(std::vector<std::uint64_t>& leaf_sizes) {
  park(Clock::time_point::max());
  for (const auto& thread : shared_.threads) {
    for (std::size_t i = 0; i < leaf_sizes.size(); ++i) leaf_sizes[i] += thread->leaf_sizes()[i];
  }
}

double Search::improvement(int action) const {
  const Node& root = shared_.tree.root();
  const Expansion* const expansion = root.expanded();
  for (std::uint32_t i = 0; expansion != nullptr && i < expansion->action_count; ++i) {
    if (expansion->rows[i].action == action) {
      return shared_.tree.action_lower(root, i) - shared_.tree.first_lower(root, i);
    }
  }
  return 0.0;
}

std::vector<RootAction> Search::root_actions() const {
  std::vector<RootAction> found;
  const Tree& tree = shared_.tree;
  if (tree.is_empty() || tree.root().expanded() == nullptr) return found;
  const Expansion& expansion = *tree.root().expanded();
  for (std::uint32_t i = 0; i < expansion.action_count; ++i) {
    RootAction& one = found.emplace_back();
    one.action = expansion.rows[i].action;
    one.lower = tree.action_lower(tree.root(), i);
    one.upper = expansion.uppers()[i].load();
    if (tree.keeps_values()) one.mean = tree.mean_value(tree.root(), i);
    const ActionTable* const table = tree.table(expansion, i);
    if (table == nullptr) continue;
    for (const Child& child : *table) one.visits += child.visits();
  }
  return found;
}

int Search::best_action(int default_action) const {
  const Node& root = shared_.tree.root();
  if (shared_.tree.keeps_values()) {
    const std::uint32_t best = root.expanded() == nullptr ? kNoIndex : shared_.tree.best_value(root, 0.0);
    return best == kNoIndex ? default_action : root.expanded()->rows[best].action;
  }
  double best = root.child->default_value;
  int action = default_action;
  const Expansion* const expansion = root.expanded();
  for (std::uint32_t i = 0; expansion != nullptr && i < expansion->action_count; ++i) {
    const int candidate = expansion->rows[i].action;
    const double lower = shared_.tree.action_lower(root, i);
    if (lower > best || (lower == best && candidate == default_action)) {
      best = lower;
      action = candidate;
    }
  }
  return action;
}

}  // namespace hypgen
