#include "base/json/relative_paths.hpp"

namespace conddp {

std::string relative_path(const std::filesystem::path& file, const std::filesystem::path& folder) {
  return std::filesystem::proximate(file, folder.empty() ? "." : folder).generic_string();
}

void make_paths_relative(OrderedJson& problem, const std::filesystem::path& from,
                         const std::filesystem::path& folder) {
  if (!problem.is_structured()) return;
  for (auto& [key, value] : problem.items()) {
    if (value.is_string() && (key == "urdf" || key == "file"))
      value = relative_path(from / value.get<std::string>(), folder);
    else
      make_paths_relative(value, from, folder);
  }
}

}  // namespace conddp
