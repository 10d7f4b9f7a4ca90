// Expands leaves on a GPU, many at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "hypgen/arena.hpp"
#include "hypgen/cuda/sizes.cuh"
#include "hypgen/cuda/slot.cuh"
#include "hypgen/leaf_evaluator.hpp"
#include "hypgen/model.hpp"

namespace hypgen::cuda {

// Keeps, of each expanded leaf, its history and its scenarios' numbers and states in device memory. A batch
// is launched when nothing runs and nothing is ready, or when half of what the search keeps in flight waits,
// or a whole batch.
template <class M>
class CudaEvaluator final : public LeafEvaluator {
 public:
  // Null and `error` if the device, its memory or that of the host does not suffice.
  static std::unique_ptr<CudaEvaluator> make(const typename M::Params& params,
                                             const EvaluatorOptions& options, int device,
                                             std::string& error) {
    try {
      auto made = std::unique_ptr<CudaEvaluator>(new CudaEvaluator(params, options, device));
      if (made->allocate(error)) return made;
    } catch (const std::bad_alloc&) {
      error = "not enough memory of the host for a GPU's leaves";
    }
    return nullptr;
  }

  ~CudaEvaluator() override { cudaSetDevice(device_); }

  void attach(std::size_t thread) override {
    LeafEvaluator::attach(thread);
    cudaSetDevice(device_);  // of the calling thread
  }

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    const RootResult failed{Status::kEvaluatorFailed, {}, -1};
    const std::size_t count = root.size();
    if (count == 0 || count > options_.max_scenarios || setup.depth_limit > options_.max_depth ||
        !root.holds(sizeof(typename M::Fixed), sizeof(typename M::State), sizeof(typename M::History))) {
      return failed;
    }
    for (Slot<M>& slot : slots_) {
      if (!wait(slot, setup.deadline)) return {lost() ? Status::kDeviceLost : Status::kDeadline, {}, -1};
    }
    for (Slot<M>& slot : slots_) {
      note_times(slot);
      slot.reset();
    }
    cudaEventRecord(origin_.get(), slots_[0].stream());
    busy_until_ = 0.0;
    deadline_ = setup.deadline;
    search_ = {setup.key, root.first(), setup.depth_limit, setup.at_horizon, options_.discount};
    upload(root);
    return bound_root(static_cast<std::uint32_t>(count));
  }

  std::size_t submit(std::size_t, Span<const LeafRequest> requests) override {
    std::size_t taken = 0;
    while (taken < requests.size() && queue_size() < queue_.size()) queue_push(requests[taken++]);
    return taken;
  }

  bool poll(std::size_t, LeafResult& result) override {
    if (queue_size() == 0) return false;
    const Entry& entry = in_queue(next_);
    launch_what_waits();
    if (entry.status == Status::kOk && !lost()) {
      if (entry.slot < 0 || !slots_[static_cast<std::size_t>(entry.slot)].finished(error_)) {
        if (!lost()) return false;
      } else {
        deliver(entry, result);
        ++next_;
        return true;
      }
    }
    result = {entry.request.ticket, lost() ? Status::kDeviceLost : entry.status, 0, 0, {}, {}, {}};
    ++next_;
    launched_ = std::max(launched_, next_);  // there was nothing to launch
    return true;
  }

  void release() override {
    next_ = launched_ = end_ = 0;
    nodes_.reset();
    members_used_ = 0;
  }

  EvaluatorStats stats() const override {
    EvaluatorStats stats = stats_;
    stats.steps = *static_cast<volatile unsigned long long*>(out_steps_.get());
    return stats;
  }

  std::string problem() const override { return error_; }

 private:
  static constexpr double kBatchSeconds = 1e-3;
  static constexpr std::size_t kMostDeviceBytes = std::size_t{8} << 30;

  struct NodeRecord {
    std::uint32_t base;
    std::uint32_t count;
  };
  struct Entry {
    LeafRequest request;
    Status status;  // kOk, or why it is not evaluated
    int slot;       // -1: waits
    int leaf;       // in the slot
    std::uint32_t node;
  };

  CudaEvaluator(const typename M::Params& params, const EvaluatorOptions& options, int device)
      : params_(std::make_unique<typename M::Params>(params)),
        options_(options),
        device_(device),
        nodes_(kMostNodes),
        queue_(std::max<std::size_t>(1, options.in_flight)) {
    root_states_.reserve(options.max_scenarios);
  }

  // Memory --------------------------------------------------------------------------------------------

