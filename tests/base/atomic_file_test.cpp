#include "base/files/atomic_file.hpp"

#include <csignal>
#include <fstream>

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

class AtomicFile : public testing::Test {
 protected:
  std::string read(const std::string& name) const {
    std::ifstream stream(folder_ / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  long count() const { return std::distance(std::filesystem::directory_iterator(folder_), {}); }
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
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

TEST_F(AtomicFile, NothingRemainsWithoutCommit) {
  std::ofstream(folder_ / "a") << "former";
  {
    AtomicFiles files;
    files.add(folder_ / "a", "new");
  }
  EXPECT_EQ(read("a"), "former");
  EXPECT_EQ(count(), 1);
}

TEST_F(AtomicFile, SignalsWaitForCompleteFiles) {
  for (const bool commits : {true, false}) {
    const std::string name = commits ? "a" : "b";
    const pid_t child = ::fork();
    if (child == 0) {
      AtomicFiles files;
      files.add(folder_ / name, "whole");
      ::kill(::getpid(), SIGTERM);
      if (commits)
        files.commit();
      else
        files.~AtomicFiles();
      ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status)) << name;
  }
  EXPECT_EQ(read("a"), "whole");
  EXPECT_EQ(count(), 1);
}

TEST_F(AtomicFile, LaterFailureKeepsEarlierFiles) {
  std::ofstream(folder_ / "a") << "former";
  std::filesystem::create_directory(folder_ / "b");
  AtomicFiles files;
  files.add(folder_ / "a", "new");
  EXPECT_THROW(files.add(folder_ / "b", "folder"), OutputError);
  EXPECT_THROW(files.add(folder_ / "c/d", "nowhere"), OutputError);
  EXPECT_EQ(read("a"), "former");
}

TEST_F(AtomicFile, FailedRenameRestoresTheOthers) {
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

TEST_F(AtomicFile, RemovesLeftoversOfDeadProcessesOnly) {
  std::ofstream(folder_ / ".a.new.1.tmp") << "half";
  std::ofstream(folder_ / ".b.new.1.tmp") << "half, of another file";
  AtomicFiles living;
  living.add(folder_ / "b", "one");
  EXPECT_EQ(count(), 2);  // .a.new.1.tmp and the file of `living`
  AtomicFiles files;
  files.add(folder_ / "a", "two");
  files.commit();
  EXPECT_EQ(count(), 2);
  living.commit();
  EXPECT_EQ(read("a"), "two");
  EXPECT_EQ(read("b"), "one");
  EXPECT_EQ(count(), 2);
}

TEST_F(AtomicFile, IgnoresPipesNamedLikeLeftovers) {
  ASSERT_EQ(mkfifo((folder_ / ".a.new.1.tmp").c_str(), 0600), 0);
  AtomicFiles files;
  files.add(folder_ / "a", "one");  // does not wait for a writer
  files.commit();
  EXPECT_EQ(read("a"), "one");
  EXPECT_TRUE(std::filesystem::is_fifo(folder_ / ".a.new.1.tmp"));
}

TEST_F(AtomicFile, ReplacesRegularFilesOnly) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  (folder_ / "socket").string().copy(address.sun_path, sizeof(address.sun_path) - 1);
  ASSERT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  ::close(socket);
  std::filesystem::create_symlink("pipe", folder_ / "link");
  std::filesystem::create_symlink("circle", folder_ / "circle");
  AtomicFiles files;
  for (const char* name : {"pipe", "socket", "link", "circle"})
    EXPECT_THROW(files.add(folder_ / name, "new"), OutputError) << name;
  files.commit();
  EXPECT_TRUE(std::filesystem::is_fifo(folder_ / "pipe"));
  EXPECT_TRUE(std::filesystem::is_socket(folder_ / "socket"));
  EXPECT_EQ(count(), 4);
}

TEST_F(AtomicFile, KeepsALinkAndWritesItsTarget) {
  std::filesystem::create_directory(folder_ / "far");
  std::ofstream(folder_ / "far/target") << "former";
  std::filesystem::create_symlink("far/target", folder_ / "link");
  std::filesystem::create_symlink("link", folder_ / "second");
  std::filesystem::create_symlink("far/absent", folder_ / "dangling");
  {
    AtomicFiles dropped;
    dropped.add(folder_ / "second", "dropped");
  }
  EXPECT_EQ(read("far/target"), "former");
  AtomicFiles files;
  files.add(folder_ / "second", "new");
  files.add(folder_ / "dangling", "fresh");
  files.commit();
  EXPECT_EQ(read("far/target"), "new");
  EXPECT_EQ(read("far/absent"), "fresh");
  for (const char* name : {"link", "second", "dangling"})
    EXPECT_TRUE(std::filesystem::is_symlink(folder_ / name)) << name;
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "far"), {}), 2);
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
