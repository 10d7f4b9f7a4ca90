#include "hypgen/search.hpp"

#include <algorithm>

namespace hypgen {

namespace {

constexpr std::size_t kThread = 0;

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
    tree_.enter(tree_.root());
    push({&tree_.root(), true});
    Node* node;
    status = expand_oldest(node);
    tree_.backup(tree_.root());
  }
  while (status == Status::kOk) status = advance();
  abandon();
  // What the planner has to act on is told first.
  if (crossed_at_root && !is_failure(status) && status != Status::kDeviceLost)
    status = Status::kCrossedBounds;
  decision.status = status;
  decision.lower = tree_.root().child->lower.load();
  decision.upper = tree_.root().child->upper.load();
  decision.nodes = tree_.nodes();
  decision.crossed = tree_.crossed();
  decision.tree_seconds = seconds_since(start) - decision.waiting_seconds;
}

Status Search::advance() {
  if (tree_.root().child->gap() <= options_.gap) return Status::kConverged;
  const bool has_started_all = decision_->trials >= options_.trial_limit;
  if (has_started_all && size_ == 0) return Status::kTrialLimit;
  return has_started_all || size_ == queue_.size() ? apply_oldest() : start_trial();
}

Status Search::start_trial() {
  if (setup_.deadline != Clock::time_point::max() && Clock::now() >= setup_.deadline)
    return Status::kDeadline;
  ++decision_->trials;
  tree_.enter(tree_.root());
  switch (walk(&tree_.root(), false)) {
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
  push({nullptr, false});
  return Status::kOk;
}

Status Search::apply_oldest() {
  if (!in_queue(0).waits) {
    pop();
    return Status::kOk;
  }
  Node* node;
  const Status status = expand_oldest(node);
  if (status != Status::kOk) {
    tree_.backup(*node);
    return status;
  }
  return walk(node, true) == Progress::kFull ? Status::kMemoryFull : Status::kOk;
}

// Takes the oldest trial, which waits, from the queue and expands its node.
Status Search::expand_oldest(Node*& node) {
  LeafResult leaf{};
  const Status status = wait(leaf);
  node = pop().node;
  if (status != Status::kOk) return status;
  if (leaf.status != Status::kOk) return leaf.status;
  if (leaf.ticket != node->number) return Status::kEvaluatorFailed;
  if (!tree_.expand(kThread, *node, leaf)) return Status::kMemoryFull;
  count_expansion(leaf, node->depth, *decision_, *leaf_sizes_);
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
    if (in_queue(i).waits) requests_.push_back(request(*in_queue(i).node));
  }
  std::size_t taken = requests_.empty() ? 0 : evaluator_->submit(0, requests_);
  while (sent_ < size_ && (!in_queue(sent_).waits || taken > 0)) {
    if (in_queue(sent_).waits) --taken;
    ++sent_;
  }
}

// One trial (Algorithm 2, EXPLORE), from an expanded node down: to a leaf, or to where the excess uncertainty
// is gone. Where everything below a node is in expansion it goes on from the parent.
Search::Progress Search::walk(Node* node, bool has_expanded) {
  const ChildRule rule = tree_.child_rule(options_.target_ratio, options_.observation_loss);
  while (true) {
    const Branch branch = choose(*node, rule);
    if (branch.kind == Branch::kClosed) {
      tree_.leave(*node);
      node = node->parent;
      if (node == nullptr) return Progress::kBackedOut;
      continue;
    }
    if (branch.kind == Branch::kStop) {
      tree_.backup(*node);
      return has_expanded ? Progress::kEnded : Progress::kWithoutEffect;
    }
    Node* const next = branch.kind == Branch::kFull
                           ? nullptr
                           : tree_.visit(kThread, *node, branch.action, *branch.table, *branch.child);
    if (next == nullptr) {
      tree_.backup(*node);
      return Progress::kFull;
    }
    tree_.enter(*next);
    const bool is_deepest = next->depth >= setup_.depth_limit;
    if (is_deepest || (options_.pruning > 0.0 && tree_.is_blocked(*next))) {
      tree_.make_default(*next);
      tree_.backup(*next);
      return Progress::kEnded;
    }
    if (next->expanded() == nullptr) {
      if (!tree_.close(*next)) {
        tree_.leave(*next);  // another thread has it
        continue;
      }
      if (next->expanded() == nullptr) {
        push({next, true});
        return Progress::kRequested;
      }
      tree_.open(*next);
    }
    node = next;
  }
}

// Where to go on from a node; one with nothing left to take is closed.
Search::Branch Search::choose(Node& node, const ChildRule& rule) {
  if (tree_.is_closed(node)) return {Branch::kClosed, kNoIndex, nullptr, nullptr};
  Branch branch = look(node, rule);
  if (branch.kind != Branch::kClosed) return branch;
  tree_.close(node);
  branch = look(node, rule);
  if (branch.kind != Branch::kClosed) tree_.open(node);
  return branch;
}

// The best action's best child; the next action's where that is in expansion.
Search::Branch Search::look(const Node& node, const ChildRule& rule) {
  bool met_closed = false;
  ActionChoice action = tree_.best_action(node);
  while (action.place != kNoIndex) {
    ActionTable* const table = tree_.open_action(kThread, node, action.place);
    if (table == nullptr) return {Branch::kFull, kNoIndex, nullptr, nullptr};
    const ChildChoice choice = tree_.best_child(*table, rule);
    if (choice.child != nullptr) return {Branch::kTaken, action.place, table, choice.child};
    met_closed |= choice.met_closed;
    if (!met_closed) break;
    action = tree_.next_action(node, action);
  }
  return {met_closed ? Branch::kClosed : Branch::kStop, kNoIndex, nullptr, nullptr};
}

LeafRequest Search::request(const Node& node) const {
  LeafRequest request{node.number, kNoHandle, 0, node.child->first, node.child->count, node.depth, {}};
  if (node.parent != nullptr) {
    const Expansion& above = *node.parent->expanded();
    request.parent = above.handle;
    request.action = above.rows[node.action].action;
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
    if (trial.waits) tree_.backup(*trial.node);
  }
  evaluator_->release();
}

int Search::best_action(int default_action) const {
  const Node& root = tree_.root();
  double best = root.child->default_value;
  int action = default_action;
  const Expansion* const expansion = root.expanded();
  for (std::uint32_t i = 0; expansion != nullptr && i < expansion->action_count; ++i) {
    const int candidate = expansion->rows[i].action;
    const double lower = tree_.action_lower(root, i);
    if (lower > best || (lower == best && candidate == default_action)) {
      best = lower;
      action = candidate;
    }
  }
  return action;
}

}  // namespace hypgen
