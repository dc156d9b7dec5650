#pragma once

#include <memory>

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Sizes that a compiled function must match, and their places in the file.
struct LibraryFit {
  LibraryKnotFunction::Sizes sizes;
  Place states_place, controls_place;
};

/// The function of a loaded library. Null, with an error at the mismatch.
std::shared_ptr<const LibraryKnotFunction> make_library_function(
    const std::shared_ptr<const SharedLibrary>& library, const LibraryFunctionSpec& spec,
    const LibraryFit& fit, Diagnostics& out);

/// The system of a compiled function; null with an error.
std::shared_ptr<const System> build_library_system(const LibrarySystemSpec& spec, Diagnostics& out);

}  // namespace conddp
