#include "output/bench/gnuplot.hpp"

#include <array>
#include <cstdio>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace conddp {
namespace {

/// A file in memory, which leaves nothing behind if the process ends early.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& contents) : descriptor_(::memfd_create("script", 0)) {
    const ssize_t size = static_cast<ssize_t>(contents.size());
    written_ = descriptor_ >= 0 && ::write(descriptor_, contents.data(), contents.size()) == size;
  }
  ~MemoryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  bool written() const { return written_; }
  /// Path through which a child process opens the file.
  std::string name() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
  bool written_ = false;
};

}  // namespace

GnuplotResult run_gnuplot(const std::string& script) {
  const MemoryFile file(script);
  if (!file.written()) return {{}, "a file in memory for gnuplot cannot be written"};
  FILE* pipe = ::popen(("gnuplot " + file.name() + " 2>/dev/null").c_str(), "r");
  if (pipe == nullptr) return {{}, "gnuplot cannot be started"};
  GnuplotResult result;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    result.output.append(buffer.data(), n);
  const int status = ::pclose(pipe);
  constexpr int kNotFound = 127;  // exit code of the shell
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound)
    return {{}, "gnuplot is not installed (Debian: gnuplot-nox)"};
  if (status != 0 || result.output.empty()) return {{}, "gnuplot failed"};
  return result;
}

}  // namespace conddp
