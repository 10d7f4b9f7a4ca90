// SPDX-License-Identifier: Apache-2.0
#include "option_table.hpp"

#include <locale.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <sstream>

#include "../model/input_text.hpp"
#include "hypgen/solver/options.hpp"

namespace hypgen {

namespace {

bool read_belief(const std::string& text, BeliefKind& kind) {
  for (const BeliefKind candidate : {BeliefKind::kAuto, BeliefKind::kParticle, BeliefKind::kFactored}) {
    if (text == belief_name(candidate)) {
      kind = candidate;
      return true;
    }
  }
  return false;
}

}  // namespace

const char* belief_name(BeliefKind kind) {
  switch (kind) {
    case BeliefKind::kAuto:
      return "auto";
    case BeliefKind::kParticle:
      return "particle";
    case BeliefKind::kFactored:
      return "factored";
    case BeliefKind::kVisible:
      return "visible";
  }
  return "unknown";
}

bool read_double(const std::string& text, double low, double high, double& out) {
  static const locale_t kNoLocale = newlocale(LC_ALL_MASK, "C", nullptr);  // a host may have one with commas
  char* end = nullptr;
  const double value = strtod_l(text.c_str(), &end, kNoLocale);
  if (text.empty() || *end != '\0' || !(low <= value && value <= high)) return false;
  out = value;
  return true;
}

bool read_integer(const std::string& text, std::uint64_t low, std::uint64_t high, std::uint64_t& out) {
  if (text.empty() || !std::all_of(text.begin(), text.end(), [](char c) { return '0' <= c && c <= '9'; }))
    return false;
  errno = 0;
  const unsigned long long value = std::strtoull(text.c_str(), nullptr, 10);
  if (errno != 0 || value < low || value > high) return false;
  out = value;
  return true;
}

std::string integer_range(std::uint64_t low, std::uint64_t high) {
  const std::string most = high == UINT64_MAX ? " (64 bits)" : " to " + std::to_string(high);
  return "an integer from " + std::to_string(low) + most;
}

Option number(const char* name, const char* metavar, const char* help, double low, double high, double& out) {
  std::ostringstream range;
  range << "a number from " << low << " to " << high;
  return {name, metavar, help, range.str(),
          [=, &out](const std::string& text) { return read_double(text, low, high, out); }};
}

Option file(const char* name, const char* help, std::string& out) {
  return {name, "FILE", help, "the name of a file", [&out](const std::string& text) {
            out = text;
            return !text.empty();
          }};
}

Option toggle(const char* name, const char* help, bool& out) {
  return {name, nullptr, help, "", [&out](const std::string&) { return out = true; }};
}

Option mebibytes(const char* name, const char* help, std::size_t& bytes) {
  return {name, "MIB", help, integer_range(1, kMillion), [&bytes](const std::string& text) {
            std::size_t mib = 0;
            if (!read_integer(text, 1, kMillion, mib)) return false;
            bytes = mib << 20;
            return true;
          }};
}

Option belief_kind(BeliefKind& kind) {
  return {
      "--belief", "KIND",
      "factored (a posterior for each independent part of the state), particle (of whole states) or auto: "
      "factored where the model allows it (auto)",
      "auto, factored or particle", [&kind](const std::string& text) { return read_belief(text, kind); }};
}

Option particles(std::size_t& count) {
  return integer("--particles", "N", "particles of the belief (5000)", 1, 10 * kMillion, count);
}

bool read_options(const std::vector<Option>& table, int argc, const char* const* argv,
                  std::vector<std::string>& given, std::string& error) {
  for (int i = 1; i < argc; ++i) {
    std::string name = argv[i];
    const std::size_t equals = name.find('=');
    const bool joined = equals != std::string::npos;
    std::string value = joined ? name.substr(equals + 1) : "";
    name = name.substr(0, equals);
    const auto found =
        std::find_if(table.begin(), table.end(), [&](const Option& o) { return name == o.name; });
    if (found == table.end()) {
      error = "unknown option " + excerpt(name) + "; --help lists the options";
      return false;
    }
    if (found->metavar == nullptr && joined) {
      error = name + " takes no value";
      return false;
    }
    if (found->metavar != nullptr && !joined) {
      if (++i == argc) {
        error = name + " needs a value: " + found->expected;
        return false;
      }
      value = argv[i];
    }
    if (!found->take(value)) {
      error = name + ": bad value \"" + excerpt(value) + "\"; expected " + found->expected;
      return false;
    }
    given.push_back(name);
  }
  return true;
}

std::string help_lines(const std::vector<Option>& table) {
  std::string text;
  for (const Option& option : table) {
    std::string head =
        std::string("  ") + option.name + (option.metavar ? std::string(" ") + option.metavar : "");
    head.resize(std::max<std::size_t>(head.size() + 2, 30), ' ');
    text += head + option.help + "\n";
  }
  return text;
}

std::string version_text(const ModelDescriptor& model) {
  return model.name + " (model " + model.hash + ", descriptor " + std::to_string(model.version) + ")\n";
}

std::string help_params(const ModelDescriptor& model) {
  if (model.params.empty()) return "";
  std::string text = "\nParams (set by --param FILE, a JSON object):";
  for (const ParamSpec& param : model.params) text += " " + param.name;
  return text + "\n";
}

}  // namespace hypgen
