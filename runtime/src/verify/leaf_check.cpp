// SPDX-License-Identifier: Apache-2.0
#include "hypgen/verify/leaf_check.hpp"

#include <algorithm>
#include <cstring>
#include <thread>
#include <vector>

#include "hypgen/core/status.hpp"
#include "hypgen/leaves/rolled_actions.hpp"

namespace hypgen {

namespace {

constexpr std::size_t kMostBranches = 100000;

// A group that can be expanded, by its parent's handle at either evaluator.
struct Branch {
  std::uint64_t reference = kNoHandle;
  std::uint64_t other = kNoHandle;
  int action = 0;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  int depth = 0;
  std::int64_t lower_sum = INT64_MIN;
};

bool same_bytes(const void* a, const void* b, std::size_t size) {
  return size == 0 || std::memcmp(a, b, size) == 0;
}

std::string describe(const LeafRequest& request) {
  return "leaf after action " + std::to_string(request.action) + ", " + std::to_string(request.count) +
         " scenarios, depth " + std::to_string(request.depth) + ": ";
}

// What differs between two results, or nothing.
std::string difference(const LeafResult& a, const LeafResult& b) {
  if (a.status != b.status) return std::string(status_name(a.status)) + " and " + status_name(b.status);
  if (a.count != b.count) return "other numbers of scenarios";
  if (a.actions.size() != b.actions.size()) return "other numbers of actions";
  for (std::size_t i = 0; i < a.actions.size(); ++i) {
    if (!same_bytes(&a.actions[i], &b.actions[i], sizeof(ActionRow))) {
      return "rows of action " + std::to_string(a.actions[i].action);
    }
  }
  if (a.children.size() != b.children.size() ||
      !same_bytes(a.children.begin(), b.children.begin(), a.children.size() * sizeof(ChildRow))) {
    return "rows of children";
  }
  if (a.gains.size() != b.gains.size() ||
      !same_bytes(a.gains.begin(), b.gains.begin(), a.gains.size() * sizeof(Gain))) {
    return "gains at the root";
  }
  return {};
}

LeafResult wait(LeafEvaluator& evaluator, std::size_t thread) {
  LeafResult result;
  while (!evaluator.poll(thread, result)) std::this_thread::yield();
  return result;
}

// Grows the tree of one comparison.
class Growth {
 public:
  Growth(LeafEvaluator& reference, LeafEvaluator& other, int depth_limit, std::uint64_t seed)
      : reference_(reference),
        other_(other),
        depth_limit_(depth_limit),
        draws_(derive(seed, StreamKind::kTest, 2), 0, 0) {}

  LeafComparison grow(std::uint32_t root_count, std::size_t leaves) {
    batch_.emplace_back().count = root_count;
    while (!batch_.empty() && evaluate()) {
      batch_.clear();
      const std::size_t left = leaves - std::min<std::size_t>(leaves, found_.leaves);
      const std::size_t size = std::min<std::size_t>({left, branches_.size(), 1 + below(kMostInFlight)});
      for (std::size_t i = 0; i < size; ++i) {
        std::swap(branches_[below(branches_.size())], branches_.back());
        batch_.push_back(branches_.back());
        branches_.pop_back();
      }
    }
    return found_;
  }

 private:
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>((std::uint64_t{draws_.word(0, next_word_++)} * count) >> 32);
  }

  static LeafRequest request(const Branch& branch, std::uint64_t parent) {
    LeafRequest request;
    request.parent = parent;
    request.action = branch.action;
    request.first = branch.first;
    request.count = branch.count;
    request.depth = branch.depth;
    // All ways of rolling out: every action, one, and some, of which known bounds leave out more.
    constexpr std::uint32_t kRolled[] = {kRollsAll, 1, 3};
    if (branch.depth > 0) {
      request.rolled = kRolled[(branch.first + static_cast<std::uint32_t>(branch.action)) % 3];
      if (request.rolled == 3) request.lower_sum = branch.lower_sum;
    }
    return request;
  }

  // Whose leaf it is at the other evaluator.
  std::size_t thread_of(std::size_t i) const { return i % other_.threads(); }

  // Evaluates the batch on both sides; false if something differs or memory is full.
  bool evaluate() {
    for (std::size_t i = 0; i < batch_.size(); ++i) {
      const LeafRequest one = request(batch_[i], batch_[i].reference),
                        two = request(batch_[i], batch_[i].other);
      if (reference_.submit(0, {&one, 1}) != 1 || other_.submit(thread_of(i), {&two, 1}) != 1) {
        found_.difference = "an evaluator takes no more leaves";
        return false;
      }
    }
    for (std::size_t i = 0; i < batch_.size(); ++i) {
      const Branch& branch = batch_[i];
      const LeafResult expected = wait(reference_, 0), result = wait(other_, thread_of(i));
      // How much memory each has is its own affair.
      if (expected.status == Status::kMemoryFull || result.status == Status::kMemoryFull) return false;
      const std::string differs = difference(expected, result);
      if (!differs.empty()) {
        found_.difference = describe(request(branch, branch.reference)) + differs;
        return false;
      }
      ++found_.leaves;
      found_.rows += expected.actions.size() + expected.children.size();
      if (expected.status != Status::kOk) return false;
      note_children(branch, expected, result);
    }
    return true;
  }

  void note_children(const Branch& parent, const LeafResult& expected, const LeafResult& result) {
    if (parent.depth + 1 >= depth_limit_) return;
    for (const ActionRow& row : expected.actions) {
      for (std::uint32_t i = 0; i < row.child_count && branches_.size() < kMostBranches; ++i) {
        const ChildRow& child = expected.children[row.first_child + i];
        if (child.terminal) continue;
        Branch& branch = branches_.emplace_back();
        branch.reference = expected.handle;
        branch.other = result.handle;
        branch.action = row.action;
        branch.first = child.first;
        branch.count = child.count;
        branch.depth = parent.depth + 1;
        branch.lower_sum = child.lower_sum;
      }
    }
  }

  LeafEvaluator& reference_;
  LeafEvaluator& other_;
  int depth_limit_;
  PhiloxDraws draws_;
  std::uint32_t next_word_ = 0;
  std::vector<Branch> branches_, batch_;
  LeafComparison found_;
};

}  // namespace

LeafComparison compare_leaves(LeafEvaluator& reference, LeafEvaluator& other, const ScenarioBuffer& root,
                              const SearchSetup& setup, std::size_t leaves, std::uint64_t seed) {
  reference.attach(0);
  for (std::size_t thread = 0; thread < other.threads(); ++thread) other.attach(thread);
  const RootResult expected = reference.begin_search(root, setup), result = other.begin_search(root, setup);
  LeafComparison failed;
  if (expected.status != result.status) {
    failed.difference =
        std::string("root: ") + status_name(expected.status) + " and " + status_name(result.status);
  } else if (expected.status == Status::kOk && (!same_bytes(&expected.row, &result.row, sizeof(ChildRow)) ||
                                                expected.default_action != result.default_action)) {
    failed.difference = "bounds of the root";
  }
  if (!failed.difference.empty() || expected.status != Status::kOk) return failed;
  return Growth(reference, other, setup.depth_limit, seed).grow(expected.row.count, leaves);
}

}  // namespace hypgen
