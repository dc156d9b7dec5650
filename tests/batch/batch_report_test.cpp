#include "batch/results/batch_report.hpp"

#include "batch/plan/spread.hpp"
#include "batch_folder.hpp"

namespace conddp {
namespace {

/// Six items: the third failed and the last has no result. Costs fall, times rise.
class BatchReport : public testing::Test {
 protected:
  BatchReport()
      : batch_(R"(vary:
  w: {key: costs.effort.weight, values: [1, 2, 3]}
solvers: [ilqr, ddp]
)") {
    ShardFile file(batch_.folder.path(), {0, 1});
    for (int i = 0; i < 5; ++i) file.append(result(i), i == 2 ? "" : packed_document(solution(i)));
  }
  ItemResult result(int i) const {
    return {.id = manifest().items[i].id,
            .status = i == 2 ? "diverged" : "converged",
            .success = i != 2,
            .answer = {{"solver", "ilqr"},
                       {"message", "that is how it ended"},
                       {"cost", 10 - i},
                       {"iterations", 3 + i}},
            .times = {{"all", 0.1 * (i + 1)}}};
  }
  static OrderedJson solution(int i) {
    const std::vector<double> here = {0.1 * i, 1}, there = {0.2, 1.0 / 3};
    return {{"trajectory",
             {{"columns", {{"x", {"theta", "omega"}}}},
              {"units", {{"x", {"rad", "rad/s"}}}},
              {"t", {0.0, 0.5}},
              {"x", {here, there}}}}};
  }
  const Manifest& manifest() const { return *batch_.manifest; }
  StoredResults results() const { return load_results(batch_.folder.path()); }
  OrderedJson report() const {
    const auto lists = items_that_stand_out(manifest(), results(), 2);
    return batch_report(manifest(), results(), lists, {{1, {"items/1/problem.yaml"}}});
  }

