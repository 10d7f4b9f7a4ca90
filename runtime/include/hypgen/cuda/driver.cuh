// SPDX-License-Identifier: Apache-2.0
// Fills batches with the leaves of all threads, launches them and hands out what they gave.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "hypgen/cuda/sizes.cuh"
#include "hypgen/cuda/slot.cuh"
#include "hypgen/leaves/horizon_floors.hpp"
#include "hypgen/leaves/leaf_ring.hpp"
#include "hypgen/memory/arena.hpp"
#include "hypgen/model/model.hpp"

namespace hypgen::cuda {

// What the driver of the rings does. Its fields are plain: only that one thread touches them, and the role
// passes them on. Nobody else calls CUDA in a search.
template <class M>
class BatchDriver {
 public:
  BatchDriver(LeafRings& rings, std::size_t in_flight, double patience)
      : rings_(rings), in_flight_(in_flight), patience_(patience) {}

  bool make(const DeviceSizes<M>& sizes, std::string& error) {
    sizes_ = sizes;
    for (Flight& flight : flights_) {
      flight.places.reserve(kMaxLeaves);
      if (!flight.slot.make(sizes.launch, error)) return false;
    }
    return origin_.make(error);
  }

  // Between searches -----------------------------------------------------------------------------------

  // Forgets all leaves. Batches may still run: their results are nobody's.
  void release() {
    for (Flight& flight : flights_) flight.places.clear();
    nodes_.reset();
    members_used_ = 0;
  }

  // Waits for batches of the previous search; false if the deadline or the device prevents it.
  bool settle(const Deadline& deadline) {
    for (Flight& flight : flights_) {
      if (!wait(flight.slot, deadline)) return false;
    }
    for (Flight& flight : flights_) {
      note_times(flight.slot);
      flight.slot.reset();
    }
    cudaEventRecord(origin_.get(), stream());
    busy_until_ = 0.0;
    held_back_since_ = {};
    return true;
  }

  // Whether a batch does not end.
  bool is_stuck() {
    for (Flight& flight : flights_) wait(flight.slot, Deadline());
    return is_stuck_;
  }

  // `common` is what all batches of the search share; `baseline` the default action at the root.
  void begin_search(const Batch<M>& common, std::uint32_t root_count, int baseline) {
    common_ = common;
    baseline_ = baseline;
    nodes_.allocate(1);
    nodes_[0] = {0, root_count};
    members_used_ = root_count;
  }

  // Bounds of the root's members as they are, as its only child.
  Status bound_root(const Deadline& deadline, LeafResult& result) {
    Slot<M>& slot = flights_[0].slot;
    const int no_step = kNoStep;
    LeafTask root{};
    root.parent = kNoParent;
    root.count = nodes_[0].count;
    root.action = kNoStep;
    root.baseline = -1;
    root.rolled = kRollsAll;
    slot.add(root, {&no_step, 1});
    Batch<M> batch = common_;
    batch.search.weighted = false;  // there is no observation yet
    if (!launch(slot, batch) || !wait(slot, deadline))
      return is_lost() ? Status::kDeviceLost : Status::kDeadline;
    result = result_of(slot, 0, 0);
    return result.status;
  }

  cudaStream_t stream() const { return flights_[0].slot.stream(); }
  bool is_lost() const { return !error_.empty(); }
  const std::string& problem() const { return error_; }  // not empty: the device is lost
  const EvaluatorStats& stats() const { return stats_; }

  // In a search ----------------------------------------------------------------------------------------

  // One turn. Waits for no batch; before a slot is used again, for the microseconds that its last batch takes
  // to end after its last write.
  void drive() {
    hand_out();
    if (!is_lost()) launch_what_waits();
    if (is_lost()) give_up();
  }

 private:
  static constexpr double kBatchSeconds = 1e-3;
  static constexpr double kForgets = 1.01;  // a batch, what the fastest one took
  static constexpr std::chrono::microseconds kPatience{50};

  struct NodeRecord {
    std::uint32_t base;
    std::uint32_t count;
  };
  // A batch, and whose leaves it has.
  struct Flight {
    Slot<M> slot;
    std::vector<LeafRings::Place> places;
  };

  void hand_out() {
    for (Flight& flight : flights_) {
      if (!flight.slot.running() || !flight.slot.finished(error_)) continue;
      for (std::size_t leaf = 0; leaf < flight.places.size(); ++leaf) {
        const LeafRings::Place place = flight.places[leaf];
        const LeafResult result =
            result_of(flight.slot, static_cast<int>(leaf), rings_.request(place).ticket);
        stats_.bytes_read += result.actions.size() * sizeof(ActionRow) +
                             result.children.size() * sizeof(ChildRow) + sizeof(LeafOutcome);
        rings_.answer(place, result);
      }
      flight.places.clear();
    }
  }

