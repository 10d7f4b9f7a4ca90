// SPDX-License-Identifier: Apache-2.0
// Graphs of policies, against what is known of the tiger.
#include "hypgen/exact/policy_graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "exact_models.hpp"
#include "hypgen/exact/interval.hpp"

namespace hypgen::exact {
namespace {

AlphaPolicy solve(const ExactModel& model) {
  IntervalOptions options;
  options.seconds = 20.0;
  options.gap = 1e-6;
  return solve_interval(model, options, [](const IntervalResult&) { return true; }).alpha;
}

PolicyGraph graph_of(const ExactModel& model, std::size_t kept) {
  WalkLimits limits;
  limits.kept = kept;
  return policy_graph(model, solve(model), limits);
}

TEST(PolicyGraph, OfTheTigerListensUntilItIsSure) {
  const PolicyGraph graph = graph_of(make_tiger(), 20);
  EXPECT_EQ(graph.left_out, 0u);
  EXPECT_FALSE(graph.is_cut_off);
  ASSERT_EQ(graph.starts.size(), 1u);
  EXPECT_EQ(graph.starts[0].to, 0);
  EXPECT_EQ(graph.nodes[0].action, 0);
  EXPECT_NEAR(graph.nodes[0].value, 19.3714, 1e-3);
  ASSERT_EQ(graph.nodes[0].edges.size(), 2u);
  for (const GraphNode& node : graph.nodes) {
    double total = node.ends;
    for (const GraphEdge& edge : node.edges) {
      total += edge.probability;
      ASSERT_GE(edge.to, 0);
      ASSERT_LT(edge.to, static_cast<int>(graph.nodes.size()));
      double of_edge = 0.0;
      for (const auto& [observation, probability] : edge.observations) of_edge += probability;
      EXPECT_NEAR(of_edge, edge.probability, 1e-12);
    }
    EXPECT_NEAR(total, 1.0, 1e-12);
    // A door leads to where it all began, whatever is seen.
    if (node.action == 0) continue;
    ASSERT_EQ(node.edges.size(), 1u);
    EXPECT_EQ(node.edges[0].to, 0);
    EXPECT_EQ(node.edges[0].observations.size(), 2u);
  }
  const auto opens = [](const GraphNode& node) { return node.action != 0; };
  EXPECT_EQ(std::count_if(graph.nodes.begin(), graph.nodes.end(), opens), 2);
}

TEST(PolicyGraph, KeepsSoManyNodesAndCountsTheOthers) {
  const std::size_t all = graph_of(make_tiger(), 20).nodes.size();
  for (std::size_t kept = 1; kept < all; ++kept) {
    const PolicyGraph graph = graph_of(make_tiger(), kept);
    EXPECT_EQ(graph.nodes.size(), kept);
    EXPECT_EQ(graph.left_out, all - kept);
    bool leads_out = false;
    for (const GraphNode& node : graph.nodes) {
      for (const GraphEdge& edge : node.edges) leads_out = leads_out || edge.to < 0;
    }
    EXPECT_TRUE(leads_out);
  }
}

TEST(PolicyGraph, TellsWhereEpisodesEnd) {
  const PolicyGraph graph = graph_of(make_tiger_with_horizon(4), 100);
  double ends = 0.0;
  for (const GraphNode& node : graph.nodes) ends = std::max(ends, node.ends);
  EXPECT_EQ(ends, 1.0);
}

TEST(PolicyGraph, EndsWhereTheWalkIsTooLong) {
  const ExactModel model = make_tiger();
  WalkLimits few;
  few.found = 2;
  WalkLimits short_walk;
  short_walk.products = 1.0;
  for (const WalkLimits& limits : {few, short_walk}) {
    const PolicyGraph graph = policy_graph(model, solve(model), limits);
    EXPECT_TRUE(graph.is_cut_off);
    EXPECT_GT(graph.left_out, 0u);
  }
}

}  // namespace
}  // namespace hypgen::exact
