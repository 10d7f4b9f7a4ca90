// SPDX-License-Identifier: Apache-2.0
#include "hypgen/search/search_thread.hpp"

#include "hypgen/leaves/weighted_sums.hpp"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif
#include <sched.h>

#include <algorithm>

#include "hypgen/leaves/rolled_actions.hpp"

namespace hypgen {

namespace {

constexpr unsigned kLongestPause = 64;  // in instructions; a thread that pauses longer yields its core
constexpr unsigned kActivityBits = 16;

void relax_core() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#endif
}

// Whether the planner has to act on a status. Such a status must not pass for an ordinary limit.
bool is_grave(Status status) { return is_failure(status) || status == Status::kDeviceLost; }

}  // namespace

void SharedSearch::begin(LeafEvaluator& leaf_evaluator, const RootResult& root,
                         const SearchSetup& search_setup, Span<const int> actions) {
  root_actions = actions;
  evaluator = &leaf_evaluator;
  setup = search_setup;
  status = Status::kOk;
  trials = 0;
  for (const auto& thread : threads) thread->reset();
  has_crossed_at_root = false;
  if (tree.reset(root.row, setup.weighted ? kScenarioMass : 1)) {
    has_crossed_at_root = tree.crossed(0) > 0;
    threads[0]->expand_root();
  } else {
    stop(Status::kMemoryFull);
  }
}

void SharedSearch::stop(Status reason) {
  Status before = status.load();
  while (before == Status::kOk || (is_grave(reason) && !is_grave(before))) {
    if (status.compare_exchange_weak(before, reason)) return;
  }
}

bool SharedSearch::take_trial() {
  if (options.trial_limit == UINT64_MAX) return true;
  std::uint64_t taken = trials.load(std::memory_order_relaxed);
  while (taken < options.trial_limit) {
    if (trials.compare_exchange_weak(taken, taken + 1, std::memory_order_relaxed)) return true;
  }
  return false;
}

void SharedSearch::give_trial_back() {
  if (options.trial_limit != UINT64_MAX) trials.fetch_sub(1, std::memory_order_relaxed);
}

void SharedSearch::run_thread(std::size_t number) {
  if (number >= evaluator->threads()) return;
  evaluator->attach(number);
  threads[number]->run();
}

SearchThread::SearchThread(SharedSearch& shared, std::size_t number, std::size_t in_flight)
    : shared_(shared),
      tree_(shared.tree),
      number_(number),
      queue_(in_flight),
      leaf_sizes_(shared.options.scenarios + 1) {
  requests_.reserve(in_flight);
}

void SearchThread::reset() {
  head_ = size_ = sent_ = waiting_ = 0;
  counts_ = {};
  rest_ = 0;
  pauses_ = 0;
  has_expanded_here_ = false;
  crowded_ = 0;
  activity_.store(0, std::memory_order_relaxed);
}

void SearchThread::expand_root() {
  tree_.enter(tree_.root());
  push({&tree_.root(), true});
  LeafResult leaf{};
  Status status = wait(leaf);
  pop();
  if (status == Status::kOk) status = take(tree_.root(), leaf);
  tree_.backup(tree_.root());
  if (status != Status::kOk) shared_.stop(status);
}

void SearchThread::run() {
  Status status = shared_.status.load();
  while (status == Status::kOk) {
    status = advance();
    if (at_hand() != waiting_) publish(waiting_);
    if (status == Status::kOk) status = shared_.status.load();
  }
  // A thread that has no trial to start ends alone.
  if (status != Status::kTrialLimit) shared_.stop(status);
  abandon();
}

Status SearchThread::advance() {
  if (tree_.root().child->gap() <= shared_.options.gap * tree_.scale()) return Status::kConverged;
  const bool has_started_all = shared_.trials.load(std::memory_order_relaxed) >= shared_.options.trial_limit;
  if (has_started_all && size_ == 0) return Status::kTrialLimit;
  if (has_started_all || size_ == queue_.size()) return apply_oldest();
  LeafResult leaf;
  return has_expanded_here_ && is_ready(leaf) ? apply(leaf) : start_trial();
}

// Whether the oldest trial's leaf is there. A thread that expands most leaves itself never fills its queue, so
// that it asks after each trial.
bool SearchThread::is_ready(LeafResult& leaf) {
  if (size_ == 0 || !in_queue(0).waits) return false;
  send();
  return shared_.evaluator->poll(number_, leaf);
}

