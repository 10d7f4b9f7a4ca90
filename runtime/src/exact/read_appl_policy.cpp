// SPDX-License-Identifier: Apache-2.0
// The reading half of appl_policy.hpp.
#include <algorithm>
#include <cmath>
#include <istream>
#include <iterator>
#include <limits>
#include <locale>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "../model/input_text.hpp"
#include "exported_states.hpp"
#include "hypgen/exact/appl_policy.hpp"

namespace hypgen::exact {

namespace {

using Json = nlohmann::json;

constexpr const char* kComment = "<!-- hypgen ";

std::size_t index(int i) { return static_cast<std::size_t>(i); }

[[noreturn]] void damaged(const std::string& why) {
  throw PolicyError("the policy's file is damaged: " + why);
}

// A tag, and the text up to the next one.
struct Tag {
  std::string name;  // begins with a slash where it closes an element
  std::map<std::string, std::string> attributes;
  std::string text;
};

Tag parse_tag(const std::string& inside) {
  Tag tag;
  std::size_t at = inside.find_first_of(" \t\r\n");
  tag.name = inside.substr(0, at);
  while (at != std::string::npos) {
    const std::size_t begin = inside.find_first_not_of(" \t\r\n", at);
    const std::size_t equals = begin == std::string::npos ? begin : inside.find('=', begin);
    if (equals == std::string::npos || equals + 1 >= inside.size()) break;
    const std::size_t end = inside.find(inside[equals + 1], equals + 2);
    if (end == std::string::npos) damaged("an attribute of " + excerpt(tag.name) + " does not end");
    tag.attributes[inside.substr(begin, equals - begin)] = inside.substr(equals + 2, end - equals - 2);
    at = end + 1;
  }
  return tag;
}

// Reads tag after tag, so that the whole text is never in memory twice. No part has more than `most` bytes.
class Tags {
 public:
  Tags(std::istream& in, std::size_t most) : in_(in), most_(most) { read_until('<', before_); }

  // The next tag, and none at the end. What `names` comments say is kept.
  std::optional<Tag> next() {
    std::string inside;
    while (true) {
      if (!read_until('>', inside)) return std::nullopt;
      if (inside.rfind("!--", 0) == 0) {
        take_comment(std::move(inside));
      } else if (inside.empty() || (inside[0] != '?' && inside[0] != '!')) {
        break;
      }
      read_until('<', before_);
    }
    Tag tag = parse_tag(inside);
    read_until('<', tag.text);
    return tag;
  }

  const std::optional<Json>& names() const { return names_; }

 private:
  // As std::getline does.
  bool read_until(char end, std::string& part) {
    part.clear();
    if (in_.eof()) return false;
    constexpr int kEnd = std::char_traits<char>::eof();
    int byte = in_.get();
    for (; byte != kEnd && byte != end; byte = in_.get()) {
      if (part.size() == most_) damaged("a part of it is larger than " + megabytes(most_));
      part += static_cast<char>(byte);
    }
    return byte == end || !part.empty();
  }

  void take_comment(std::string text) {
    const auto ends = [&] { return text.size() >= 5 && text.compare(text.size() - 2, 2, "--") == 0; };
    for (std::string more; !ends() && text.size() < most_ && read_until('>', more);) text += ">" + more;
    if (("<" + text).rfind(kComment, 0) != 0) return;
    const std::size_t begin = std::string(kComment).size() - 1;
    Json json;
    std::string problem;
    if (!ends() || !parse_json(text.substr(begin, text.size() - 2 - begin), json, problem))
      damaged("its names cannot be read");
    if (!json.is_object()) damaged("its names cannot be read");
    names_ = json;
  }

