#include "arguments/installed_data.hpp"

#include <fstream>

namespace conddp {

namespace fs = std::filesystem;

fs::path installed_data() {
  std::error_code error;
  const fs::path tool = fs::read_symlink("/proc/self/exe", error);
  return (tool.parent_path() / CONDDP_DATA_FROM_TOOL).lexically_normal();
}

std::string installed_package() {
  std::string kind;
  std::ifstream file(installed_data() / "package");
  return std::getline(file, kind) ? kind : "built from source";
}

}  // namespace conddp
