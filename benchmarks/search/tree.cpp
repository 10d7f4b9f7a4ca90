// SPDX-License-Identifier: Apache-2.0
// How fast the search tree grows where leaves cost nothing: an evaluator that answers with rows made
// beforehand.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "hypgen/math/scalar_functions.hpp"
#include "hypgen/search/search.hpp"
#include "hypgen/search/tree_check.hpp"

namespace {

using namespace hypgen;

struct Setting {
  std::size_t actions = 100, children = 4, levels = 5, threads = 1, in_flight = 1, megabytes = 1024,
              blocks = 64;
  double seconds = 1.0, trials = 1e18, xi = 0.5, pruning = 0.0, exploration = 0.0;
  int searches = 3;
};

// A belief of C^l scenarios has, for each action, C children of C^(l-1); of one scenario one of one. For each
// level there are several expansions to answer with, so that rows come from memory and not from the nearest
// cache.
class PreparedEvaluator final : public LeafEvaluator {
 public:
  explicit PreparedEvaluator(const Setting& setting) : setting_(setting), seats_(setting.threads) {
    for (Seat& seat : seats_) seat.queue.resize(setting.in_flight);
    std::mt19937 random(1);
    std::size_t count = 1;
    for (std::size_t level = 0; level <= setting.levels; ++level, count *= setting.children) {
      counts_.push_back(count);
      for (std::size_t i = 0; i < setting.blocks; ++i) blocks_.push_back(make_block(count, random));
    }
  }

  RootResult begin_search(const ScenarioBuffer&, const SearchSetup&) override {
    release();
    const auto count = static_cast<std::uint32_t>(counts_.back());
    ChildRow row = empty_row(0, count, false);
    row.upper_sum = fixed(4.0) * count;
    return {Status::kOk, row, 0};
  }

  std::size_t threads() const override { return seats_.size(); }

  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    Seat& seat = seats_[thread];
    const std::size_t count = std::min(requests.size(), seat.queue.size() - seat.size);
    for (std::size_t i = 0; i < count; ++i) {
      seat.queue[(seat.head + seat.size++) % seat.queue.size()] = requests[i];
    }
    return count;
  }

  bool poll(std::size_t thread, LeafResult& result) override {
    Seat& seat = seats_[thread];
    if (seat.size == 0) return false;
    const LeafRequest& request = seat.queue[seat.head];
    seat.head = (seat.head + 1) % seat.queue.size();
    --seat.size;
    std::size_t level = 0;
    while (counts_[level] < request.count) ++level;
    const std::size_t choice = (seat.answered++ * 7 + thread) % setting_.blocks;
    const Block& block = blocks_[level * setting_.blocks + choice];
    result = {request.ticket, Status::kOk, seat.answered, request.count, block.actions, block.children, {}};
    return true;
  }

  void release() override {
    for (Seat& seat : seats_) seat.size = seat.head = seat.answered = 0;
  }

  std::size_t scenarios() const { return counts_.back(); }

 private:
  struct Block {
    std::vector<ActionRow> actions;
    std::vector<ChildRow> children;
  };

  struct alignas(kCacheLine) Seat {
    std::vector<LeafRequest> queue;  // a ring
    std::size_t head = 0, size = 0, answered = 0;
  };

  static std::int64_t fixed(double value) { return math::to_fixed(static_cast<float>(value)); }

  Block make_block(std::size_t count, std::mt19937& random) const {
    std::uniform_real_distribution<double> number(0.0, 1.0);
    const std::size_t children = count == 1 ? 1 : setting_.children, share = count / children;
    Block block;
    for (std::size_t a = 0; a < setting_.actions; ++a) {
      const auto first = static_cast<std::uint32_t>(block.children.size());
      ActionRow row{fixed(0.1 * number(random)) * static_cast<std::int64_t>(count),
                    0,
                    0,
                    static_cast<int>(a),
                    first,
                    static_cast<std::uint32_t>(children),
                    0};
      for (std::size_t c = 0; c < children; ++c) {
        ChildRow child = empty_row(static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(share), false);
        child.lower_sum = fixed(number(random)) * static_cast<std::int64_t>(share);
        child.upper_sum = child.lower_sum + fixed(1.0 + number(random)) * static_cast<std::int64_t>(share);
        row.upper_sum += child.upper_sum;
        row.lower_sum += child.lower_sum;
        block.children.push_back(child);
      }
      block.actions.push_back(row);
    }
    return block;
  }