  std::istream& in_;
  std::size_t most_;
  std::string before_;
  std::optional<Json> names_;
};

std::size_t number_in(const Tag& tag, const char* attribute) {
  const auto found = tag.attributes.find(attribute);
  if (found == tag.attributes.end()) damaged("a " + excerpt(tag.name) + " has no " + attribute);
  const std::string& text = found->second;
  if (text.empty() || text.size() > 18 || text.find_first_not_of("0123456789") != std::string::npos)
    damaged(std::string(attribute) + "=\"" + excerpt(text) + "\" is no number");
  return std::stoull(text);
}

std::vector<double> values_in(const Tag& tag, std::size_t count) {
  std::vector<double> values;
  values.reserve(count);
  std::istringstream in(tag.text);
  in.imbue(std::locale::classic());
  for (double value = 0.0; in >> value;) {
    if (!std::isfinite(value) || values.size() == count) break;
    values.push_back(value);
  }
  if (values.size() != count || !in.eof()) {
    damaged("a vector has other values than " + std::to_string(count) + " numbers");
  }
  return values;
}

void check_names(const Json& names, const ExactDescriptor& descriptor, const ExactModel& model) {
  const Json hash = names.value("policy_hash", Json());
  if (!hash.is_number_unsigned() || hash.get<std::uint64_t>() != model_hash(model))
    throw PolicyError("the policy is of another model, or of other params");
  const Json actions = names.value("actions", Json::array());
  const auto& ours = descriptor.descriptor.action_names;
  if (!actions.is_array()) damaged("its names of actions are no array");
  for (std::size_t a = 0; a < std::max(actions.size(), ours.size()); ++a) {
    if (a < actions.size() && a < ours.size() && actions[a] == ours[a]) continue;
    throw PolicyError("action " + std::to_string(a) + " of the policy is " +
                      (a < actions.size() ? excerpt(actions[a].dump()) : "missing") + ", and of the model " +
                      (a < ours.size() ? "\"" + ours[a] + "\"" : "missing"));
  }
}

// The action that does what the file's does in a class; -1 where nothing is legal.
int action_in(const ExactModel& model, std::size_t action, int state) {
  if (!std::isinf(model.actions[action].reward[state])) return static_cast<int>(action);
  for (std::size_t a = 0; a < model.actions.size(); ++a) {
    if (!std::isinf(model.actions[a].reward[state])) return static_cast<int>(a);
  }
  return -1;
}

class Reader {
 public:
  Reader(const ExactDescriptor& descriptor, const ExactModel& model)
      : descriptor_(descriptor), model_(model), exported_(model), classes_(index(model.classes())) {}

  AlphaPolicy read(std::istream& in) {
    Tags tags(in, most_input(exported_.size()));
    read_head(tags);
    std::size_t vectors = 0;
    while (std::optional<Tag> tag = tags.next()) {
      if (tag->name == "/Vector") continue;
      if (tag->name != "Vector") {
        if (tag->name != "/AlphaVector") damaged("it has <" + excerpt(tag->name) + "> where vectors stand");
        if (vectors != vectors_)
          damaged("it says that it has " + std::to_string(vectors_) + " vectors, and has " +
                  std::to_string(vectors));
        return AlphaPolicy(model_, std::move(classes_));
      }
      ++vectors;
      read_vector(*tag);
    }
    damaged("it ends too early");
  }

 private:
  void read_head(Tags& tags) {
    std::optional<Tag> tag = tags.next();
    if (!tag || tag->name != "Policy") throw PolicyError("this is not a file of a policy");
    tag = tags.next();
    if (!tag || tag->name != "AlphaVector") damaged("it has no AlphaVector");
    if (number_in(*tag, "numObsValue") != 1) {
      throw PolicyError(
          "the policy is of a model with fully observed variables; what hypgen export writes has none");
    }
    const std::size_t length = number_in(*tag, "vectorLength");
    if (length != exported_.size()) {
      throw PolicyError("the policy is of another model, or of other params: its vectors have " +
                        std::to_string(length) + " values, and what hypgen export writes has " +
                        std::to_string(exported_.size()) + " states");
    }
    vectors_ = number_in(*tag, "numVectors");
    if (!tags.names()) return;
    check_names(*tags.names(), descriptor_, model_);
    const Json outside = tags.names()->value("outside", Json());
    if (outside.is_number()) outside_ = outside.get<double>();
  }

  // Adds its part for each class of states. Copies of a state may differ by rounding: the least counts.
  void read_vector(const Tag& tag) {
    const std::size_t action = number_in(tag, "action");
    if (action >= model_.actions.size()) damaged("there is no action " + std::to_string(action));
    const std::vector<double> values = values_in(tag, exported_.size());
    std::vector<double> of_state(index(model_.states), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < exported_.state.size(); ++i) {
      double& value = of_state[index(exported_.state[i])];
      value = std::min(value, values[i]);
    }
    for (std::size_t c = 0; c < classes_.size(); ++c) {
      const auto begin = of_state.begin() + model_.class_begin[c];
      const auto end = of_state.begin() + model_.class_begin[c + 1];
      const int taken = action_in(model_, action, model_.class_begin[c]);
      if (taken < 0 || (outside_ && std::all_of(begin, end, [&](double v) { return v <= *outside_; })))
        continue;
      std::vector<double> part(begin, end);
      std::vector<AlphaPolicy::Vector>& known = classes_[c].vectors;
      // Programs that do not know of classes repeat many a part.
      if (std::any_of(known.begin(), known.end(), [&](const auto& one) { return one.values == part; }))
        continue;
      known.push_back({taken, {}, std::move(part)});
    }
  }

  const ExactDescriptor& descriptor_;
  const ExactModel& model_;
  ExportedStates exported_;
  std::size_t vectors_ = 0;
  std::optional<double> outside_;
  std::vector<AlphaPolicy::Class> classes_;
};

}  // namespace

AlphaPolicy read_appl_policy(std::istream& in, const ExactDescriptor& descriptor, const ExactModel& model) {
  return Reader(descriptor, model).read(in);
}

}  // namespace hypgen::exact
