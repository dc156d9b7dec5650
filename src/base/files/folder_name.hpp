#pragma once

#include <cstddef>
#include <string_view>

namespace conddp {

inline constexpr std::size_t kLongestFolderName = 200;  ///< bytes
inline constexpr const char* kFolderNameRule =
    "the name is also that of a folder: no '/', no '\\', no '.' in front, at most 200 bytes";

/// True if a name denotes a direct subfolder that is not hidden.
inline bool names_folder(std::string_view name) {
  return name.find_first_of("/\\") == std::string_view::npos && !name.starts_with('.') &&
         name.size() <= kLongestFolderName;
}

}  // namespace conddp
