#include "output/bench/gnuplot.hpp"

#include <array>
#include <cstdio>
#include <filesystem>

#include <sys/wait.h>
#include <unistd.h>

namespace conddp {
namespace {

/// A file for the time of a call.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& contents) {
    std::error_code error;
    name_ = (std::filesystem::temp_directory_path(error) / "conddp_plot_XXXXXX").string();
    const int descriptor = ::mkstemp(name_.data());
    if (descriptor < 0) return;
    FILE* file = ::fdopen(descriptor, "w");
    written_ = std::fwrite(contents.data(), 1, contents.size(), file) == contents.size();
    written_ = std::fclose(file) == 0 && written_;
  }
  ~TemporaryFile() { std::remove(name_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  bool written() const { return written_; }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  bool written_ = false;
};

}  // namespace

GnuplotResult run_gnuplot(const std::string& script) {
  const TemporaryFile file(script);
  if (!file.written()) return {{}, "a temporary file for gnuplot cannot be written"};
  FILE* pipe = ::popen(("gnuplot '" + file.name() + "' 2>/dev/null").c_str(), "r");
  if (pipe == nullptr) return {{}, "gnuplot cannot be started"};
  GnuplotResult result;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    result.output.append(buffer.data(), n);
  const int status = ::pclose(pipe);
  constexpr int kNotFound = 127;  // of the shell
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound)
    return {{}, "gnuplot is not installed (Debian: gnuplot-nox)"};
  if (status != 0 || result.output.empty()) return {{}, "gnuplot failed"};
  return result;
}

}  // namespace conddp
