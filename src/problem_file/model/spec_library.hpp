#pragma once

#include <memory>

#include "base/shared_library.hpp"
#include "problem_file/model/spec_values.hpp"
#include "systems/libraries/library_system.hpp"

namespace conddp {

/// A compiled function as named in a file.
struct LibraryFunctionSpec {
  Name library;  ///< as written in the file
  Name function;
  NamedNumbers parameters;  ///< the numbers of its input p in order
  Place parameters_place;
};

/// System of a compiled function; the reader has loaded its library.
struct LibrarySystemSpec {
  LibraryFunctionSpec function;
  LibrarySystemColumns columns;
  Place states_place, controls_place;
  std::shared_ptr<const SharedLibrary> loaded;
};

}  // namespace conddp
