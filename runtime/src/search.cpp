#include "hypgen/search.hpp"

#include <algorithm>

namespace hypgen {

namespace {

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

void count_expansion(const LeafResult& leaf, int depth, Decision& decision,
                     std::vector<std::uint64_t>& leaf_sizes) {
  ++decision.expansions;
  ++leaf_sizes[leaf.count];
  decision.leaf_scenarios += leaf.count;
  decision.simulations += std::uint64_t{leaf.count} * leaf.actions.size();
  decision.max_depth = std::max(decision.max_depth, depth);
}

Search::Search(const PlannerOptions& options, const TreeOptions& tree)
    : options_(options), tree_(tree), queue_(options.in_flight) {
  requests_.reserve(options.in_flight);
}

void Search::run(LeafEvaluator& evaluator, const RootResult& root, const SearchSetup& setup,
                 Decision& decision, std::vector<std::uint64_t>& leaf_sizes) {
  const Clock::time_point start = Clock::now();
  evaluator_ = &evaluator;
  setup_ = setup;
  decision_ = &decision;
  leaf_sizes_ = &leaf_sizes;
  head_ = size_ = sent_ = waiting_ = 0;
  Status status = tree_.reset(root.row) ? Status::kOk : Status::kMemoryFull;
  const bool crossed_at_root = tree_.crossed() > 0;
  if (status == Status::kOk) {
    tree_.enter(0);
    push({0, true});
    std::uint32_t node;
    status = expand_oldest(node);
    tree_.backup(0);
  }
  while (status == Status::kOk) status = advance();
  abandon();
  // What the planner has to act on is told first.
  if (crossed_at_root && !is_failure(status) && status != Status::kDeviceLost)
    status = Status::kCrossedBounds;
  decision.status = status;
  decision.lower = tree_.bounds(0).lower;
  decision.upper = tree_.bounds(0).upper;
  decision.nodes = tree_.size();
  decision.crossed = tree_.crossed();
  decision.tree_seconds = seconds_since(start) - decision.waiting_seconds;
}

Status Search::advance() {
  if (tree_.bounds(0).gap() <= options_.gap) return Status::kConverged;
  const bool has_started_all = decision_->trials >= options_.trial_limit;
  if (has_started_all && size_ == 0) return Status::kTrialLimit;
  return has_started_all || size_ == queue_.size() ? apply_oldest() : start_trial();
}

Status Search::start_trial() {
  if (setup_.deadline != Clock::time_point::max() && Clock::now() >= setup_.deadline)
    return Status::kDeadline;
  ++decision_->trials;
  tree_.enter(0);
  switch (walk(0, false)) {
    case Progress::kFull:
      return Status::kMemoryFull;
    case Progress::kRequested:
      return Status::kOk;
    case Progress::kWithoutEffect:
      // With nothing in flight all uncertainty left is rounding.
      if (waiting_ == 0) return Status::kConverged;
      break;
    case Progress::kEnded:
    case Progress::kBackedOut:
      break;
  }
  push({0, false});
  return Status::kOk;
}

Status Search::apply_oldest() {
  if (!in_queue(0).waits) {
    pop();
    return Status::kOk;
  }
  std::uint32_t node;
  const Status status = expand_oldest(node);
  if (status != Status::kOk) {
    tree_.backup(node);
    return status;
  }
  return walk(node, true) == Progress::kFull ? Status::kMemoryFull : Status::kOk;
}

// Takes the oldest trial, which waits, from the queue and expands its node.
Status Search::expand_oldest(std::uint32_t& node) {
  LeafResult leaf{};
  const Status status = wait(leaf);
  node = pop().node;
  if (status != Status::kOk) return status;
  if (leaf.status != Status::kOk) return leaf.status;
  if (leaf.ticket != node) return Status::kEvaluatorFailed;
  if (!tree_.expand(node, leaf)) return Status::kMemoryFull;
  count_expansion(leaf, tree_.node(node).depth, *decision_, *leaf_sizes_);
  return Status::kOk;
}

Status Search::wait(LeafResult& leaf) {
  const Clock::time_point start = Clock::now();
  // An evaluator that is never late would otherwise keep trials that go on from leaf to leaf from stopping.
  if (start >= setup_.deadline) return Status::kDeadline;
  Clock::time_point now = start;
  Status status = Status::kOk;
  send();
  while (!evaluator_->poll(0, leaf)) {
    now = Clock::now();
    if (now >= setup_.deadline) status = Status::kDeadline;
    if (std::chrono::duration<double>(now - start).count() > options_.patience)
      status = Status::kEvaluatorFailed;
    if (status != Status::kOk) break;
    send();
  }
  decision_->waiting_seconds += seconds_since(start);
  return status;
}

// Hands the evaluator as many leaves as it takes.
void Search::send() {
  requests_.clear();
  for (std::size_t i = sent_; i < size_; ++i) {
    if (in_queue(i).waits) requests_.push_back(request(in_queue(i).node));
  }
  std::size_t taken = requests_.empty() ? 0 : evaluator_->submit(0, requests_);
  while (sent_ < size_ && (!in_queue(sent_).waits || taken > 0)) {
    if (in_queue(sent_).waits) --taken;
    ++sent_;
  }
}

// One trial (Algorithm 2, EXPLORE), from an expanded node down: to a leaf, or to where the excess uncertainty
// is gone.
Search::Progress Search::walk(std::uint32_t node, bool has_expanded) {
  while (true) {
    const Branch branch = choose(node);
    if (branch.kind == Branch::kClosed) {
      if (back_out(node) == Progress::kBackedOut) return Progress::kBackedOut;
      continue;
    }
    if (branch.kind == Branch::kStop) {
      tree_.backup(node);
      return has_expanded ? Progress::kEnded : Progress::kWithoutEffect;
    }
    const std::uint32_t next =
        branch.kind == Branch::kFull ? kNoIndex : tree_.visit(node, branch.entry, branch.child);
    if (next == kNoIndex) {
      tree_.backup(node);
      return Progress::kFull;
    }
    tree_.enter(next);
    const bool is_deepest = tree_.node(next).depth >= setup_.depth_limit;
    if (is_deepest || (options_.pruning > 0.0 && tree_.is_blocked(next))) {
      tree_.make_default(next);
      tree_.backup(next);
      return Progress::kEnded;
    }
    if (!tree_.node(next).expanded()) {
      tree_.close(next);
      push({next, true});
      return Progress::kRequested;
    }
    node = next;
  }
}

// Everything below `node` that a trial could take is in expansion: it goes on from the parent, if there is
// one.
Search::Progress Search::back_out(std::uint32_t& node) {
  tree_.close(node);
  tree_.leave(node);
  if (tree_.node(node).parent == kNoIndex) return Progress::kBackedOut;
  node = tree_.node(node).parent;
  return Progress::kRequested;
}

// The best action's best child; the next action's where that is in expansion.
Search::Branch Search::choose(std::uint32_t node) {
  if (tree_.is_closed(node)) return {Branch::kClosed, kNoIndex, kNoIndex};
  const ChildRule rule{options_.target_ratio, options_.observation_loss};
  bool met_closed = false;
  std::uint32_t entry = tree_.node(node).best;
  while (entry != kNoIndex) {
    if (!tree_.open(node, entry)) return {Branch::kFull, kNoIndex, kNoIndex};
    const ChildChoice choice = tree_.best_child(entry, rule);
    if (choice.child != kNoIndex) return {Branch::kTaken, entry, choice.child};
    met_closed |= choice.met_closed;
    if (!met_closed) break;
    entry = tree_.next_action(node, entry);
  }
  return {met_closed ? Branch::kClosed : Branch::kStop, kNoIndex, kNoIndex};
}

LeafRequest Search::request(std::uint32_t node_index) const {
  const Node& node = tree_.node(node_index);
  const Child& child = tree_.child(node.child);
  LeafRequest request{node_index, kNoHandle, 0, child.first, child.count, node.depth, {}};
  if (node.parent != kNoIndex) {
    request.parent = tree_.node(node.parent).handle;
    request.action = tree_.action(node.parent_entry).action;
  }
  return request;
}

void Search::push(Trial trial) {
  in_queue(size_++) = trial;
  if (trial.waits) ++waiting_;
}

Search::Trial Search::pop() {
  const Trial trial = in_queue(0);
  head_ = (head_ + 1) % queue_.size();
  --size_;
  if (sent_ > 0) --sent_;
  if (trial.waits) --waiting_;
  return trial;
}

// Leaves what is in flight, with what those trials have found so far.
void Search::abandon() {
  if (waiting_ == 0) return;
  while (size_ > 0) {
    const Trial trial = pop();
    if (trial.waits) tree_.backup(trial.node);
  }
  evaluator_->release();
}

int Search::best_action(int default_action) const {
  const Node& root = tree_.node(0);
  double best = tree_.default_value(0);
  int action = default_action;
  for (std::uint32_t i = 0; i < root.action_count; ++i) {
    const ActionEntry& entry = tree_.action(root.first_action + i);
    const bool is_better = entry.lower > best;
    if (is_better || (entry.lower == best && entry.action == default_action)) {
      best = entry.lower;
      action = entry.action;
    }
  }
  return action;
}

}  // namespace hypgen
