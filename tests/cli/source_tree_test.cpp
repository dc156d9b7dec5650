// scripts/conddp in a separate tree, where a build appends a line to a file.
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
    age();
  }

  std::string write(const std::string& name, const std::string& text) {
    return tree_.write(name, text);
  }
  void set_age(const fs::path& path, int seconds) const {
    const timespec then{time(nullptr) - seconds, 0}, both[2] = {then, then};
    utimensat(AT_FDCWD, path.c_str(), both, AT_SYMLINK_NOFOLLOW);
  }
  /// Makes all sources of the tool older than its last build.
  void age() const {
    for (const auto& entry : fs::recursive_directory_iterator(tree_.path()))
      if (entry.path().filename() != "conddp.built") set_age(entry.path(), kHour);
  }
  /// Changes a file or folder after the last build.
  void change(const std::string& name) const { set_age(tree_.path() / name, -kHour); }
  /// Number of builds by `scripts/conddp --version`; -1 on failure.
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
  static constexpr int kHour = 3600;  // s
  void script(const std::string& name, const std::string& text) {
    fs::permissions(write(name, "#!/bin/sh\n" + text + "\n"), fs::perms::owner_all);
  }
};

TEST_F(SourceTree, UnchangedTreeIsNotScannedTwice) {
  EXPECT_EQ(builds(), 1);
  EXPECT_EQ(builds(), 0);
}

TEST_F(SourceTree, ChangedAddedAndRemovedSourcesAreBuilt) {
  EXPECT_EQ(builds(), 1);
  change("src/base/a.cpp");
  EXPECT_EQ(builds(), 1);
  change("apps");  // as a new file does
  EXPECT_EQ(builds(), 1);
  fs::remove(tree_.path() / "src/base/a.cpp");
  change("src/base");
  EXPECT_EQ(builds(), 1);
  EXPECT_EQ(builds(), 0);
}

TEST_F(SourceTree, RetriesAFailedBuild) {
  write("broken", "");
  EXPECT_EQ(builds(), -1);
  EXPECT_EQ(builds(), -1);
  fs::remove(tree_.path() / "broken");
  EXPECT_EQ(builds(), 1);
  EXPECT_EQ(builds(), 0);
}

}  // namespace
}  // namespace conddp
