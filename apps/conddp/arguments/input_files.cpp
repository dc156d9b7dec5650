#include "arguments/input_files.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace conddp {

namespace fs = std::filesystem;

std::vector<fs::path> input_files(const std::vector<std::string>& arguments,
                                  const std::string& suffix, Diagnostics& out) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (!fs::is_directory(argument, error)) {
      files.emplace_back(argument);
      continue;
    }
    std::vector<fs::path> found;
    for (fs::directory_iterator entry(argument, error), end; !error && entry != end;
         entry.increment(error))
      if (std::error_code unknown;
          entry->path().extension() == suffix && !entry->is_directory(unknown))
        found.push_back(entry->path());
    if (error)
      out.error({}, fmt::format("'{}' cannot be read: {}", argument, error.message()));
    else if (found.empty())
      out.error({}, fmt::format("there is no *{} in '{}'", suffix, argument));
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  std::vector<fs::path> seen;
  for (const fs::path& file : files) {
    const fs::path normal = fs::absolute(file).lexically_normal();
    if (std::find(seen.begin(), seen.end(), normal) != seen.end())
      out.error({}, fmt::format("'{}' stands twice on the command line", file.string()));
    seen.push_back(normal);
  }
  return files;
}

}  // namespace conddp
