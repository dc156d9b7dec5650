#pragma once

#include <memory>

#include "base/shared_library.hpp"
#include "problem_file/spec/spec_values.hpp"
#include "systems/libraries/library_system.hpp"

namespace conddp {

/// A compiled function as a file names it.
struct LibraryFunctionSpec {
  Name library;  ///< as the file says it
  Name function;
  NamedNumbers parameters;  ///< the numbers of its input p in order
  Place parameters_place;
};

/// A system of a compiled function, whose library the reader has loaded.
struct LibrarySystemSpec {
  LibraryFunctionSpec function;
  LibrarySystemColumns columns;
  Place states_place, controls_place;
  std::shared_ptr<const SharedLibrary> loaded;
};

}  // namespace conddp
