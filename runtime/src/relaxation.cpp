#include "hypgen/relaxation.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

namespace hypgen::relaxation {
namespace {

// Outcomes looked at in all sweeps together: about a second.
constexpr double kMostWork = 1e9;
constexpr double kNegligible = 1e-9;  // of a value

// Value iteration in place.
class Iteration {
 public:
  Iteration(const Outcomes& outcomes, double discount, bool may_stop)
      : outcomes_(outcomes),
        discount_(discount),
        may_stop_(may_stop),
        values_(outcomes.first_choice.size() - 1, 0.0) {}

  // Sweeps forth and back, so that what a state is worth runs along both ways in a single sweep.
  void run() {
    const auto size = static_cast<double>(outcomes_.next.size() + outcomes_.reward.size() + values_.size());
    for (double work = size; work <= kMostWork; work += 2 * size) {
      double change = 0.0;
      double largest = 0.0;
      for (std::size_t i = 0; i < values_.size(); ++i) update(i, change, largest);
      for (std::size_t i = values_.size(); i-- > 0;) update(i, change, largest);
      if (change <= kNegligible * largest) return;
    }
  }

  // The optimal values V* lie at most d / (1 - discount) above the present ones V, d the most that one more
  // sweep would raise a value by; so V* = T V* lies at most discount d / (1 - discount) above T V.
  std::vector<double> bound() const {
    std::vector<double> result(values_.size());
    double raised = 0.0;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      result[i] = backup(i);
      raised = std::max(raised, result[i] - values_[i]);
    }
    for (double& value : result) value += discount_ * raised / (1.0 - discount_);
    return result;
  }

 private:
  double backup(std::size_t state) const {
    const auto begin = static_cast<std::size_t>(outcomes_.first_choice[state]);
    const auto end = static_cast<std::size_t>(outcomes_.first_choice[state + 1]);
    if (begin == end) return 0.0;  // no legal action: the episode ends
    double best = -std::numeric_limits<double>::infinity();
    auto outcome = static_cast<std::size_t>(outcomes_.first_outcome[begin]);
    for (std::size_t choice = begin; choice < end; ++choice) {
      double after = 0.0;
      const auto last = static_cast<std::size_t>(outcomes_.first_outcome[choice + 1]);
      for (; outcome < last; ++outcome) {
        after += outcomes_.probability[outcome] * values_[static_cast<std::size_t>(outcomes_.next[outcome])];
      }
      best = std::max(best, outcomes_.reward[choice] + discount_ * after);
    }
    return may_stop_ ? std::max(best, 0.0) : best;
  }

  void update(std::size_t state, double& change, double& largest) {
    const double value = backup(state);
    change = std::max(change, std::abs(value - values_[state]));
    largest = std::max(largest, std::abs(value));
    values_[state] = value;
  }

  const Outcomes& outcomes_;
  double discount_;
  bool may_stop_;
  std::vector<double> values_;
};

// Threads that fill tables: what they enumerate takes up to some hundred MiB each.
constexpr std::size_t kMostThreads = 8;

}  // namespace

void Outcomes::clear() {
  first_choice.assign(1, 0);
  first_outcome.assign(1, 0);
  reward.clear();
  next.clear();
  probability.clear();
}

void run_jobs(std::size_t count, const std::function<void(std::size_t job, Outcomes&)>& run) {
  std::atomic<std::size_t> taken{0};
  const auto work = [&] {
    Outcomes outcomes;
    for (std::size_t job = taken++; job < count; job = taken++) run(job, outcomes);
  };
  std::vector<std::thread> threads;
  const std::size_t wanted =
      std::min<std::size_t>({count, std::thread::hardware_concurrency(), kMostThreads});
  for (std::size_t i = 1; i < wanted; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
}

std::vector<double> worth(const Outcomes& outcomes, double discount, bool may_stop) {
  Iteration iteration(outcomes, discount, may_stop);
  iteration.run();
  return iteration.bound();
}

float rounded_up(double value) {
  return std::nextafter(static_cast<float>(value + 1e-6 * std::abs(value)),
                        std::numeric_limits<float>::infinity());
}

}  // namespace hypgen::relaxation
