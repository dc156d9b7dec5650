#include "batch/results/shard_file.hpp"

#include <sys/mount.h>

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

TEST(ShardFile, ReturnsAppendedResults) {
  const TemporaryFolder run;
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

// A process may end at any byte: complete records stay, and new data overwrites the rest.
TEST(ShardFile, DropsTruncatedRecords) {
  const TemporaryFolder run;
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

/// A shard of three results with solutions.
void append_three(ShardFile& file) {
  file.append(result("aa", "converged", 1), "the first solution");
  file.append(result("bb", "converged", 2), "the second solution");
  file.append(result("cc", "converged", 3), "the third solution");
}

// After a power failure, a file may have its full length with zeros in place of recent writes.
TEST(ShardFile, DropsResultsWithUnsavedSolutions) {
  const TemporaryFolder run;
  const fs::path pack = run.path() / "shards/1of1.solutions";
  {
    ShardFile file(run.path(), {0, 1});
    append_three(file);
  }
  const std::string packed = read(pack);
  std::string torn = packed;
  torn.replace(torn.find("second"), 6, 6, '\0');
  std::ofstream(pack) << torn;
  const auto results = load_results(run.path());
  EXPECT_EQ(results.size(), 1u);
  EXPECT_TRUE(results.contains("aa"));
  {
    ShardFile file(run.path(), {0, 1});
    file.append(result("bb", "converged", 2), "the second solution");
    file.append(result("cc", "converged", 3), "the third solution");
  }
  EXPECT_EQ(load_results(run.path()).size(), 3u);
  EXPECT_EQ(read(pack), packed);
}

TEST(ShardFile, KeepsEverythingSyncedAtTheLastMark) {
  const TemporaryFolder run;
  const fs::path lines = run.path() / "shards/1of1.jsonl",
                 pack = run.path() / "shards/1of1.solutions";
  std::size_t synced = 0;
  {
    ShardFile file(run.path(), {0, 1});
    append_three(file);
    file.sync();
    synced = read(pack).size();
    const std::string marked = read(lines);
    file.sync();
    EXPECT_EQ(read(lines), marked) << "nothing new has nothing to wait for";
    file.append(result("dd", "converged", 4), "the fourth solution");
  }
  std::string torn = read(pack);
  torn.resize(synced);
  std::ofstream(pack) << torn;
  EXPECT_EQ(load_results(run.path()).size(), 3u);
  const std::string before = read(lines);
  { ShardFile file(run.path(), {0, 1}); }
  EXPECT_LT(read(lines).size(), before.size());
  EXPECT_EQ(load_results(run.path()).size(), 3u);
}

TEST(ShardFile, DoesNotReturnDamagedSolutions) {
  const TemporaryFolder run;
  const fs::path pack = run.path() / "shards/1of1.solutions";
  {
    ShardFile file(run.path(), {0, 1});
    append_three(file);
    file.sync();
  }
  std::string damaged = read(pack);
  damaged.replace(damaged.find("second"), 6, "SECOND");
  std::ofstream(pack) << damaged;
  const auto results = load_results(run.path());
  EXPECT_EQ(results.size(), 3u);
  EXPECT_EQ(load_solution(results.at("bb")), "");
  EXPECT_TRUE(load_document(results.at("bb")).is_null());
  EXPECT_EQ(load_solution(results.at("cc")), "the third solution");
}

TEST(ShardFile, TruncatedPackLosesOnlyResultsBeyondItsEnd) {
  const TemporaryFolder run;
  const fs::path pack = run.path() / "shards/1of1.solutions";
  {
    ShardFile file(run.path(), {0, 1});
    append_three(file);
    file.sync();
  }
  const std::string packed = read(pack);
  fs::resize_file(pack, packed.find("the third"));
  EXPECT_EQ(load_results(run.path()).size(), 2u);
  fs::remove(pack);
  EXPECT_TRUE(load_results(run.path()).empty());
  {
    ShardFile file(run.path(), {0, 1});
    append_three(file);
  }
  EXPECT_EQ(load_results(run.path()).size(), 3u);
  EXPECT_EQ(read(pack), packed);
}

TEST(FailedItems, IncludeItemsWithDamagedSolutions) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2, 3]}}\n");
  {
    ShardFile file(batch.folder.path(), {0, 1});
    for (const ManifestItem& item : batch.manifest->items)
      file.append(result(item.id, "converged", 1), "solution " + item.id);
    file.sync();
  }
  const fs::path pack = batch.folder.path() / "shards/1of1.solutions";
  std::string bytes = read(pack);
  bytes[bytes.find(batch.manifest->items[1].id)] = '?';
  std::ofstream(pack) << bytes;
  const auto results = load_results(batch.folder.path());
  EXPECT_EQ(failed_items(*batch.manifest, results, FailureKind::kAny), std::vector<std::size_t>{1});
  EXPECT_TRUE(failed_items(*batch.manifest, results, FailureKind::kTimeout).empty());
}

