#include "output/atomic_file.hpp"

#include <fstream>

#include <unistd.h>

#include <gtest/gtest.h>

namespace conddp {
namespace {

class AtomicFile : public testing::Test {
 protected:
  AtomicFile() {
    char name[] = "/tmp/conddp_atomic_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~AtomicFile() override { std::filesystem::remove_all(folder_); }
  std::string read(const std::string& name) const {
    std::ifstream stream(folder_ / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  long count() const { return std::distance(std::filesystem::directory_iterator(folder_), {}); }
  std::filesystem::path folder_;
};

TEST_F(AtomicFile, FilesAppearOnCommit) {
  AtomicFiles files;
  files.add(folder_ / "a", "one");
  files.add(folder_ / "b", "two");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a"));
  files.commit();
  EXPECT_EQ(read("a"), "one");
  EXPECT_EQ(read("b"), "two");
  EXPECT_EQ(count(), 2);
}

TEST_F(AtomicFile, NothingStaysWithoutCommit) {
  std::ofstream(folder_ / "a") << "former";
  {
    AtomicFiles files;
    files.add(folder_ / "a", "new");
  }
  EXPECT_EQ(read("a"), "former");
  EXPECT_EQ(count(), 1);
}

TEST_F(AtomicFile, ALaterFailureLeavesEarlierFilesAsTheyWere) {
  std::ofstream(folder_ / "a") << "former";
  std::filesystem::create_directory(folder_ / "b");
  AtomicFiles files;
  files.add(folder_ / "a", "new");
  EXPECT_THROW(files.add(folder_ / "b", "folder"), OutputError);
  EXPECT_THROW(files.add(folder_ / "c/d", "nowhere"), OutputError);
  EXPECT_EQ(read("a"), "former");
}

TEST_F(AtomicFile, AFailureWhileRenamingTakesTheOthersBack) {
  std::ofstream(folder_ / "b") << "former";
  AtomicFiles files;
  files.add(folder_ / "a", "new");  // renamed last
  files.add(folder_ / "b", "new");
  files.add(folder_ / "c", "new");
  std::filesystem::create_directory(folder_ / "a");
  std::ofstream(folder_ / "a" / "in the way");
  EXPECT_THROW(files.commit(), OutputError);
  EXPECT_EQ(read("b"), "former");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c"));
}

TEST_F(AtomicFile, LeftoversOfTheDeadAreRemovedAndOfTheLivingKept) {
  std::ofstream(folder_ / ".a.new.1.tmp") << "half";
  std::ofstream(folder_ / ".b.new.1.tmp") << "half, of another file";
  AtomicFiles living;
  living.add(folder_ / "b", "one");
  EXPECT_EQ(count(), 2);  // .a.new.1.tmp and the one of `living`
  AtomicFiles files;
  files.add(folder_ / "a", "two");
  files.commit();
  EXPECT_EQ(count(), 2);
  living.commit();
  EXPECT_EQ(read("a"), "two");
  EXPECT_EQ(read("b"), "one");
  EXPECT_EQ(count(), 2);
}

TEST_F(AtomicFile, ErrorsNameTheFile) {
  AtomicFiles files;
  try {
    files.add(folder_ / "absent/file.json", "");
    FAIL();
  } catch (const OutputError& e) {
    EXPECT_EQ(e.what(), "'" + (folder_ / "absent/file.json").string() +
                            "' cannot be written: No such file or directory");
  }
  std::ofstream(folder_ / "file") << "";
  EXPECT_THROW(create_folder(folder_ / "file"), OutputError);
  EXPECT_THROW(create_folder(folder_ / "file" / "below"), OutputError);
  create_folder(folder_ / "x" / "y");
  EXPECT_TRUE(std::filesystem::is_directory(folder_ / "x" / "y"));
}

}  // namespace
}  // namespace conddp
