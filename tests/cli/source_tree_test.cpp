// scripts/conddp in a tree of its own, in which building is a line in a file.
#include <cstdlib>
#include <ctime>
#include <filesystem>

#include <fcntl.h>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "process.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

class SourceTree : public ::testing::Test {
 protected:
  SourceTree() {
    for (const char* folder :
         {"scripts", "cmake", "src/base", "apps", "schemas", "build/release/bin"})
      fs::create_directories(tree_.path() / folder);
    fs::copy_file(source("scripts/conddp"), tree_.path() / "scripts/conddp");
    write("CMakeLists.txt", "");
    write("CMakePresets.json", "");
    write("src/base/a.cpp", "");
    script("scripts/setup", "true");
    script("scripts/build", "echo built >> builds; test ! -e broken");
    script("build/release/bin/conddp", "echo \"$@\"");
  }

  std::string write(const std::string& name, const std::string& text) {
    return tree_.write(name, text);
  }
  /// Makes everything an hour old, so that what is written next is newer.
  void age() {
    const timespec hour_ago{time(nullptr) - 3600, 0}, both[2] = {hour_ago, hour_ago};
    for (const auto& entry : fs::recursive_directory_iterator(tree_.path()))
      utimensat(AT_FDCWD, entry.path().c_str(), both, AT_SYMLINK_NOFOLLOW);
  }
  /// Whether `scripts/conddp --version` builds; -1 where it fails.
  int builds() {
    fs::remove(tree_.path() / "builds");
    const std::string command = "cd " + tree_.path().string() + " && scripts/conddp --version >out";
    if (std::system(command.c_str()) != 0) return -1;
    EXPECT_EQ(read_file(tree_.path() / "out"), "--version\n");
    age();
    return fs::exists(tree_.path() / "builds");
  }

  const TemporaryFolder tree_;

 private:
  void script(const std::string& name, const std::string& text) {
    fs::permissions(write(name, "#!/bin/sh\n" + text + "\n"), fs::perms::owner_all);
  }
};

TEST_F(SourceTree, NothingIsLookedAtTwiceWhereNothingHasChanged) {
  EXPECT_EQ(builds(), 1);
  EXPECT_EQ(builds(), 0);
}

TEST_F(SourceTree, ChangedAddedAndRemovedSourcesAreBuilt) {
  EXPECT_EQ(builds(), 1);
  write("src/base/a.cpp", "changed");
  EXPECT_EQ(builds(), 1);
  write("apps/new.cpp", "");
  EXPECT_EQ(builds(), 1);
  fs::remove(tree_.path() / "src/base/a.cpp");
  EXPECT_EQ(builds(), 1);
  EXPECT_EQ(builds(), 0);
}

TEST_F(SourceTree, ABuildThatFailsIsTriedAgain) {
  write("broken", "");
  EXPECT_EQ(builds(), -1);
  EXPECT_EQ(builds(), -1);
  fs::remove(tree_.path() / "broken");
  EXPECT_EQ(builds(), 1);
  EXPECT_EQ(builds(), 0);
}

}  // namespace
}  // namespace conddp