Status SearchThread::start_trial() {
  const SearchSetup& setup = shared_.setup;
  if (setup.deadline.has_passed()) return Status::kDeadline;
  if (waiting_ == 0 && tree_.is_closed(tree_.root())) {
    idle();
    return Status::kOk;
  }
  if (!shared_.take_trial()) return Status::kOk;
  counts_.trials.add(1);
  const std::uint64_t before = activity_.load(std::memory_order_relaxed);
  publish(waiting_ + 1);
  Node* node = &tree_.root();
  tree_.enter(*node);
  const Progress progress = timed_walk(node, false);
  if (progress == Progress::kFailed) return failure_;
  if (progress == Progress::kRequested) {
    pauses_ = 0;
    return Status::kOk;
  }
  const bool is_alone = waiting_ == 0;
  const bool found_nothing = progress == Progress::kWithoutEffect || progress == Progress::kBackedOut;
  // If no thread has a trial, all uncertainty left is rounding.
  const bool has_converged = is_alone && progress == Progress::kWithoutEffect && is_search_at_rest();
  if (is_alone && found_nothing && !has_converged) return undo_trial(node, before);
  if (progress == Progress::kWithoutEffect) tree_.backup(*node);
  if (has_converged) return Status::kConverged;
  // It keeps the place in which a leaf would wait, so that the order of trials does not depend on time.
  if (!has_expanded_here_) push({nullptr, false});
  return Status::kOk;
}

// Takes back a trial that found nothing to do while others have all the work. If such trials counted, threads
// beside a long leaf would use up a limit at once. `node` is the trial's deepest node; null: it has left all.
Status SearchThread::undo_trial(Node* node, std::uint64_t activity) {
  for (; node != nullptr; node = node->parent) tree_.leave(*node);
  counts_.trials.set(counts_.trials.get() - 1);
  shared_.give_trial_back();
  activity_.store(activity, std::memory_order_release);  // as before the trial
  idle();
  return Status::kOk;
}

Status SearchThread::apply_oldest() {
  if (!in_queue(0).waits) {
    pop();
    return Status::kOk;
  }
  LeafResult leaf{};
  const Status status = wait(leaf);
  if (status == Status::kOk) return apply(leaf);
  tree_.backup(*pop().node);
  return status;
}

// Expands the oldest trial's node, and lets the trial go on.
Status SearchThread::apply(const LeafResult& leaf) {
  Node* node = pop().node;
  const Status status = take(*node, leaf);
  if (status != Status::kOk) {
    tree_.backup(*node);
    return status;
  }
  return timed_walk(node, true) == Progress::kFailed ? failure_ : Status::kOk;
}

// Expands a node.
Status SearchThread::take(Node& node, const LeafResult& leaf) {
  if (leaf.status != Status::kOk) return leaf.status;
  if (leaf.ticket != node.number) return Status::kEvaluatorFailed;
  if (!tree_.expand(number_, node, leaf)) return Status::kMemoryFull;
  counts_.add_expansion(leaf, node.depth);
  ++leaf_sizes_[leaf.count];
  return Status::kOk;
}

// Whether this thread has expanded a node that it has claimed, or has failed to: then `failure` says why.
bool SearchThread::expands_here(Node& node, Status& failure) {
  const Clock::time_point start = Clock::now();
  LeafResult leaf{};
  failure = shared_.setup.deadline.has_passed(start) ? Status::kDeadline : shared_.status.load();
  if (failure != Status::kOk) return true;
  // In a narrow tree no thread finds more leaves to send.
  const std::size_t at_once = crowded_ > 0 ? waiting_ + 1 : queue_.size();
  if (crowded_ > 0) --crowded_;
  if (!shared_.evaluator->expand_here(number_, request(node), at_once, leaf)) return false;
  has_expanded_here_ = true;
  failure = take(node, leaf);
  const Clock::duration time = Clock::now() - start;
  expansion_time_ += time;
  counts_.waiting.add(time);
  return true;
}

Status SearchThread::wait(LeafResult& leaf) {
  const Clock::time_point start = Clock::now();
  const Deadline& deadline = shared_.setup.deadline;
  // Trials may go on from leaf to leaf without a new start: this ends them even if no leaf is late.
  if (deadline.has_passed(start)) return Status::kDeadline;
  Clock::time_point now = start;
  Status status = Status::kOk;
  send();
  while (!shared_.evaluator->poll(number_, leaf)) {
    now = Clock::now();
    status = shared_.status.load();
    if (deadline.has_passed(now)) status = Status::kDeadline;
    if (std::chrono::duration<double>(now - start).count() > shared_.options.patience)
      status = Status::kEvaluatorFailed;
    if (status != Status::kOk) break;
    send();
    if (shared_.threads.size() > 1) pause();
  }
  pauses_ = 0;
  counts_.waiting.add(Clock::now() - start);
  return status;
}

