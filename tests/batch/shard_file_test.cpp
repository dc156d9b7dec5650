#include "batch/results/shard_file.hpp"

#include "base/files/atomic_file.hpp"
#include "batch/results/collect.hpp"
#include "batch_folder.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

ItemResult result(const std::string& id, const std::string& status, double cost) {
  return {.id = id,
          .status = status,
          .success = status == "converged",
          .answer = {{"solver", "ilqr"}, {"message", "a, \"b\""}, {"cost", cost}},
          .times = {{"all", 0.5}}};
}

std::string read(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(ShardFile, GivesBackWhatWasAppended) {
  const BatchFolder run;
  {
    ShardFile file(run.path(), {0, 1});
    file.append(result("aa", "converged", 1.5), "first\n");
    file.append(result("bb", "diverged", 2), "");
    file.append(result("cc", "converged", 3), "third\n");
  }
  const auto results = load_results(run.path());
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results.at("aa").result.answer["cost"], 1.5);
  EXPECT_EQ(load_solution(results.at("aa")), "first\n");
  EXPECT_EQ(load_solution(results.at("bb")), "");
  EXPECT_EQ(load_solution(results.at("cc")), "third\n");
  EXPECT_FALSE(results.at("bb").result.success);
}

// A process may end at any byte: what is whole stays, and what follows is written over the rest.
TEST(ShardFile, DropsWhatWasCutOffAtAnyByte) {
  const BatchFolder run;
  const fs::path lines = run.path() / "shards/1of1.jsonl",
                 pack = run.path() / "shards/1of1.solutions";
  {
    ShardFile file(run.path(), {0, 1});
    file.append(result("aa", "converged", 1), "first\n");
    file.append(result("bb", "converged", 2), "second\n");
  }
  const std::string all = read(lines), packed = read(pack);
  const std::size_t first = all.find('\n') + 1;
  for (std::size_t cut = first; cut < all.size(); ++cut) {
    std::ofstream(lines) << all.substr(0, cut);
    std::ofstream(pack) << packed;
    EXPECT_EQ(load_results(run.path()).size(), 1u) << cut;
    {
      ShardFile file(run.path(), {0, 1});
      file.append(result("bb", "converged", 2), "second\n");
    }
    EXPECT_EQ(read(lines), all) << cut;
    EXPECT_EQ(read(pack), packed) << cut;
  }
}

TEST(ShardFile, DoesNotTrustALineWhoseSumIsWrong) {
  const BatchFolder run;
  { ShardFile(run.path(), {0, 1}).append(result("aa", "converged", 1), ""); }
  std::string text = read(run.path() / "shards/1of1.jsonl");
  text[text.find("converged")] = 'C';
  run.write("shards/1of1.jsonl", text);
  EXPECT_TRUE(load_results(run.path()).empty());
}

TEST(ShardFile, OneProcessAtATimeHasAShard) {
  const BatchFolder run;
  const ShardFile first(run.path(), {1, 3});
  EXPECT_NO_THROW(ShardFile(run.path(), {2, 3}));
  EXPECT_THROW(ShardFile(run.path(), {1, 3}), OutputError);
}

TEST(ShardFile, ASolvedItemCountsBeforeAFailedOneAndTheLastAttemptBeforeOthers) {
  const BatchFolder run;
  ItemResult second = result("bb", "max_iterations", 7);
  second.attempt = 2;
  {
    ShardFile(run.path(), {0, 1}).append(result("aa", "converged", 1), "");
    ShardFile(run.path(), {0, 1}).append(result("bb", "diverged", 5), "");
    ShardFile(run.path(), {1, 2}).append(result("aa", "time_limit", 4), "");
    ShardFile(run.path(), {1, 2}).append(second, "");
  }
  const auto results = load_results(run.path());
  EXPECT_EQ(results.at("aa").result.status, "converged");
  EXPECT_EQ(results.at("bb").result.status, "max_iterations");
}

TEST(Collect, HasARowForEveryItemWithoutTimes) {
  PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2, 3]}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  const auto id = [&](int i) { return batch.manifest->items[i].id; };
  {
    ShardFile file(batch.folder.path(), {0, 1});
    ItemResult solved = result(id(2), "converged", 0.1);
    solved.answer["iterations"] = 4;
    solved.answer["residuals"] = {{"stationarity", 1e-7}, {"gap", nullptr}};
    solved.answer["constraints"] = {{{"name", "torque"}, {"violation", 0.25}, {"node", 1}}};
    solved.answer["certificate"] = "holds";
    file.append(solved, "");
    file.append(result(id(0), "diverged", 2), "");
  }
  const auto results = load_results(batch.folder.path());
  EXPECT_EQ(results_csv(*batch.manifest, results),
            "item,id,problem,w,solver,status,solved,cost,iterations,stationarity,gap,constraint,"
            "complementarity,violation/torque,certificate,message\n"
            "1," +
                id(0) +
                ",../swing.yaml,1,ilqr,diverged,0,2.0,,,,,,,,\"a, \"\"b\"\"\"\n"
                "2," +
                id(1) +
                ",../swing.yaml,2,,unfinished,,,,,,,,,,\n"
                "3," +
                id(2) +
                ",../swing.yaml,3,ilqr,converged,1,0.1,4,1e-07,,,,0.25,holds,"
                "\"a, \"\"b\"\"\"\n");
  EXPECT_EQ(times_csv(*batch.manifest, results), "item,id,attempt,build [s],solve [s],all [s]\n1," +
                                                     id(0) + ",1,,,0.5\n3," + id(2) + ",1,,,0.5\n");
  const BatchStatus status = batch_status(*batch.manifest, results);
  EXPECT_EQ(status.solved, 1u);
  EXPECT_EQ(status.unfinished, 1u);
  EXPECT_EQ(status.by_status.at("diverged"), 1u);
  EXPECT_EQ(failed_items(*batch.manifest, results, FailureKind::kAny), std::vector<std::size_t>{0});
  EXPECT_TRUE(failed_items(*batch.manifest, results, FailureKind::kTimeout).empty());
}

}  // namespace
}  // namespace conddp