/// A fixed-size file system mounted on a folder while the object exists.
class SmallDisk {
 public:
  SmallDisk(const fs::path& folder, const char* size)
      : folder_(folder), is_there_(::mount("tmpfs", folder.c_str(), "tmpfs", 0, size) == 0) {}
  ~SmallDisk() {
    if (is_there_) ::umount(folder_.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool is_there() const { return is_there_; }
  void grow() const { ::mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, "size=8m"); }

 private:
  const fs::path folder_;
  const bool is_there_;
};

TEST(ShardFile, FullDiskIsAnErrorWithoutLoss) {
  const TemporaryFolder run;
  const SmallDisk disk(run.path(), "size=256k");
  if (!disk.is_there()) GTEST_SKIP() << "no file system can be mounted here";
  const std::string solution(40'000, 's');
  const auto name = [](int i) { return "item" + std::to_string(i); };
  int stored = 0;
  try {
    ShardFile file(run.path(), {0, 1});
    for (;; ++stored) file.append(result(name(stored), "converged", 1), solution);
  } catch (const OutputError& error) {
    EXPECT_NE(std::string(error.what()).find("cannot be written: No space left"), std::string::npos)
        << error.what();
  }
  EXPECT_GE(stored, 4);
  EXPECT_EQ(load_results(run.path()).size(), static_cast<std::size_t>(stored));
  disk.grow();
  {
    ShardFile file(run.path(), {0, 1});
    for (int i = stored; i < 20; ++i) file.append(result(name(i), "converged", 1), solution);
    file.sync();
  }
  const auto results = load_results(run.path());
  ASSERT_EQ(results.size(), 20u);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(load_solution(results.at(name(i))), solution) << i;
}

TEST(ShardFile, RejectsLinesWithWrongChecksums) {
  const TemporaryFolder run;
  { ShardFile(run.path(), {0, 1}).append(result("aa", "converged", 1), ""); }
  std::string text = read(run.path() / "shards/1of1.jsonl");
  text[text.find("converged")] = 'C';
  run.write("shards/1of1.jsonl", text);
  EXPECT_TRUE(load_results(run.path()).empty());
}

TEST(ShardFile, OnlyOneProcessHasAShard) {
  const TemporaryFolder run;
  const ShardFile first(run.path(), {1, 3});
  EXPECT_NO_THROW(ShardFile(run.path(), {2, 3}));
  EXPECT_THROW(ShardFile(run.path(), {1, 3}), OutputError);
}

TEST(ShardFile, SolvedAttemptsWinThenTheLatest) {
  const TemporaryFolder run;
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
  EXPECT_EQ(times_csv(*batch.manifest, results),
            "item,id,attempt,build [s],solve [s],certificate [s],all [s]\n1," + id(0) +
                ",1,,,,0.5\n3," + id(2) + ",1,,,,0.5\n");
  const BatchStatus status = batch_status(*batch.manifest, results);
  EXPECT_EQ(status.solved, 1u);
  EXPECT_EQ(status.unfinished, 1u);
  EXPECT_EQ(status.by_status.at("diverged"), 1u);
  EXPECT_EQ(failed_items(*batch.manifest, results, FailureKind::kAny), std::vector<std::size_t>{0});
  EXPECT_TRUE(failed_items(*batch.manifest, results, FailureKind::kTimeout).empty());
}

}  // namespace
}  // namespace conddp