  // Starts a batch if that is worth its while: half of what the search keeps in flight waits, or a whole
  // batch; or the device is idle, and no thread is about to read a result, after which it would send more.
  void launch_what_waits() {
    const std::size_t waiting = rings_.waiting();
    Flight* free = nullptr;
    bool device_works = false;
    for (Flight& flight : flights_) {
      device_works |= flight.slot.running();
      if (!flight.slot.running() && free == nullptr) free = &flight;
    }
    if (waiting == 0 || device_works) held_back_since_ = {};
    const bool enough = 2 * waiting >= std::min<std::size_t>(in_flight_, 2 * kMaxLeaves);
    if (waiting == 0 || free == nullptr || (!enough && (device_works || is_held_back()))) return;
    held_back_since_ = {};
    fill_and_launch(*free);
  }

  // Whether leaves wait for threads to read what they have, for a while.
  bool is_held_back() {
    if (!rings_.has_unread()) return false;
    const Clock::time_point now = Clock::now();
    if (held_back_since_ == Clock::time_point{}) held_back_since_ = now;
    return now - held_back_since_ < kPatience;
  }

  void fill_and_launch(Flight& flight) {
    Slot<M>& slot = flight.slot;
    note_times(slot);
    slot.reset();
    rings_.take_in_turn([&](const LeafRings::Place& place, const LeafRequest& request) {
      if (!can_exist(request)) {
        rings_.answer(place, without_rows(request, Status::kEvaluatorFailed));
        return true;
      }
      if (!fits(slot, request)) return false;
      LeafTask task{};
      if (!make_task(request, task)) {
        rings_.answer(place, without_rows(request, Status::kMemoryFull));
        return true;
      }
      slot.add(task, request.actions);
      flight.places.push_back(place);
      return true;
    });
    if (!slot.empty()) launch(slot, common_);
  }

  // The device is lost: so is every leaf.
  void give_up() {
    for (Flight& flight : flights_) {
      for (const LeafRings::Place& place : flight.places) {
        rings_.answer(place, without_rows(rings_.request(place), Status::kDeviceLost));
      }
      flight.places.clear();
    }
    rings_.take_in_turn([&](const LeafRings::Place& place, const LeafRequest& request) {
      rings_.answer(place, without_rows(request, Status::kDeviceLost));
      return true;
    });
  }

  static LeafResult without_rows(const LeafRequest& request, Status status) {
    LeafResult result;
    result.ticket = request.ticket;
    result.status = status;
    return result;
  }

  // Whether there may be such a leaf: kernels take its numbers as they are.
  bool can_exist(const LeafRequest& request) const {
    const bool is_root = request.parent == kNoHandle;
    const std::uint64_t parent = is_root ? 0 : request.parent;
    if (parent >= nodes_.size()) return false;
    const std::uint32_t most = nodes_[parent].count;
    if (common_.search.weighted) return is_root || request.first < most;  // a group may have next to no mass
    if (request.count == 0) return false;
    return is_root ? request.count == most : std::uint64_t{request.first} + request.count <= most;
  }

  bool fits(const Slot<M>& slot, const LeafRequest& request) const {
    const std::size_t actions = request.actions.empty() ? M::kActionCount : request.actions.size();
    const std::size_t baseline = has_gains(request) ? 1 : 0;
    const std::size_t parents = request.parent == kNoHandle ? 0 : nodes_[request.parent].count;
    return slot.fits(members_of(request), parents, actions + baseline, !request.actions.empty(), item_limit_);
  }

  bool has_gains(const LeafRequest& request) const {
    return request.parent == kNoHandle && request.rolled == kRollsAll && !common_.search.weighted;
  }

  // How many members a leaf has.
  std::uint32_t members_of(const LeafRequest& request) const {
    if (!common_.search.weighted) return request.count;
    if (request.parent == kNoHandle) return nodes_[0].count;
    return members_for(request.count, nodes_[request.parent].count,
                       static_cast<std::uint32_t>(sizes_.launch.table_capacity));
  }

  // Makes the leaf's node, the root's being there already; false if there is no room.
  bool make_task(const LeafRequest& request, LeafTask& task) {
    task.count = members_of(request);
    task.mass = request.count;
    task.action = request.action;
    task.depth = request.depth;
    task.parent = kNoParent;
    task.baseline = has_gains(request) ? baseline_ : -1;
    const bool has_floor = !common_.search.at_horizon || kHasLeastReward<M>;
    task.rolled = has_floor ? request.rolled : kRollsAll;
    task.lower_sum = request.lower_sum;
    if (request.parent == kNoHandle) return true;
    if (nodes_.size() >= sizes_.nodes || members_used_ + task.count > sizes_.members) return false;
    const NodeRecord parent = nodes_[request.parent];
    task.parent = static_cast<std::uint32_t>(request.parent);
    task.parent_base = parent.base;
    task.parent_count = parent.count;
    task.first = request.first;
    task.baseline = -1;
    task.base = static_cast<std::uint32_t>(members_used_);
    task.node = nodes_.allocate(1);
    nodes_[task.node] = {task.base, task.count};
    members_used_ += task.count;
    return true;
  }

