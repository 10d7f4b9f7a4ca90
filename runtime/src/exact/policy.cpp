#include "hypgen/exact/policy.hpp"

#include <cstring>
#include <istream>
#include <limits>
#include <locale>
#include <ostream>
#include <sstream>
#include <utility>

namespace hypgen::exact {
namespace {

constexpr const char* kFormat = "hypgen-policy-1";

std::size_t index(int i) { return static_cast<std::size_t>(i); }

class Hash {
 public:
  void add(std::uint64_t value) {
    value_ = (value_ ^ value) * 0x9E3779B97F4A7C15u;
    value_ ^= value_ >> 32;
  }
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  }
  void add(int value) { add(static_cast<std::uint64_t>(value)); }
  void add(const std::vector<int>& values) {
    add(static_cast<std::uint64_t>(values.size()));
    for (const int value : values) add(value);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

void add_action(const ExactAction& action, Hash& hash) {
  hash.add(action.next);
  hash.add(action.observations);
  hash.add(action.begin);
  for (Eigen::Index state = 0; state < action.reward.size(); ++state) {
    hash.add(action.reward[state]);
    for (SparseMatrix::InnerIterator entry(action.outcomes, state); entry; ++entry) {
      hash.add(static_cast<int>(entry.col()));
      hash.add(entry.value());
    }
  }
}

template <class T>
T read_number(std::istream& in, const char* what) {
  T value{};
  if (!(in >> value)) throw PolicyError(std::string("the policy's file is damaged: no ") + what);
  return value;
}

}  // namespace

std::uint64_t model_hash(const ExactModel& model) {
  Hash hash;
  hash.add(model.discount);
  hash.add(model.horizon);
  hash.add(model.class_begin);
  for (const ExactAction& action : model.actions) add_action(action, hash);
  return hash.value();
}

AlphaPolicy::AlphaPolicy(const ExactModel& model, std::vector<std::vector<Vector>> vectors)
    : seen_(model.seen), class_begin_(model.class_begin), vectors_(std::move(vectors)) {}

const AlphaPolicy::Vector* AlphaPolicy::best(const SparseBelief& belief, double& value) const {
  const Vector* best = nullptr;
  value = 0.0;
  SparseBelief::InnerIterator some(belief);
  if (!some) return nullptr;
  const int of_class = seen_[static_cast<std::size_t>(some.index())];
  for (const Vector& vector : vectors_[index(of_class)]) {
    double sum = 0.0;
    for (SparseBelief::InnerIterator entry(belief); entry; ++entry) {
      sum += entry.value() *
             vector.values[static_cast<std::size_t>(entry.index() - class_begin_[index(of_class)])];
    }
    if (best != nullptr && sum <= value) continue;
    best = &vector;
    value = sum;
  }
  return best;
}

int AlphaPolicy::action(const SparseBelief& belief) const {
  double value = 0.0;
  const Vector* vector = best(belief, value);
  return vector == nullptr ? -1 : vector->action;
}

double AlphaPolicy::value(const SparseBelief& belief) const {
  double value = 0.0;
  best(belief, value);
  return value;
}

void write_policy(std::ostream& out, const ExactModel& model, const AlphaPolicy& policy) {
  out.imbue(std::locale::classic());
  out.precision(std::numeric_limits<double>::max_digits10);
  out << kFormat << '\n' << model_hash(model) << ' ' << policy.vectors().size() << '\n';
  for (const auto& vectors : policy.vectors()) {
    out << vectors.size() << '\n';
    for (const AlphaPolicy::Vector& vector : vectors) {
      out << vector.action;
      for (const double value : vector.values) out << ' ' << value;
      out << '\n';
    }
  }
}

AlphaPolicy read_policy(std::istream& in, const ExactModel& model) {
  in.imbue(std::locale::classic());
  std::string format;
  if (!(in >> format) || format != kFormat) throw PolicyError("this is not a file of a policy");
  if (read_number<std::uint64_t>(in, "hash") != model_hash(model)) {
    throw PolicyError("the policy is of another model, or of other params");
  }
  const auto classes = read_number<std::size_t>(in, "number of classes");
  if (classes != index(model.classes())) throw PolicyError("the policy's file is damaged: other classes");
  std::vector<std::vector<AlphaPolicy::Vector>> all(classes);
  for (std::size_t c = 0; c < classes; ++c) {
    const auto states = index(model.class_begin[c + 1] - model.class_begin[c]);
    const auto count = read_number<std::size_t>(in, "number of vectors");
    for (std::size_t i = 0; i < count; ++i) {
      AlphaPolicy::Vector vector{read_number<int>(in, "action"), {}};
      if (vector.action < 0 || index(vector.action) >= model.actions.size()) {
        throw PolicyError("the policy's file is damaged: no such action");
      }
      for (std::size_t s = 0; s < states; ++s) vector.values.push_back(read_number<double>(in, "value"));
      all[c].push_back(std::move(vector));
    }
  }
  return AlphaPolicy(model, std::move(all));
}

}  // namespace hypgen::exact
