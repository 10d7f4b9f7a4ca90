// SPDX-License-Identifier: Apache-2.0
// What the self-test says of a GPU that the CPU stands in for, and of what that may compute otherwise.
#include "hypgen/verify/selftest.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "hypgen/leaves/device.hpp"
#include "hypgen/verify/verifiable_instance.hpp"
#include "test_solvers.hpp"

namespace hypgen::testing {
namespace {

using Json = nlohmann::json;

enum class Fault { kNone, kDigest, kNoDigest, kLeaf, kNoEvaluator };

// Fails at the second leaf.
class Failing final : public LeafEvaluator {
 public:
  explicit Failing(std::unique_ptr<LeafEvaluator> inner) : inner_(std::move(inner)) {}
  std::size_t threads() const override { return inner_->threads(); }
  void attach(std::size_t thread) override { inner_->attach(thread); }
  RootResult begin_search(const ScenarioBuffer& root, const SearchSetup& setup) override {
    return inner_->begin_search(root, setup);
  }
  std::size_t submit(std::size_t thread, Span<const LeafRequest> requests) override {
    return inner_->submit(thread, requests);
  }
  bool poll(std::size_t thread, LeafResult& result) override {
    const bool found = inner_->poll(thread, result);
    if (found && ++leaves_ == 2) result.status = Status::kEvaluatorFailed;
    return found;
  }
  void release() override { inner_->release(); }

 private:
  std::unique_ptr<LeafEvaluator> inner_;
  int leaves_ = 0;
};

class FakeGpu final : public DeviceSupport {
 public:
  FakeGpu(const ModelInstance& instance, Fault fault) : instance_(instance), fault_(fault) {}

  std::vector<DeviceInfo> devices(std::string&) const override { return {{3, "fake", 9, 0, 1, 1}}; }
  std::unique_ptr<LeafEvaluator> make_evaluator(const void*, const EvaluatorOptions& options, int,
                                                std::string& error) const override {
    if (fault_ == Fault::kNoEvaluator) {
      error = "no memory";
      return nullptr;
    }
    auto evaluator = instance_.make_evaluator(options);
    if (fault_ != Fault::kLeaf) return evaluator;
    return std::make_unique<Failing>(std::move(evaluator));
  }

  std::unique_ptr<Worlds> make_worlds(const void*, std::uint64_t, std::size_t, const std::vector<KeyDigit>&,
                                      int, std::string&) const override {
    return nullptr;
  }

 private:
  const ModelInstance& instance_;
  Fault fault_;
};

// Walks on that GPU.
bool walk(const VerifiableInstance& instance, Fault fault, const DigestRange& range, int warps,
          std::uint64_t* out, std::string& error) {
  if (fault == Fault::kNoDigest) {
    error = "no memory";
    return false;
  }
  instance.digests(range, warps, out);
  constexpr std::uint32_t kLane = 5, kStep = 3;
  const bool is_asked = kLane >= range.first_lane && kLane < range.first_lane + range.lanes;
  if (fault == Fault::kDigest && is_asked && range.steps > kStep) ++out[kLane - range.first_lane];
  return true;
}

VerifiableModel verifiable_tiger() { return make_verifiable<Tiger>(tiger_descriptor()); }

std::unique_ptr<VerifiableInstance> instance_of(const VerifiableModel& model) {
  std::string error;
  return model.create(ParamValues(model.descriptor.params), error);
}

struct Found {
  int code;
  std::vector<Json> lines;

  // The line of a check.
  Json of(const std::string& check) const {
    for (const Json& line : lines) {
      if (line["check"] == check) return line;
    }
    return {};
  }
};

Found check(Fault fault) {
  VerifiableModel model = verifiable_tiger();
  const auto instance = instance_of(model);
  const FakeGpu gpu(*instance, fault);
  model.descriptor.device = &gpu;
  model.walk_on_device = [&](const void*, const DigestRange& range, int warps, int, std::uint64_t* out,
                             std::string& error) { return walk(*instance, fault, range, warps, out, error); };
  SelftestOptions options;
  options.lanes = 20;
  options.steps = 10;
  options.threads = 2;
  options.quiet = true;
  // Tests run at the same time, each in a process of its own.
  const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  options.json_file = ::testing::TempDir() + "selftest_" + name + ".jsonl";
  Found found{selftest(model, *instance, options), {}};
  std::ifstream lines(options.json_file);
  for (std::string line; std::getline(lines, line);) found.lines.push_back(Json::parse(line));
  return found;
}

TEST(Selftest, ComparesStepsLeavesAndTreesOfAGpu) {
  const Found found = check(Fault::kNone);
  EXPECT_EQ(found.code, 0);
  std::set<std::string> checks;
  for (const Json& line : found.lines) {
    checks.insert(line["check"]);
    EXPECT_GT(line["steps"], 0) << line;
    EXPECT_EQ(line["differing"], 0) << line;
    EXPECT_EQ(line["remark"], "") << line;
  }
  EXPECT_EQ(checks, (std::set<std::string>{"schedule", "device 3", "leaves 3", "search 3"}));
}

TEST(Selftest, NamesTheFirstStepThatDiffers) {
  const Found found = check(Fault::kDigest);
  EXPECT_EQ(found.code, 1);
  EXPECT_EQ(found.of("device 3")["differing"], 1);
  EXPECT_EQ(found.of("device 3")["remark"], "first: lane 5, step 3 (--seed 0)");
  EXPECT_EQ(found.of("leaves 3")["differing"], 0);
}

TEST(Selftest, NamesTheLeafThatDiffers) {
  const Found found = check(Fault::kLeaf);
  EXPECT_EQ(found.code, 1);
  EXPECT_EQ(found.of("device 3")["differing"], 0);
  const std::string remark = found.of("leaves 3")["remark"];
  EXPECT_NE(remark.find("7 scenarios: leaf after action "), std::string::npos) << remark;
  EXPECT_NE(remark.find("ok and evaluator_failed"), std::string::npos) << remark;
  EXPECT_EQ(found.of("search 3")["remark"], "the trees of one of the first steps differ");
}

TEST(Selftest, SaysWhyNothingIsCompared) {
  const Found walks = check(Fault::kNoDigest), leaves = check(Fault::kNoEvaluator);
  EXPECT_EQ(walks.code, 1);
  EXPECT_EQ(walks.of("device 3")["remark"], "no memory");
  EXPECT_EQ(leaves.of("leaves 3")["remark"], "no memory");
  EXPECT_EQ(leaves.of("search 3")["remark"], "no memory");
}

TEST(Selftest, PrintsATable) {
  const VerifiableModel model = verifiable_tiger();
  const auto instance = instance_of(model);
  SelftestOptions options;
  options.lanes = 20;
  options.steps = 10;
  options.warps = 2;
  ::testing::internal::CaptureStdout();
  EXPECT_EQ(selftest(model, *instance, options), 0);
  const std::string table = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(table.find("schedule  2 warps                      200          0\n"), std::string::npos)
      << table;
  EXPECT_NE(table.find("left out: this program was built without CUDA"), std::string::npos) << table;
  options.json_file = "/nonexistent/folder/file";
  EXPECT_EQ(selftest(model, *instance, options), 1);
}

}  // namespace
}  // namespace hypgen::testing
