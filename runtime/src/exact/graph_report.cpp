// SPDX-License-Identifier: Apache-2.0
#include "graph_report.hpp"

#include <algorithm>
#include <vector>

#include "report_text.hpp"
#include "state_names.hpp"

namespace hypgen::exact {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kShownObservations = 3, kShownEdges = 20, kShownStarts = 10;
constexpr std::size_t kMostObservations = 100, kMostEdges = 1000, kMostStarts = 100;  // of a JSON object

std::string observation_name(const ExactDescriptor& descriptor, const ExactModel& model, int observation) {
  const auto words = static_cast<std::size_t>(model.key_words);
  return descriptor.descriptor.observation_name(
      {model.keys.data() + static_cast<std::size_t>(observation) * words, words});
}

const std::string& action_name(const ExactDescriptor& descriptor, const GraphNode& node) {
  return descriptor.descriptor.action_names[static_cast<std::size_t>(node.action)];
}

// Of equal ways the likely ones.
std::vector<GraphStart> likely_starts(const ExactModel& model, const PolicyGraph& graph) {
  std::vector<GraphStart> starts = graph.starts;
  std::stable_sort(starts.begin(), starts.end(), [&](const GraphStart& a, const GraphStart& b) {
    return model.starts[a.start].probability > model.starts[b.start].probability;
  });
  return starts;
}

SeenNames start_names(const ExactDescriptor& descriptor, const ExactModel& model) {
  return {descriptor, model, states_of_starts(model)};
}

std::string to_text(int to) { return to < 0 ? "..." : std::to_string(to + 1); }

std::string more(std::size_t all, std::size_t shown, const char* what) {
  return all > shown ? format("and %zu more %s", all - shown, what) : "";
}

// "left 0.85 -> 2"
std::string edge_text(const ExactDescriptor& descriptor, const ExactModel& model, const GraphEdge& edge) {
  std::string text = "    ";
  const std::size_t shown = std::min(edge.observations.size(), kShownObservations);
  for (std::size_t i = 0; i < shown; ++i) {
    text += (i > 0 ? " | " : "") + observation_name(descriptor, model, edge.observations[i].first);
  }
  if (edge.observations.size() > shown) text += " | " + more(edge.observations.size(), shown, "observations");
  return text + format(" (%.3g) -> ", edge.probability) + to_text(edge.to) + "\n";
}

Json edge_json(const ExactDescriptor& descriptor, const ExactModel& model, const GraphEdge& edge) {
  Json observations = Json::array();
  const std::size_t shown = std::min(edge.observations.size(), kMostObservations);
  for (std::size_t i = 0; i < shown; ++i) {
    observations.push_back(observation_name(descriptor, model, edge.observations[i].first));
  }
  Json json = {{"to", nullptr},
               {"probability", edge.probability},
               {"observations", std::move(observations)},
               {"observations_left_out", edge.observations.size() - shown}};
  if (edge.to >= 0) json["to"] = edge.to + 1;
  return json;
}

Json node_json(const ExactDescriptor& descriptor, const ExactModel& model, const PolicyGraph& graph,
               std::size_t number) {
  const GraphNode& node = graph.nodes[number];
  Json edges = Json::array();
  const std::size_t shown = std::min(node.edges.size(), kMostEdges);
  for (std::size_t i = 0; i < shown; ++i) edges.push_back(edge_json(descriptor, model, node.edges[i]));
  return {{"node", number + 1},        {"action", action_name(descriptor, node)},
          {"value", node.value},       {"ends", node.ends},
          {"edges", std::move(edges)}, {"edges_left_out", node.edges.size() - shown}};
}

}  // namespace

std::string graph_text(const ExactDescriptor& descriptor, const ExactModel& model, const PolicyGraph& graph) {
  std::string text =
      row("graph", format("%zu node%s", graph.nodes.size(), graph.nodes.size() == 1 ? "" : "s"));
  const SeenNames names = start_names(descriptor, model);
  const std::vector<GraphStart> starts = likely_starts(model, graph);
  const std::size_t shown_starts = std::min(starts.size(), kShownStarts);
  for (std::size_t i = 0; i < shown_starts; ++i) {
    const std::string seen = names.of(first_state(model, starts[i].start));
    text += "  start " + (seen.empty() ? "" : seen + " ") +
            format("(%.3g) -> ", model.starts[starts[i].start].probability) + to_text(starts[i].to) + "\n";
  }
  if (starts.size() > shown_starts) text += "  " + more(starts.size(), shown_starts, "ways to start") + "\n";
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const GraphNode& node = graph.nodes[n];
    text += "  " + std::to_string(n + 1) + " " + action_name(descriptor, node) + "\n";
    const std::size_t shown = std::min(node.edges.size(), kShownEdges);
    for (std::size_t i = 0; i < shown; ++i) text += edge_text(descriptor, model, node.edges[i]);
    if (node.edges.size() > shown) text += "    " + more(node.edges.size(), shown, "edges") + "\n";
    if (node.ends > 0.0) text += format("    (%.3g) -> the end\n", node.ends);
  }
  if (graph.left_out == 0) return text;
  return text + format("  ... %zu %snodes are left out; --graph %zu has room for %s\n", graph.left_out,
                       graph.is_cut_off ? "or more " : "", graph.nodes.size() + graph.left_out,
                       graph.is_cut_off ? "so many" : "all");
}

Json graph_json(const ExactDescriptor& descriptor, const ExactModel& model, const PolicyGraph& graph) {
  const SeenNames names = start_names(descriptor, model);
  const std::vector<GraphStart> all = likely_starts(model, graph);
  Json starts = Json::array(), nodes = Json::array();
  const std::size_t shown = std::min(all.size(), kMostStarts);
  for (std::size_t i = 0; i < shown; ++i) {
    Json start = {
        {"probability", model.starts[all[i].start].probability}, {"seen", nullptr}, {"to", nullptr}};
    const std::string seen = names.of(first_state(model, all[i].start));
    if (!seen.empty()) start["seen"] = seen;
    if (all[i].to >= 0) start["to"] = all[i].to + 1;
    starts.push_back(std::move(start));
  }
  for (std::size_t n = 0; n < graph.nodes.size(); ++n)
    nodes.push_back(node_json(descriptor, model, graph, n));
  return {{"starts", std::move(starts)},
          {"starts_left_out", all.size() - shown},
          {"nodes", std::move(nodes)},
          {"nodes_left_out", graph.left_out},
          {"may_have_more", graph.is_cut_off}};
}

}  // namespace hypgen::exact
