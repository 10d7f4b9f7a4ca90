// SPDX-License-Identifier: Apache-2.0
#include "hypgen/exact/policy.hpp"

#include <cstring>
#include <iomanip>
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

double expected(const AlphaPolicy::Class& of_class, const AlphaPolicy::Vector& vector,
                const SparseBelief& belief, int first) {
  double sum = 0.0;
  std::size_t at = 0;
  for (SparseBelief::InnerIterator entry(belief); entry; ++entry) {
    const int state = static_cast<int>(entry.index()) - first;
    while (at < vector.states.size() && vector.states[at] < state) ++at;
    const bool listed = at < vector.states.size() && vector.states[at] == state;
    const bool all = vector.states.empty();
    sum += entry.value() * (all      ? vector.values[index(state)]
                            : listed ? vector.values[at]
                                     : of_class.rest[index(state)]);
  }
  return sum;
}

void write_vector(std::ostream& out, const AlphaPolicy::Vector& vector) {
  out << vector.action << ' ' << vector.states.size();
  for (std::size_t i = 0; i < vector.values.size(); ++i) {
    if (!vector.states.empty()) out << ' ' << vector.states[i];
    out << ' ' << vector.values[i];
  }
  out << '\n';
}

AlphaPolicy::Vector read_vector(std::istream& in, const ExactModel& model, std::size_t class_states) {
  AlphaPolicy::Vector vector{read_number<int>(in, "action"), {}, {}};
  if (vector.action < 0 || index(vector.action) >= model.actions.size()) {
    throw PolicyError("the policy's file is damaged: no such action");
  }
  const auto listed = read_number<std::size_t>(in, "number of states");
  if (listed > class_states) throw PolicyError("the policy's file is damaged: too many states");
  for (std::size_t i = 0; i < (listed > 0 ? listed : class_states); ++i) {
    if (listed > 0) {
      const auto state = read_number<int>(in, "state");
      if (state < 0 || index(state) >= class_states || (i > 0 && state <= vector.states.back())) {
        throw PolicyError("the policy's file is damaged: no such state");
      }
      vector.states.push_back(state);
    }
    vector.values.push_back(read_number<double>(in, "value"));
  }
  return vector;
}

AlphaPolicy::Class read_class(std::istream& in, const ExactModel& model, std::size_t states) {
  AlphaPolicy::Class of_class;
  const auto count = read_number<std::size_t>(in, "number of vectors");
  const auto rest = read_number<std::size_t>(in, "number of values of the rest");
  if (rest != 0 && rest != states) throw PolicyError("the policy's file is damaged: other states");
  for (std::size_t i = 0; i < rest; ++i) of_class.rest.push_back(read_number<double>(in, "value"));
  for (std::size_t i = 0; i < count; ++i) {
    of_class.vectors.push_back(read_vector(in, model, states));
    if (rest == 0 && !of_class.vectors.back().states.empty()) {
      throw PolicyError("the policy's file is damaged: no values of the rest");
    }
  }
  return of_class;
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

AlphaPolicy::AlphaPolicy(const ExactModel& model, std::vector<Class> classes)
    : seen_(model.seen), class_begin_(model.class_begin), classes_(std::move(classes)) {}

const AlphaPolicy::Vector* AlphaPolicy::best(const SparseBelief& belief, double& value) const {
  const Vector* best = nullptr;
  value = 0.0;
  SparseBelief::InnerIterator some(belief);
  if (!some) return nullptr;
  const int of_class = seen_[static_cast<std::size_t>(some.index())];
  for (const Vector& vector : classes_[index(of_class)].vectors) {
    const double now = expected(classes_[index(of_class)], vector, belief, class_begin_[index(of_class)]);
    if (best != nullptr && now <= value) continue;
    best = &vector;
    value = now;
  }
  return best;
}

std::size_t AlphaPolicy::vectors_at(const SparseBelief& belief) const {
  SparseBelief::InnerIterator some(belief);
  return some ? classes_[index(seen_[static_cast<std::size_t>(some.index())])].vectors.size() : 0;
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
  out << kFormat << '\n' << model_hash(model) << ' ' << policy.classes().size() << '\n';
  for (const AlphaPolicy::Class& of_class : policy.classes()) {
    out << of_class.vectors.size() << ' ' << of_class.rest.size();
    for (const double value : of_class.rest) out << ' ' << value;
    out << '\n';
    for (const AlphaPolicy::Vector& vector : of_class.vectors) write_vector(out, vector);
  }
}

AlphaPolicy read_policy(std::istream& in, const ExactModel& model) {
  in.imbue(std::locale::classic());
  std::string format;  // as long as the file's first word may be, whatever that is
  if (!(in >> std::setw(static_cast<int>(std::strlen(kFormat)) + 1) >> format) || format != kFormat)
    throw PolicyError("this is not a file of a policy");
  if (read_number<std::uint64_t>(in, "hash") != model_hash(model)) {
    throw PolicyError("the policy is of another model, or of other params");
  }
  if (read_number<std::size_t>(in, "number of classes") != index(model.classes())) {
    throw PolicyError("the policy's file is damaged: other classes");
  }
  std::vector<AlphaPolicy::Class> classes;
  for (std::size_t c = 0; c < index(model.classes()); ++c) {
    classes.push_back(read_class(in, model, index(model.class_begin[c + 1] - model.class_begin[c])));
  }
  return AlphaPolicy(model, std::move(classes));
}

}  // namespace hypgen::exact