  bool allocate(std::string& error) {
    std::size_t free = 0, total = 0;
    if (!worked(cudaSetDevice(device_), "GPU", error) ||
        !worked(cudaMemGetInfo(&free, &total), "GPU memory", error) ||
        !sizes_.shape(options_, device_, error) || !origin_.make(error)) {
      return false;
    }
    const std::size_t budget = options_.device_memory_bytes > 0 ? options_.device_memory_bytes
                                                                : std::min(free / 2, kMostDeviceBytes);
    if (!sizes_.share_out(budget, options_, error)) return false;
    for (Slot<M>& slot : slots_) {
      if (!slot.make(sizes_.launch, error)) return false;
    }
    row_capacity_ = std::min<std::size_t>(UINT32_MAX / 2, options_.memory_bytes / sizeof(RowLine));
    if (!rows_.allocate(row_capacity_, error)) {
      error += "; --memory lowers the need";
      return false;
    }
    const std::size_t scenarios = options_.max_scenarios;
    return device_params_.allocate(1, error) && fixed_.allocate(scenarios, error) &&
           members_.allocate(sizes_.members * kMemberWords<M>, error) &&
           histories_.allocate(M::kHasHistory ? sizes_.nodes : 1, error) &&
           discounts_.allocate(static_cast<std::size_t>(options_.max_depth) + 1, error) &&
           counters_.allocate(2, error) && out_steps_.allocate(1, error) &&
           staged_fixed_.allocate(scenarios, error) &&
           staged_members_.allocate(scenarios * kMemberWords<M>, error) &&
           staged_history_.allocate(1, error) && fill(error);
  }

  bool fill(std::string& error) {
    std::vector<float> discounts;
    double power = 1.0;
    for (int t = 0; t <= options_.max_depth; ++t, power *= options_.discount) {
      discounts.push_back(static_cast<float>(power));
    }
    *out_steps_.get() = 0;
    return worked(cudaMemcpy(discounts_.get(), discounts.data(), discounts.size() * sizeof(float),
                             cudaMemcpyHostToDevice),
                  "GPU", error) &&
           worked(cudaMemcpy(device_params_.get(), params_.get(), sizeof(typename M::Params),
                             cudaMemcpyHostToDevice),
                  "GPU", error) &&
           worked(cudaMemset(counters_.get(), 0, 2 * sizeof(unsigned long long)), "GPU", error) &&
           // The slots' streams do not wait for the one that these calls use.
           worked(cudaDeviceSynchronize(), "GPU", error);
  }

  // The root ------------------------------------------------------------------------------------------

  void upload(const ScenarioBuffer& root) {
    const std::size_t count = root.size();
    std::vector<typename M::State>& states = root_states_;
    states.resize(count);
    root.copy_to(staged_fixed_.get(), states.data());
    root.copy_history_to(*staged_history_.get());
    for (std::size_t i = 0; i < count; ++i) {
      staged_members_[i] = static_cast<std::uint32_t>(i);
      for (std::size_t w = 0; w < kStateWords<M>; ++w) {
        std::memcpy(&staged_members_[(1 + w) * count + i],
                    reinterpret_cast<const unsigned char*>(&states[i]) + w * sizeof(std::uint32_t),
                    sizeof(std::uint32_t));
      }
    }
    const cudaStream_t stream = slots_[0].stream();
    cudaMemcpyAsync(fixed_.get(), staged_fixed_.get(), count * sizeof(typename M::Fixed),
                    cudaMemcpyHostToDevice, stream);
    cudaMemcpyAsync(members_.get(), staged_members_.get(), count * kMemberWords<M> * sizeof(std::uint32_t),
                    cudaMemcpyHostToDevice, stream);
    if (M::kHasHistory) {
      cudaMemcpyAsync(histories_.get(), staged_history_.get(), sizeof(typename M::History),
                      cudaMemcpyHostToDevice, stream);
    }
    cudaMemsetAsync(counters_.get(), 0, sizeof(std::uint32_t), stream);
    nodes_.allocate(1);
    nodes_[0] = {0, static_cast<std::uint32_t>(count)};
    members_used_ = count;
  }

  RootResult bound_root(std::uint32_t count) {
    PhiloxDraws first(search_.key, 0, 0);
    RootResult result{Status::kOk, {}, -1};
    default_action_ =
        M::default_policy(*params_, staged_fixed_[0], root_states_[0], *staged_history_.get(), first);
    result.default_action = default_action_;
    const int no_step = kNoStep;
    Slot<M>& slot = slots_[0];
    slot.reset();
    slot.add({0, kNoParent, 0, count, 0, 0, 0, kNoStep, 0, -1, 0, 0}, {&no_step, 1});
    if (!launch(slot) || !wait(slot, deadline_)) {
      result.status = lost() ? Status::kDeviceLost : Status::kDeadline;
      return result;
    }
    LeafResult bounds{};
    result.status = show(slot, 0, bounds);
    if (bounds.children.size() == 1) result.row = bounds.children[0];
    return result;
  }

