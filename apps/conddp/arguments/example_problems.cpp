#include "arguments/example_problems.hpp"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "arguments/installed_data.hpp"
#include "base/files/text_file.hpp"
#include "base/text/spelling.hpp"
#include "base/text/utf8.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".yaml";
/// Subfolder of the examples with closed loops.
constexpr const char* kLoops = "mpc";

std::vector<fs::path> problems_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (std::error_code unknown;
        entry->path().extension() == kSuffix && entry->is_regular_file(unknown))
      files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<fs::path> example_folders() {
  std::vector<fs::path> folders = {"problems", installed_data() / "problems"};
  std::erase_if(folders, [](const fs::path& folder) { return problems_in(folder).empty(); });
  return folders;
}

std::vector<fs::path> example_problems() {
  std::vector<fs::path> problems;
  const auto add = [&](const fs::path& folder) {
    for (fs::path& file : problems_in(folder))
      if (std::none_of(problems.begin(), problems.end(),
                       [&](const fs::path& known) { return known.stem() == file.stem(); }))
        problems.push_back(std::move(file));
  };
  for (const fs::path& folder : example_folders()) {
    add(folder);
    add(folder / kLoops);
  }
  return problems;
}

namespace {

/// The period that ends the first sentence, followed by a space or the end.
std::size_t sentence_end(const std::string& text) {
  for (std::size_t at = 0; (at = text.find('.', at)) != text.npos; ++at)
    if (at + 1 == text.size() || text[at + 1] == ' ') return at;
  return text.npos;
}

}  // namespace

std::string example_summary(const fs::path& file) {
  std::istringstream lines(read_text_file(file, kMaxYamlBytes).text);
  std::string text;
  for (std::string line; std::getline(lines, line) && line.starts_with('#');) {
    if (line.starts_with("# yaml-language-server:")) continue;
    const std::size_t start = std::min(line.find_first_not_of("# "), line.size());
    text += (text.empty() ? "" : " ") + line.substr(start);
    if (const std::size_t end = sentence_end(text); end != text.npos)
      return printable(text.substr(0, end));
  }
  return printable(text);
}

std::optional<fs::path> find_problem_file(const std::string& word, Diagnostics& out) {
  std::error_code error;
  const bool name =
      word.find('/') == word.npos && !word.starts_with('-') && fs::path(word).extension().empty();
  if (!name || fs::exists(fs::symlink_status(word, error))) return word;
  const std::vector<fs::path> problems = example_problems();
  std::vector<std::string> names;
  for (const fs::path& file : problems) {
    if (file.stem() == word) return file;
    names.push_back(file.stem().string());
  }
  out.error({}, fmt::format("'{}' is neither a file nor an example problem", word),
            names.empty() ? "" : name_hint(word, names, "example problems"), names);
  return std::nullopt;
}

}  // namespace conddp
