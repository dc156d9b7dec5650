#include "process.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace conddp {
namespace {

struct Pipe {
  int read = -1;
  int write = -1;
};

Pipe open_pipe(bool terminal) {
  int ends[2];
  if (terminal) {
    winsize size{};
    size.ws_row = 40;
    size.ws_col = 120;
    if (openpty(&ends[0], &ends[1], nullptr, nullptr, &size) != 0)
      throw std::runtime_error("no pseudo-terminal");
  } else if (pipe(ends) != 0) {
    throw std::runtime_error("no pipe");
  }
  return {ends[0], ends[1]};
}

[[noreturn]] void become_conddp(const std::vector<std::string>& arguments,
                                const ProcessOptions& options, int out, int err) {
  dup2(out, 1);
  dup2(err, 2);
  for (int number = 3; number < 256; ++number) close(number);
  if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) _exit(120);
  if (options.limit_file_size >= 0) {
    const rlimit limit{static_cast<rlim_t>(options.limit_file_size),
                       static_cast<rlim_t>(options.limit_file_size)};
    setrlimit(RLIMIT_FSIZE, &limit);
    signal(SIGXFSZ, SIG_IGN);  // writing fails instead
  }
  const auto limit = [](auto resource, long value) {
    const rlimit both{static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
    if (value > 0) setrlimit(resource, &both);
  };
  limit(RLIMIT_CPU, options.limits.processor_s);
  limit(RLIMIT_AS, options.limits.memory_bytes);
  for (const std::string& entry : options.environment) {
    const std::size_t equals = entry.find('=');
    setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
  }
  std::vector<char*> argv{const_cast<char*>(CONDDP_BINARY)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(CONDDP_BINARY, argv.data());
  _exit(121);
}

/// Reads both streams to their ends.
void collect(pid_t child, int out, int err, const ProcessOptions& options, ProcessResult& result) {
  pollfd streams[2] = {{out, POLLIN, 0}, {err, POLLIN, 0}};
  std::string* const texts[2] = {&result.out, &result.err};
  bool signalled = options.signal == 0;
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    if (poll(streams, 2, 60'000) <= 0) {
      kill(child, SIGKILL);
      return;
    }
    for (int i = 0; i < 2; ++i) {
      if (streams[i].fd < 0 || streams[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t n = read(streams[i].fd, buffer, sizeof buffer);
      if (n <= 0)
        streams[i].fd = -1;
      else
        texts[i]->append(buffer, static_cast<std::size_t>(n));
    }
    if (!signalled && result.err.find(options.signal_after) != std::string::npos) {
      kill(child, options.signal);
      signalled = true;
    }
  }
}

}  // namespace

ProcessResult run_conddp(const std::vector<std::string>& arguments, const ProcessOptions& options) {
  const Pipe out = open_pipe(options.terminal);
  const Pipe err = options.terminal ? Pipe{-1, out.write} : open_pipe(false);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) become_conddp(arguments, options, out.write, err.write);
  close(out.write);
  if (err.read >= 0) close(err.write);
  if (options.kill_after_us >= 0) {
    usleep(static_cast<useconds_t>(options.kill_after_us));
    kill(child, SIGKILL);
  }
  ProcessResult result;
  collect(child, out.read, err.read, options, result);
  close(out.read);
  if (err.read >= 0) close(err.read);
  int status = 0;
  waitpid(child, &status, 0);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

TemporaryFolder::TemporaryFolder() {
  char name[] = "/tmp/conddp_cli_XXXXXX";
  if (mkdtemp(name) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& text) const {
  std::filesystem::create_directories((path_ / name).parent_path());
  std::ofstream(path_ / name, std::ios::binary) << text;
  return (path_ / name).string();
}

std::vector<std::string> TemporaryFolder::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path_))
    if (!std::filesystem::is_directory(entry.symlink_status()))
      names.push_back(entry.path().lexically_relative(path_).string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string source(const std::string& name) {
  return (std::filesystem::path(CONDDP_SOURCE_DIR) / name).string();
}

}  // namespace conddp