  // Batches -------------------------------------------------------------------------------------------

  std::size_t queue_size() const { return end_ - next_; }
  Entry& in_queue(std::size_t i) { return queue_[i % queue_.size()]; }

  void queue_push(const LeafRequest& request) {
    Entry entry{request, Status::kOk, -1, 0, 0};
    if (!can_exist(request)) {
      entry.status = Status::kEvaluatorFailed;
    } else if (request.parent != kNoHandle) {
      const bool room = nodes_.size() < sizes_.nodes && members_used_ + request.count <= sizes_.members;
      if (room) {
        entry.node = nodes_.allocate(1);
        nodes_[entry.node] = {static_cast<std::uint32_t>(members_used_), request.count};
        members_used_ += request.count;
      } else {
        entry.status = Status::kMemoryFull;
      }
    }
    in_queue(end_++) = entry;
  }

  // Whether there may be such a leaf: kernels take its numbers as they are.
  bool can_exist(const LeafRequest& request) const {
    const bool is_root = request.parent == kNoHandle;
    const std::uint64_t parent = is_root ? 0 : request.parent;
    if (parent >= nodes_.size() || request.count == 0) return false;
    const std::uint32_t most = nodes_[parent].count;
    return is_root ? request.count == most : std::uint64_t{request.first} + request.count <= most;
  }

  // Starts a batch if that is worth its while.
  void launch_what_waits() {
    const std::size_t waiting = end_ - launched_;
    if (waiting == 0 || lost()) return;
    bool device_works = false;
    for (Slot<M>& slot : slots_) device_works |= slot.running() && !slot.finished(error_);
    const bool host_works = launched_ > next_ && !device_works;  // results are there to be taken
    const bool enough = 2 * waiting >= std::min<std::size_t>(queue_.size(), 2 * kMaxLeaves);
    if (!enough && (device_works || host_works)) return;
    for (std::size_t s = 0; s < kSlots; ++s) {
      if (!is_free(s)) continue;
      fill_and_launch(s);
      return;
    }
  }

  // A slot is free when its batch has run and all its rows have been taken.
  bool is_free(std::size_t s) {
    if (slots_[s].running() && !slots_[s].finished(error_)) return false;
    for (std::size_t i = next_; i < launched_; ++i) {
      if (in_queue(i).slot == static_cast<int>(s)) return false;
    }
    return true;
  }

  void fill_and_launch(std::size_t s) {
    Slot<M>& slot = slots_[s];
    note_times(slot);
    slot.reset();
    while (launched_ < end_) {
      Entry& entry = in_queue(launched_);
      if (entry.status == Status::kOk) {
        const LeafRequest& request = entry.request;
        const bool is_root = request.parent == kNoHandle;
        const std::size_t count = is_root ? nodes_[0].count : request.count;
        const std::size_t actions = request.actions.empty() ? M::kActionCount : request.actions.size();
        if (!slot.fits(count, actions + (is_root ? 1 : 0), !request.actions.empty(), item_limit_)) break;
        entry.slot = static_cast<int>(s);
        entry.leaf = slot.leaves();
        slot.add(task_of(entry), request.actions);
      }
      ++launched_;
    }
    if (!slot.empty()) launch(slot);
  }

  // Takes in how long the slot's last batch took: the next ones should take kBatchSeconds, so that a search
  // that has to stop does not leave much behind.
  void note_times(Slot<M>& slot) {
    double started = 0.0, ended = 0.0;
    if (slot.empty() || !slot.times(origin_.get(), started, ended) || !(ended > started)) return;
    stats_.kernel_seconds += ended - started;
    stats_.busy_seconds += std::max(0.0, ended - std::max(started, busy_until_));
    busy_until_ = std::max(busy_until_, ended);
    const double rate = static_cast<double>(slot.items()) / (ended - started);
    item_rate_ = item_rate_ > 0.0 ? 0.75 * item_rate_ + 0.25 * rate : rate;
    // Fewer items than the device runs at once would not be faster.
    const std::size_t resident = static_cast<std::size_t>(sizes_.launch.simulate_blocks) * kSimulateBlock;
    item_limit_ = std::max(resident, static_cast<std::size_t>(item_rate_ * kBatchSeconds));
  }

  LeafTask task_of(const Entry& entry) const {
    const LeafRequest& request = entry.request;
    const NodeRecord& own = nodes_[entry.node];
    LeafTask task{entry.node, kNoParent,      own.base,      own.count, 0, 0,
                  0,          request.action, request.depth, -1,        0, 0};
    if (request.parent == kNoHandle) {
      task.baseline = default_action_;
    } else {
      const NodeRecord& parent = nodes_[request.parent];
      task.parent = static_cast<std::uint32_t>(request.parent);
      task.parent_base = parent.base;
      task.parent_count = parent.count;
      task.first = request.first;
    }
    return task;
  }

