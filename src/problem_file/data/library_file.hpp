#pragma once

#include <filesystem>
#include <memory>

#include "base/shared_library.hpp"
#include "base/text/diagnostic.hpp"

namespace conddp {

/// Loads a library of compiled code that a problem file names, seen from its folder, and remembers
/// it with its hash as a data file. Null, with an error at the name, where there is none, it cannot
/// be loaded, or compiled code is not allowed.
std::shared_ptr<const SharedLibrary> load_library_file(const std::filesystem::path& folder,
                                                       const Name& name, Diagnostics& out);

}  // namespace conddp