// Submits the leaves of the queue that the evaluator does not have yet, as many as it takes.
void SearchThread::send() {
  requests_.clear();
  for (std::size_t i = sent_; i < size_; ++i) {
    if (in_queue(i).waits) requests_.push_back(request(*in_queue(i).node));
  }
  std::size_t taken = requests_.empty() ? 0 : shared_.evaluator->submit(number_, requests_);
  while (sent_ < size_ && (!in_queue(sent_).waits || taken > 0)) {
    if (in_queue(sent_).waits) --taken;
    ++sent_;
  }
}

// A walk. Of one in kTimedWalks it counts the time, apart from expansions and the backup at the end.
SearchThread::Progress SearchThread::timed_walk(Node*& node, bool has_expanded) {
  if (--walks_to_timed_ > 0) return walk(node, has_expanded);
  walks_to_timed_ = kTimedWalks;
  is_timed_ = true;
  backup_time_ = expansion_time_ = {};
  const Clock::time_point start = Clock::now();
  const Progress progress = walk(node, has_expanded);
  is_timed_ = false;
  counts_.descent.add(kTimedWalks * (Clock::now() - start - backup_time_ - expansion_time_));
  counts_.backup.add(kTimedWalks * backup_time_);
  return progress;
}

// Backs up at the end of a walk.
void SearchThread::backup(Node& node) {
  if (!is_timed_) return tree_.backup(node);
  const Clock::time_point start = Clock::now();
  tree_.backup(node);
  backup_time_ = Clock::now() - start;
}

SearchThread::Progress SearchThread::walk(Node*& node, bool has_expanded) {
  if (shared_.options.mode != Mode::kPomcp) return walk_by_bounds(node, has_expanded);
  if (!has_expanded) return walk_by_values(node);
  backup(*node);  // a trial of POMCP expands one leaf
  return Progress::kEnded;
}

// One trial (Algorithm 2, EXPLORE), from an expanded node down: to a leaf, or to where the excess uncertainty
// is gone. Where everything below a node is in expansion, the trial leaves that node and goes on from its
// parent. A trial that has expanded a leaf goes back no further than to that leaf: it has happened, so its
// visits stay and its bounds go up to the root. `node` becomes where a trial without effect is. Any other
// trial has been backed up or has left all nodes.
SearchThread::Progress SearchThread::walk_by_bounds(Node*& node, bool has_expanded) {
  const PlannerOptions& options = shared_.options;
  const Node* expanded = has_expanded ? node : nullptr;
  const BranchRule rule =
      tree_.branch_rule({options.target_ratio, options.observation_loss, options.exploration});
  while (true) {
    const Branch branch = choose(*node, rule);
    if (branch.kind == Branch::kClosed) {
      collide();
      if (node == expanded) {
        backup(*node);
        return Progress::kEnded;
      }
      tree_.leave(*node);
      node = node->parent;
      if (node == nullptr) return Progress::kBackedOut;
      continue;
    }
    if (branch.kind == Branch::kStop) {
      if (expanded == nullptr) return Progress::kWithoutEffect;
      backup(*node);
      return Progress::kEnded;
    }
    Node* const next = branch.kind == Branch::kFull
                           ? nullptr
                           : tree_.visit(number_, *node, branch.action, *branch.table, *branch.child);
    if (next == nullptr) {
      failure_ = Status::kMemoryFull;
      backup(*node);
      return Progress::kFailed;
    }
    tree_.enter(*next);
    const bool is_deepest = next->depth >= shared_.setup.depth_limit;
    if (is_deepest || (tree_.is_regularised() && tree_.is_blocked(*next))) {
      tree_.make_default(*next);
      backup(*next);
      return Progress::kEnded;
    }
    if (next->expanded() != nullptr) {
      node = next;
    } else if (claim(*next)) {
      if (!expands_here(*next, failure_)) {
        push({next, true});
        return Progress::kRequested;
      }
      if (failure_ != Status::kOk) {
        backup(*next);
        return Progress::kFailed;
      }
      node = next;
      expanded = next;
    } else {
      collide();
      tree_.leave(*next);  // another thread has it
    }
  }
}

// Counts that this thread met what is in expansion.
void SearchThread::collide() {
  counts_.collisions.add(1);
  crowded_ = kCrowded;
}

// Gives this thread the expansion of a leaf; false if another thread has it or had it.
bool SearchThread::claim(Node& leaf) {
  if (!tree_.close(leaf)) return false;
  if (leaf.expanded() == nullptr) return true;
  tree_.open(leaf);  // another thread has expanded and opened it since this thread looked
  return false;
}