  Setting setting_;
  std::vector<std::size_t> counts_;
  std::vector<Block> blocks_;
  std::vector<Seat> seats_;  // by thread
};

// How long a search takes whose deadline is over at once: it frees the last one's tree and expands the root.
double seconds_to_begin(Search& search, PreparedEvaluator& evaluator, const PlannerOptions& options) {
  const Clock::time_point start = Clock::now();
  const SearchSetup setup{{}, options.depth, false, start};
  Decision decision;
  const RootResult root = evaluator.begin_search({}, setup);
  search.run(evaluator, root, setup, {}, decision);
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void measure(const Setting& setting) {
  PreparedEvaluator evaluator(setting);
  PlannerOptions options;
  options.in_flight = std::max(setting.in_flight, setting.threads);
  options.threads = setting.threads;
  options.scenarios = evaluator.scenarios();
  options.target_ratio = setting.xi;
  options.pruning = setting.pruning;
  options.exploration = setting.exploration;
  options.gap = 0.0;
  options.trial_limit = static_cast<std::uint64_t>(setting.trials);
  Search search(options, {setting.megabytes << 20, options.depth, 0.95, options.pruning, setting.threads,
                          options.exploration > 0.0});
  for (int i = 0; i < setting.searches; ++i) {
    const Clock::time_point start = Clock::now();
    const auto limit =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(setting.seconds));
    const SearchSetup setup{{}, options.depth, false, start + limit};
    Decision decision;
    const RootResult root = evaluator.begin_search({}, setup);
    search.run(evaluator, root, setup, {}, decision);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    std::printf("%s: %.0f expansions/s, %.0f trials/s, %llu expansions in %.3f s, depth %d, gap %.4f\n",
                status_name(decision.status), static_cast<double>(decision.expansions) / seconds,
                static_cast<double>(decision.trials) / seconds,
                static_cast<unsigned long long>(decision.expansions), seconds, decision.max_depth,
                decision.upper - decision.lower);
    search.park(Clock::time_point::max());
    std::printf("  of a thread's time: descent %.1f%%, backup %.1f%%\n",
                100.0 * decision.descent_seconds / seconds, 100.0 * decision.backup_seconds / seconds);
    const std::string fault = tree_fault(search.tree(), decision.status != Status::kTrialLimit);
    if (!fault.empty()) std::printf("the tree is wrong: %s\n", fault.c_str());
    std::printf("  to begin anew takes %.3f ms\n", 1e3 * seconds_to_begin(search, evaluator, options));
  }
}

}  // namespace

int main(int argc, char** argv) {
  Setting setting;
  const auto read = [](const char* text, const char* name, auto& value) {
    const std::size_t length = std::strlen(name);
    if (std::strncmp(text, name, length) != 0 || text[length] != '=') return false;
    value = static_cast<std::decay_t<decltype(value)>>(std::atof(text + length + 1));
    return true;
  };
  for (int i = 1; i < argc; ++i) {
    const char* text = argv[i];
    const bool known = read(text, "actions", setting.actions) || read(text, "children", setting.children) ||
                       read(text, "levels", setting.levels) || read(text, "in_flight", setting.in_flight) ||
                       read(text, "threads", setting.threads) || read(text, "memory", setting.megabytes) ||
                       read(text, "blocks", setting.blocks) || read(text, "seconds", setting.seconds) ||
                       read(text, "trials", setting.trials) || read(text, "xi", setting.xi) ||
                       read(text, "pruning", setting.pruning) ||
                       read(text, "exploration", setting.exploration) ||
                       read(text, "searches", setting.searches);
    if (!known) {
      std::fprintf(stderr, "tree: unknown setting %s\n", text);
      return 2;
    }
  }
  measure(setting);
  return 0;
}
