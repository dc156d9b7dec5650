#include "process.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "child.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

void limit_resources(const ProcessOptions& options) {
  if (options.limit_file_size >= 0) {
    const rlimit limit{static_cast<rlim_t>(options.limit_file_size),
                       static_cast<rlim_t>(options.limit_file_size)};
    setrlimit(RLIMIT_FSIZE, &limit);
    signal(SIGXFSZ, SIG_DFL);
  }
  const auto limit = [](auto resource, long value) {
    const rlimit both{static_cast<rlim_t>(value), static_cast<rlim_t>(value)};
    if (value > 0) setrlimit(resource, &both);
  };
  limit(RLIMIT_CPU, options.limits.processor_s);
  limit(RLIMIT_AS, options.limits.memory_bytes);
}

}  // namespace

ProcessResult run_conddp(const std::vector<std::string>& arguments, const ProcessOptions& options) {
  const Channel out = open_pipe();
  const Channel err = open_pipe();
  const pid_t child = start_conddp(arguments, options.environment, out, err, [&] {
    if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) _exit(120);
    limit_resources(options);
  });
  if (options.kill_after_us >= 0) {
    usleep(static_cast<useconds_t>(options.kill_after_us));
    kill(child, SIGKILL);
  }
  bool signalled = options.signal == 0;
  return collect_child(child, out, err, [&](const ProcessResult& so_far) {
    if (signalled || so_far.err.find(options.signal_after) == std::string::npos) return;
    kill(child, options.signal);
    signalled = true;
  });
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string source(const std::string& name) { return (source_tree() / name).string(); }

bool fits_schema(const std::string& schema, const std::string& document) {
  const TemporaryFolder folder;
  const std::string command = source("scripts/validate_json") + " " +
                              source("schemas/" + schema + ".schema.json") + " " +
                              folder.write("document.json", document);
  return std::system(command.c_str()) == 0;
}

}  // namespace conddp
