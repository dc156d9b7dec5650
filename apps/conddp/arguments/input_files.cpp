#include "arguments/input_files.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace conddp {

namespace fs = std::filesystem;

namespace {

/// The files of a folder with this suffix, sorted; an empty list is an error.
std::vector<fs::path> files_in(const std::string& folder, const std::string& suffix,
                               Diagnostics& out) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (std::error_code unknown;
        entry->path().extension() == suffix && !entry->is_directory(unknown))
      found.push_back(entry->path());
  if (error)
    out.error({}, fmt::format("'{}' cannot be read: {}", folder, error.message()));
  else if (found.empty())
    out.error({}, fmt::format("there is no *{} in '{}'", suffix, folder));
  std::sort(found.begin(), found.end());
  return found;
}

void check_repeated(const std::vector<fs::path>& files, Diagnostics& out) {
  std::vector<fs::path> seen;
  for (const fs::path& file : files) {
    const fs::path normal = fs::absolute(file).lexically_normal();
    if (std::find(seen.begin(), seen.end(), normal) != seen.end())
      out.error({}, fmt::format("'{}' stands twice on the command line", file.string()));
    seen.push_back(normal);
  }
}

}  // namespace

std::vector<fs::path> input_files(const std::vector<std::string>& arguments,
                                  const std::string& suffix, Diagnostics& out) {
  std::vector<fs::path> files;
  for (const std::string& argument : arguments) {
    if (std::error_code error; !fs::is_directory(argument, error)) {
      files.emplace_back(argument);
      continue;
    }
    const std::vector<fs::path> found = files_in(argument, suffix, out);
    files.insert(files.end(), found.begin(), found.end());
  }
  check_repeated(files, out);
  return files;
}

}  // namespace conddp