  bool launch(Slot<M>& slot) {
    Batch<M> batch{};
    batch.search = search_;
    batch.params = device_params_.get();
    batch.discounts = discounts_.get();
    batch.fixed = fixed_.get();
    batch.members = members_.get();
    batch.histories = histories_.get();
    batch.arena_used = reinterpret_cast<std::uint32_t*>(counters_.get());
    batch.arena_size = static_cast<std::uint32_t>(row_capacity_);
    batch.steps = counters_.get() + 1;
    batch.out_steps = out_steps_.get();
    batch.arena = rows_.get();
    ++stats_.batches;
    stats_.leaves += static_cast<std::uint64_t>(slot.leaves());
    return slot.launch(batch, error_);
  }

  void deliver(const Entry& entry, LeafResult& result) {
    result = {entry.request.ticket, Status::kOk, entry.node, nodes_[entry.node].count, {}, {}, {}};
    result.status = show(slots_[static_cast<std::size_t>(entry.slot)], entry.leaf, result);
    stats_.bytes_read += result.actions.size() * sizeof(ActionRow) +
                         result.children.size() * sizeof(ChildRow) + sizeof(LeafOutcome);
  }

  // Points `result` to a finished leaf's rows, if it has any.
  Status show(const Slot<M>& slot, int leaf, LeafResult& result) const {
    const LeafOutcome& outcome = slot.outcome(leaf);
    const Status status = status_of(outcome);
    if (status != Status::kOk) return status;
    const bool has_gains = slot.task(leaf).baseline >= 0;
    const RowLayout layout(outcome.action_count, has_gains, outcome.child_count);
    const RowLine* const run = rows_.get() + outcome.first_line;
    result.actions = {reinterpret_cast<const ActionRow*>(run), outcome.action_count};
    result.children = {reinterpret_cast<const ChildRow*>(run + layout.children), outcome.child_count};
    if (has_gains) {
      result.gains = {reinterpret_cast<const Gain*>(run + layout.gains), outcome.action_count};
    }
    return status;
  }

  static Status status_of(const LeafOutcome& outcome) {
    if (outcome.flags & kMembersFlag) return Status::kEvaluatorFailed;
    if (outcome.flags & kFullFlag) return Status::kMemoryFull;
    return outcome.flags & kNanFlag ? Status::kModelNan : Status::kOk;
  }

  // Waits for a slot's batch; false if the deadline or the device prevents it.
  bool wait(Slot<M>& slot, Clock::time_point deadline) {
    while (!slot.finished(error_)) {
      if (lost() || (deadline != Clock::time_point::max() && Clock::now() >= deadline)) return false;
    }
    return !lost();
  }

  bool lost() const { return !error_.empty(); }

  std::unique_ptr<typename M::Params> params_;
  EvaluatorOptions options_;
  int device_;
  DeviceSizes<M> sizes_;
  SearchConstants search_{};
  Clock::time_point deadline_{};
  int default_action_ = -1;
  Event origin_;             // of the times of a search's batches
  double busy_until_ = 0.0;  // after that
  double item_rate_ = 0.0;   // a second, of batches lately
  std::size_t item_limit_ = std::size_t{1} << 18;
  std::string error_;  // not empty: the device is lost
  EvaluatorStats stats_{};

  Arena<NodeRecord> nodes_;
  std::size_t members_used_ = 0;
  std::size_t row_capacity_ = 0;  // in lines

  // Entries next_ .. launched_ are being evaluated, launched_ .. end_ wait.
  std::vector<Entry> queue_;
  std::size_t next_ = 0, launched_ = 0, end_ = 0;

  DeviceArray<typename M::Params> device_params_;
  DeviceArray<typename M::Fixed> fixed_;
  DeviceArray<std::uint32_t> members_;
  DeviceArray<typename M::History> histories_;
  DeviceArray<float> discounts_;
  DeviceArray<unsigned long long> counters_;  // lines of rows taken, steps simulated
  PinnedArray<RowLine> rows_;                 // of all leaves of the search
  PinnedArray<unsigned long long> out_steps_;
  PinnedArray<typename M::Fixed> staged_fixed_;
  PinnedArray<std::uint32_t> staged_members_;
  PinnedArray<typename M::History> staged_history_;
  std::vector<typename M::State> root_states_;
  Slot<M> slots_[kSlots];  // last: they wait for their batches before memory goes
};

}  // namespace hypgen::cuda
