#pragma once

#include <filesystem>
#include <memory>

#include "base/shared_library.hpp"
#include "base/text/diagnostic.hpp"

namespace conddp {

/// Loads a library of compiled code that a problem file names, relative to the file's folder, and
/// records it with its hash as a data file. Null with an error at the name if the file does not
/// exist, cannot be loaded, or compiled code is not allowed.
std::shared_ptr<const SharedLibrary> load_library_file(const std::filesystem::path& folder,
                                                       const Name& name, Diagnostics& out);

}  // namespace conddp