  // Takes in how long the slot's last batch took.
  void note_times(Slot<M>& slot) {
    double started = 0.0, ended = 0.0;
    if (slot.empty() || !slot.times(origin_.get(), started, ended) || !(ended > started)) return;
    stats_.kernel_seconds += ended - started;
    stats_.busy_seconds += std::max(0.0, ended - std::max(started, busy_until_));
    busy_until_ = std::max(busy_until_, ended);
    fit_limit(slot.items(), ended - started);
  }

  // Lets batches grow while they take less time than they may: a search that has to stop should not leave much
  // behind. The fastest batch tells what a rollout takes from end to end, which no batch can do without.
  void fit_limit(std::size_t items, double seconds) {
    fastest_ = std::min(kForgets * fastest_, seconds);
    const double wanted = std::max(kBatchSeconds, 2.0 * fastest_);
    if (seconds > 2.0 * wanted) item_limit_ /= 2;
    if (seconds < wanted && 2 * items > item_limit_) item_limit_ += item_limit_ / 2;
    // Fewer items than the device runs at once would not be faster.
    const std::size_t resident = static_cast<std::size_t>(sizes_.launch.simulate_blocks) * kSimulateBlock;
    item_limit_ =
        std::clamp(item_limit_, std::min(resident, sizes_.launch.item_capacity), sizes_.launch.item_capacity);
  }

  bool launch(Slot<M>& slot, const Batch<M>& batch) {
    ++stats_.batches;
    stats_.leaves += static_cast<std::uint64_t>(slot.leaves());
    return slot.launch(batch, error_);
  }

  // Of a leaf whose batch has run. Its rows stay where they are.
  LeafResult result_of(const Slot<M>& slot, int leaf, std::uint32_t ticket) const {
    const LeafOutcome& outcome = slot.outcome(leaf);
    const LeafTask& task = slot.task(leaf);
    LeafResult result;
    result.ticket = ticket;
    result.status = status_of(outcome);
    result.handle = task.node;
    result.count = task.count;
    if (result.status != Status::kOk) return result;
    const bool with_gains = task.baseline >= 0;
    const RowLayout layout(outcome.action_count, with_gains, outcome.child_count);
    const RowLine* const run = common_.arena + outcome.first_line;
    result.actions = {reinterpret_cast<const ActionRow*>(run), outcome.action_count};
    result.children = {reinterpret_cast<const ChildRow*>(run + layout.children), outcome.child_count};
    if (with_gains) {
      result.gains = {reinterpret_cast<const Gain*>(run + layout.gains), outcome.action_count};
    }
    return result;
  }

  static Status status_of(const LeafOutcome& outcome) {
    if (outcome.flags & kMembersFlag) return Status::kEvaluatorFailed;
    if (outcome.flags & kFullFlag) return Status::kMemoryFull;
    return outcome.flags & kNanFlag ? Status::kModelNan : Status::kOk;
  }

  // Waits for a slot's batch; false if the deadline or the device prevents it. A device that is silent for
  // long is lost, whatever the deadline: later searches would wait for it too.
  bool wait(Slot<M>& slot, const Deadline& deadline) {
    while (!slot.finished(error_)) {
      const Clock::time_point now = Clock::now();
      if (!is_lost() && std::chrono::duration<double>(now - slot.launched()).count() > patience_) {
        is_stuck_ = true;
        error_ = "GPU: a batch has not ended for " + std::to_string(static_cast<int>(patience_)) + " s";
      }
      if (is_lost() || deadline.has_passed(now)) return false;
    }
    return !is_lost();
  }

  LeafRings& rings_;
  std::size_t in_flight_;
  double patience_;  // in seconds
  bool is_stuck_ = false;
  DeviceSizes<M> sizes_;
  Batch<M> common_{};
  int baseline_ = -1;
  Arena<NodeRecord> nodes_{kMostNodes};
  std::size_t members_used_ = 0;
  Event origin_;                                              // of the times of a search's batches
  double busy_until_ = 0.0;                                   // after that
  double fastest_ = std::numeric_limits<double>::infinity();  // seconds, of batches lately
  std::size_t item_limit_ = std::size_t{1} << 18;             // of a batch of several leaves
  Clock::time_point held_back_since_{};
  std::string error_;
  EvaluatorStats stats_{};
  Flight flights_[kSlots];
};

}  // namespace hypgen::cuda
