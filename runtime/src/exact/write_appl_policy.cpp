// SPDX-License-Identifier: Apache-2.0
// The writing half of appl_policy.hpp.
#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "exported_states.hpp"
#include "hypgen/exact/appl_policy.hpp"
#include "state_names.hpp"

namespace hypgen::exact {

namespace {

using Json = nlohmann::ordered_json;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// In states of another class: less than all values, in few digits.
double outside_of(const AlphaPolicy& policy) {
  double least = 0.0;
  for (const AlphaPolicy::Class& of_class : policy.classes()) {
    for (const double value : of_class.rest) least = std::min(least, value);
    for (const AlphaPolicy::Vector& vector : of_class.vectors) {
      for (const double value : vector.values) least = std::min(least, value);
    }
  }
  return std::floor(least - std::max(1.0, 0.01 * std::abs(least)));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::string attribute(const std::string& text) {
  return replaced(replaced(replaced(text, "&", "&amp;"), "<", "&lt;"), "\"", "&quot;");
}

Json names_of(const ExactDescriptor& descriptor, const ExactModel& model, const ExportedStates& exported,
              double outside) {
  Json states = Json::array();
  for (const int state : exported.state) states.push_back(values_of(descriptor, model, state));
  if (exported.ended) states.push_back("ended");
  return {{"model", descriptor.descriptor.name},
          {"policy_hash", model_hash(model)},
          {"outside", outside},
          {"actions", descriptor.descriptor.action_names},
          {"variables", descriptor.descriptor.variable_names},
          {"states", std::move(states)}};
}

// All values of the class's states.
std::vector<double> dense(const AlphaPolicy::Class& of_class, const AlphaPolicy::Vector& vector) {
  if (vector.states.empty()) return vector.values;
  std::vector<double> values = of_class.rest;
  for (std::size_t i = 0; i < vector.states.size(); ++i) values[index(vector.states[i])] = vector.values[i];
  return values;
}

std::size_t vectors_of(const AlphaPolicy& policy) {
  std::size_t count = 0;
  for (const AlphaPolicy::Class& of_class : policy.classes()) count += of_class.vectors.size();
  return count;
}

}  // namespace

std::string appl_policy_problem(const ExactModel& model, const AlphaPolicy& policy) {
  const std::size_t vectors = vectors_of(policy), states = index(model.states);  // or a few more
  if (vectors * states <= kMostPolicyNumbers) return "";
  return std::to_string(vectors) + " vectors of " + std::to_string(states) +
         " states are too many for APPL's format, which has each vector's value in each state; in hypgen's "
         "own a vector has the states that look alike";
}

void write_appl_policy(std::ostream& out, const ExactDescriptor& descriptor, const ExactModel& model,
                       const AlphaPolicy& policy) {
  const ExportedStates exported(model);
  const double outside = outside_of(policy);
  out.imbue(std::locale::classic());
  out.precision(std::numeric_limits<double>::max_digits10);
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  // A comment may not hold two hyphens.
  out << "<!-- hypgen " << replaced(names_of(descriptor, model, exported, outside).dump(), "--", "-\\u002d")
      << " -->\n";
  out << "<Policy version=\"0.1\" type=\"value\" model=\"" << attribute(descriptor.descriptor.file)
      << "\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
         "xsi:noNamespaceSchemaLocation=\"policyx.xsd\">\n";
  out << "<AlphaVector vectorLength=\"" << exported.size() << "\" numObsValue=\"1\" numVectors=\""
      << vectors_of(policy) << "\">\n";
  for (std::size_t c = 0; c < policy.classes().size(); ++c) {
    for (const AlphaPolicy::Vector& vector : policy.classes()[c].vectors) {
      const std::vector<double> values = dense(policy.classes()[c], vector);
      out << "<Vector action=\"" << vector.action << "\" obsValue=\"0\">";
      for (const int state : exported.state) {
        const bool inside = index(model.seen[index(state)]) == c;
        const bool is_over = policy.classes()[index(model.seen[index(state)])].vectors.empty();
        out << (inside ? values[index(state - model.class_begin[c])] : is_over ? 0.0 : outside) << ' ';
      }
      if (exported.ended) out << "0 ";
      out << "</Vector>\n";
    }
  }
  out << "</AlphaVector> </Policy>\n";
}

}  // namespace hypgen::exact