// Chooses the branch from a node. Closes a node below which everything is taken.
SearchThread::Branch SearchThread::choose(Node& node, const BranchRule& rule) {
  if (tree_.is_closed(node)) return {Branch::kClosed};
  Branch branch = look(node, rule);
  if (branch.kind != Branch::kClosed) return branch;
  tree_.close(node);
  branch = look(node, rule);  // another thread may have opened something below before the node was closed
  if (branch.kind != Branch::kClosed) tree_.open(node);
  return branch;
}

// Gives the best child of the best action. Where all children are in expansion it turns to the next action.
SearchThread::Branch SearchThread::look(const Node& node, const BranchRule& rule) {
  bool met_closed = false;
  const ActionRule action_rule = tree_.action_rule(node, rule);
  ActionChoice action = tree_.best_action(node, action_rule);
  while (action.place != kNoIndex) {
    ActionTable* const table = tree_.open_action(number_, node, action.place);
    if (table == nullptr) return {Branch::kFull};
    const ChildChoice choice = tree_.best_child(*table, rule);
    if (choice.child != nullptr) {
      Branch branch{Branch::kTaken};
      branch.action = action.place;
      branch.table = table;
      branch.child = choice.child;
      return branch;
    }
    met_closed |= choice.met_closed;
    if (!met_closed) break;
    action = tree_.next_action(node, action_rule, action);
  }
  return {met_closed ? Branch::kClosed : Branch::kStop};
}

LeafRequest SearchThread::request(const Node& node) const {
  LeafRequest request;
  request.ticket = node.number;
  request.first = node.child->first;
  request.count = node.child->count;
  request.depth = node.depth;
  const PlannerOptions& options = shared_.options;
  if (options.mode != Mode::kPomcp) request.rolled = options.rolled;  // POMCP ranks actions by their rollouts
  if (node.parent != nullptr) {
    const Expansion& above = *node.parent->expanded();
    const ActionRow& row = above.rows[node.action];
    request.parent = above.handle;
    request.action = row.action;
    request.lower_sum = above.child_rows[row.first_child + (node.child - node.table->children())].lower_sum;
    return request;
  }
  request.actions = shared_.root_actions;
  if (request.rolled == kRollsAll) return request;
  // What a tree adds to an action's lower bound counts from its rollouts, and not from a floor.
  const auto given = static_cast<std::uint32_t>(request.actions.size());
  request.rolled = std::max({request.rolled, options.rolled_at_root, given});
  return request;
}

void SearchThread::push(Trial trial) {
  in_queue(size_++) = trial;
  if (trial.waits) ++waiting_;
}

SearchThread::Trial SearchThread::pop() {
  const Trial trial = in_queue(0);
  head_ = (head_ + 1) % queue_.size();
  --size_;
  if (sent_ > 0) --sent_;
  if (trial.waits) --waiting_;
  return trial;
}

// Ends all trials in flight with the bounds that they have found so far.
void SearchThread::abandon() {
  while (size_ > 0) {
    const Trial trial = pop();
    if (trial.waits) tree_.backup(*trial.node);
  }
  publish(0);
}

std::size_t SearchThread::at_hand() const {
  return activity_.load(std::memory_order_relaxed) % (std::uint64_t{1} << kActivityBits);
}

void SearchThread::publish(std::size_t at_hand) {
  const std::uint64_t times = (activity_.load(std::memory_order_relaxed) >> kActivityBits) + 1;
  activity_.store(times << kActivityBits | at_hand, std::memory_order_release);
}

// Whether no other thread has a trial at hand, or has had one since this thread last asked. Then two trials
// of this thread found nothing to do in the same tree, and no thread changes it any more.
bool SearchThread::is_search_at_rest() {
  std::uint64_t others = 0;
  for (const auto& thread : shared_.threads) {
    if (thread.get() == this) continue;
    const std::uint64_t activity = thread->activity_.load(std::memory_order_acquire);
    if (activity % (std::uint64_t{1} << kActivityBits) != 0) return false;
    others += activity;
  }
  const bool is_same = others == rest_;
  rest_ = others;
  return is_same;
}

// Lets the evaluator work on the leaves of other threads, and pauses.
void SearchThread::idle() {
  LeafResult none;
  shared_.evaluator->poll(number_, none);
  pause();
}

// Waits for other threads, each time longer until there is something to do.
void SearchThread::pause() {
  if (pauses_ < kLongestPause) {
    pauses_ = std::max(1U, 2 * pauses_);
    for (unsigned i = 0; i < pauses_; ++i) relax_core();
  } else {
    sched_yield();
  }
}

}  // namespace hypgen
