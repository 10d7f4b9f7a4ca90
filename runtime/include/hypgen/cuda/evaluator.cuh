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

  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    release();
    cudaSetDevice(device_);  // of this thread
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

  std::size_t submit(Span<const LeafRequest> requests) override {
    std::size_t taken = 0;
    while (taken < requests.size() && queue_size() < queue_.size()) queue_push(requests[taken++]);
    return taken;
  }

  bool poll(LeafResult& result) override {
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
  static constexpr std::size_t kSlots = 3;
  static constexpr std::size_t kItems = std::size_t{4} << 20;  // of a batch, where memory allows
  static constexpr std::size_t kSharedTable = 100 << 10;       // bytes: two blocks fit a multiprocessor
  static constexpr double kBatchSeconds = 1e-3;
  static constexpr std::size_t kMostNodes = std::size_t{1} << 22;
  static constexpr std::size_t kMostDeviceBytes = std::size_t{8} << 30;
  static constexpr std::size_t kLeastNodeBytes = std::size_t{64} << 20;

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
        !worked(cudaMemGetInfo(&free, &total), "GPU memory", error) || !shape(error) ||
        !origin_.make(error)) {
      return false;
    }
    const std::size_t budget = options_.device_memory_bytes > 0 ? options_.device_memory_bytes
                                                                : std::min(free / 2, kMostDeviceBytes);
    if (!share_out(budget, error)) return false;
    for (Slot<M>& slot : slots_) {
      if (!slot.make(launch_, error)) return false;
    }
    child_capacity_ = std::min<std::size_t>(UINT32_MAX / 2, options_.memory_bytes / sizeof(ChildRow));
    if (!children_.allocate(child_capacity_, error)) {
      error += "; --memory lowers the need";
      return false;
    }
    const std::size_t scenarios = options_.max_scenarios;
    return device_params_.allocate(1, error) && fixed_.allocate(scenarios, error) &&
           members_.allocate(member_capacity_ * kMemberWords<M>, error) &&
           histories_.allocate(M::kHasHistory ? node_capacity_ : 1, error) &&
           discounts_.allocate(static_cast<std::size_t>(options_.max_depth) + 1, error) &&
           counters_.allocate(2, error) && out_steps_.allocate(1, error) &&
           staged_fixed_.allocate(scenarios, error) &&
           staged_members_.allocate(scenarios * kMemberWords<M>, error) &&
           staged_history_.allocate(1, error) && fill(error);
  }

  // Divides the budget: what the slots take whatever the number of items; the items; the histories; and the
  // members with all that is left.
  bool share_out(std::size_t budget, std::string& error) {
    const std::size_t scenarios = options_.max_scenarios;
    const std::size_t member = kMemberWords<M> * sizeof(std::uint32_t);
    const std::size_t item = kSlots * Slot<M>::kBytesAnItem;
    if (launch_.table_bytes == 0) {
      const std::size_t tables = budget / 4 / kSlots / launch_.table_stride();
      launch_.reduce_blocks = static_cast<int>(
          std::clamp<std::size_t>(tables, 1, static_cast<std::size_t>(launch_.reduce_blocks)));
    }
    const std::size_t apart =
        kSlots * Slot<M>::bytes_but_items(launch_) + scenarios * sizeof(typename M::Fixed);
    const std::size_t largest_leaf = scenarios * Slot<M>::kMaxActions;
    const std::size_t needed = apart + largest_leaf * item + kLeastNodeBytes + 4 * scenarios * member;
    if (needed > budget) {
      error = "a leaf of " + std::to_string(scenarios) + " scenarios needs " + std::to_string(needed >> 20) +
              " MB of GPU memory, which has " + std::to_string(budget >> 20) +
              " MB for this solver: lower --scenarios or raise --device-memory";
      return false;
    }
    launch_.item_capacity = std::max(largest_leaf, std::min(kItems, (budget - apart) / 2 / item));
    const std::size_t rest = budget - apart - launch_.item_capacity * item;
    const std::size_t history = M::kHasHistory ? sizeof(typename M::History) : 0;
    node_capacity_ = M::kHasHistory ? std::min(kMostNodes, rest / 4 / history) : kMostNodes;
    member_capacity_ = std::min<std::size_t>(UINT32_MAX - 1, (rest - node_capacity_ * history) / member);
    return true;
  }

  // Attributes belong to a kernel and a device: they must be the same for all evaluators of the model.
  bool shape(std::string& error) {
    cudaDeviceProp properties;
    if (!worked(cudaGetDeviceProperties(&properties, device_), "GPU", error)) return false;
    launch_.table_capacity = static_cast<std::uint32_t>(options_.max_scenarios);
    const std::size_t table = launch_.table_stride();
    const std::size_t most = std::min<std::size_t>(kSharedTable, properties.sharedMemPerBlockOptin / 2);
    launch_.table_bytes = table <= most ? table : 0;
    int simulating = 0, reducing = 0;
    if (!worked(cudaFuncSetAttribute(reduce<M>, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                     static_cast<int>(most)),
                "shared memory", error) ||
        !worked(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&simulating, simulate<M>, kSimulateBlock, 0),
                "GPU", error) ||
        !worked(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&reducing, reduce<M>, kReduceBlock,
                                                              launch_.table_bytes),
                "GPU", error)) {
      return false;
    }
    launch_.warps = options_.warps;
    launch_.multiprocessors = properties.multiProcessorCount;
    launch_.together_bytes = sizeof(SharedSteps<M>);
    if constexpr (M::kMaxWarps > 1) {
      // A state that is too large for shared memory is stepped by single lanes.
      if (launch_.together_bytes + sizeof(LeafOffsets) + 1024 <= properties.sharedMemPerBlockOptin) {
        launch_.most_warps = std::min<int>(M::kMaxWarps, kMostWarps);
        if (!worked(cudaFuncSetAttribute(simulate_together<M>, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                         static_cast<int>(launch_.together_bytes)),
                    "shared memory", error)) {
          return false;
        }
      }
    }
    launch_.simulate_blocks = std::max(1, simulating) * properties.multiProcessorCount;
    launch_.reduce_blocks = std::max(1, reducing) * properties.multiProcessorCount;
    return true;
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
    const LeafOutcome& outcome = slot.outcome(0);
    result.status = status_of(outcome);
    if (outcome.child_count == 1) result.row = children_[outcome.first_child];
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
      const bool room = nodes_.size() < node_capacity_ && members_used_ + request.count <= member_capacity_;
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
    const std::size_t resident = static_cast<std::size_t>(launch_.simulate_blocks) * kSimulateBlock;
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
    batch.arena_size = static_cast<std::uint32_t>(child_capacity_);
    batch.steps = counters_.get() + 1;
    batch.out_steps = out_steps_.get();
    batch.out_children = children_.get();
    ++stats_.batches;
    stats_.leaves += static_cast<std::uint64_t>(slot.leaves());
    return slot.launch(batch, error_);
  }

  void deliver(const Entry& entry, LeafResult& result) {
    const Slot<M>& slot = slots_[static_cast<std::size_t>(entry.slot)];
    const LeafOutcome& outcome = slot.outcome(entry.leaf);
    const bool is_root = entry.request.parent == kNoHandle;
    result = {entry.request.ticket, status_of(outcome), entry.node, nodes_[entry.node].count, {}, {}, {}};
    if (result.status != Status::kOk) return;
    result.actions = {slot.actions(entry.leaf), outcome.action_count};
    result.children = {children_.get() + outcome.first_child, outcome.child_count};
    if (is_root) result.gains = {slot.gains(), outcome.action_count};
    stats_.bytes_read += outcome.action_count * sizeof(ActionRow) + outcome.child_count * sizeof(ChildRow) +
                         sizeof(LeafOutcome);
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
  LaunchShape launch_;
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
  std::size_t node_capacity_ = 0;
  std::size_t member_capacity_ = 0;
  std::size_t members_used_ = 0;
  std::size_t child_capacity_ = 0;

  // Entries next_ .. launched_ are being evaluated, launched_ .. end_ wait.
  std::vector<Entry> queue_;
  std::size_t next_ = 0, launched_ = 0, end_ = 0;

  DeviceArray<typename M::Params> device_params_;
  DeviceArray<typename M::Fixed> fixed_;
  DeviceArray<std::uint32_t> members_;
  DeviceArray<typename M::History> histories_;
  DeviceArray<float> discounts_;
  DeviceArray<unsigned long long> counters_;  // child rows taken, steps simulated
  PinnedArray<ChildRow> children_;
  PinnedArray<unsigned long long> out_steps_;
  PinnedArray<typename M::Fixed> staged_fixed_;
  PinnedArray<std::uint32_t> staged_members_;
  PinnedArray<typename M::History> staged_history_;
  std::vector<typename M::State> root_states_;
  Slot<M> slots_[kSlots];  // last: they wait for their batches before memory goes
};

}  // namespace hypgen::cuda