  PlannedBatch batch_;
};

TEST_F(BatchReport, CountsItemsByStatus) {
  const OrderedJson data = report();
  EXPECT_EQ(data["items"], 6);
  EXPECT_EQ(data["solved"], 4);
  const OrderedJson counts = {{{"status", "converged"}, {"count", 4}},
                              {{"status", "diverged"}, {"count", 1}},
                              {{"status", "unfinished"}, {"count", 1}}};
  EXPECT_EQ(data["by_status"], counts);
}

TEST_F(BatchReport, HasARowWithDistinguishingValuesPerItem) {
  const OrderedJson data = report();
  EXPECT_EQ(data["columns"][0]["name"], "w");
  EXPECT_EQ(data["columns"][1]["name"], "solver");
  const OrderedJson& rows = data["rows"];
  EXPECT_EQ(rows["values"][0], OrderedJson({1, 1, 2, 2, 3, 3}));
  EXPECT_EQ(rows["values"][1], OrderedJson({"ilqr", "ddp", "ilqr", "ddp", "ilqr", "ddp"}));
  EXPECT_EQ(rows["solved"], OrderedJson({1, 1, 0, 1, 1, nullptr}));  // no result for the last item
  EXPECT_EQ(rows["cost"], OrderedJson({10, 9, 8, 7, 6, nullptr}));
  EXPECT_TRUE(rows["wall_s"][5].is_null());
}

TEST_F(BatchReport, NamesOutliersWorstFirst) {
  const auto lists = items_that_stand_out(manifest(), results(), 2);
  ASSERT_EQ(lists.size(), 4u);
  EXPECT_EQ(lists[0].items, std::vector<std::size_t>{2});       // not solved
  EXPECT_EQ(lists[1].items, (std::vector<std::size_t>{4, 3}));  // slowest
  EXPECT_EQ(lists[2].items, (std::vector<std::size_t>{4, 3}));  // lowest cost
  EXPECT_EQ(lists[3].items, (std::vector<std::size_t>{0, 1}));  // highest cost
  const OrderedJson greatest = report()["lists"][3]["items"];
  EXPECT_EQ(greatest[1]["id"], manifest().items[1].id);
  EXPECT_EQ(greatest[1]["values"], OrderedJson({1, "ddp"}));
  EXPECT_EQ(greatest[1]["files"], OrderedJson({"items/1/problem.yaml"}));
  EXPECT_TRUE(greatest[0]["files"].empty());
}

TEST_F(BatchReport, ExplainsUnsolvedItems) {
  const OrderedJson lists = report()["lists"];
  EXPECT_EQ(lists[0]["items"][0]["message"], "that is how it ended");
  EXPECT_TRUE(lists[1]["items"][0]["message"].is_null());
}

TEST_F(BatchReport, HasTheLastNodeOfATrajectory) {
  OrderedJson document = solution(0);
  OrderedJson t = OrderedJson::array(), x = OrderedJson::array();
  for (int k = 0; k <= 205; ++k) {
    t.push_back(k);
    x.push_back({0.0, 0.0});
  }
  document["trajectory"]["t"] = t;
  document["trajectory"]["x"] = x;
  ItemResult longer = result(0);
  longer.attempt = 2;
  ShardFile(batch_.folder.path(), {1, 2}).append(longer, packed_document(document));
  const OrderedJson times = report()["trajectories"]["lines"][0]["t"];
  EXPECT_EQ(times.back(), 205);
  EXPECT_EQ(times[times.size() - 2], 204);
}

TEST_F(BatchReport, HasTrajectoriesOfEverySolver) {
  PlannedBatch batch(R"(vary:
  w: {key: costs.effort.weight, linspace: [1, 2, 100]}
solvers: [ilqr, ddp]
)");
  {
    ShardFile file(batch.folder.path(), {0, 1});
    for (int i = 0; i < 200; ++i) {
      ItemResult solved = result(0);
      solved.id = batch.manifest->items[i].id;
      file.append(solved, packed_document(solution(0)));
    }
  }
  int lines = 0, odd = 0;
  const OrderedJson data = batch_report(*batch.manifest, load_results(batch.folder.path()), {}, {});
  for (const OrderedJson& line : data["trajectories"]["lines"]) {
    ++lines;
    odd += line["item"].get<int>() % 2;
  }
  EXPECT_EQ(lines, 60);
  EXPECT_NEAR(odd, 30, 2);
}

TEST(Spread, ListsNumbersInOrderAndShortListsWhole) {
  EXPECT_EQ(spread_over(5, 9), (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(spread_over(0, 3), std::vector<std::size_t>{});
  EXPECT_EQ(spread_over(1, 1), std::vector<std::size_t>{0});
}

TEST(Spread, MeetsEveryRemainderAndEveryPart) {
  for (const std::size_t count : {40u, 100u, 1000u, 20'001u})
    for (const std::size_t period : {2u, 3u, 4u, 5u}) {
      const std::vector<std::size_t> numbers = spread_over(count, 20);
      ASSERT_EQ(numbers.size(), 20u);
      std::vector<int> remainders(period), parts(4);
      for (const std::size_t number : numbers) {
        ++remainders[number % period];
        ++parts[4 * number / count];
      }
      for (const int hits : remainders) EXPECT_GE(hits, 1) << count << ' ' << period;
      for (const int hits : parts) EXPECT_NEAR(hits, 5, 2) << count;
    }
}

TEST_F(BatchReport, HasTheStoredTrajectories) {
  const OrderedJson trajectories = report()["trajectories"];
  EXPECT_EQ(trajectories["columns"], OrderedJson({"theta", "omega"}));
  const OrderedJson& lines = trajectories["lines"];
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2]["item"], 4);
  EXPECT_EQ(lines[2]["cost"], 7);
  EXPECT_EQ(lines[2]["t"], OrderedJson({0.0, 0.5}));
  EXPECT_EQ(lines[2]["values"][0], OrderedJson({0.3, 0.2}));
  EXPECT_EQ(lines[2]["values"][1], OrderedJson({1.0, 0.33333333}));
}

TEST(EmptyBatchReport, HasOnlyCountsWithoutResults) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  const OrderedJson data =
      batch_report(*batch.manifest, {}, items_that_stand_out(*batch.manifest, {}, 5), {});
  EXPECT_EQ(data["by_status"][0]["count"], 2);
  EXPECT_TRUE(data["trajectories"].is_null());
  for (const OrderedJson& list : data["lists"]) EXPECT_TRUE(list["items"].empty());
}

}  // namespace
}  // namespace conddp
