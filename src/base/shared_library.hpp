#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string>

namespace conddp {

/// A library loaded at runtime is missing or incomplete. The message describes the unavailable
/// feature and the linker's reason.
class LibraryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A shared library that is loaded on first use. It is for libraries that pull in many others and
/// that few commands need. It stays loaded until the program ends.
class SharedLibrary {
 public:
  /// `what` is the subject of error messages, such as "HDF5". Loads the first of `files` that can
  /// be loaded. An entry is a path, with "$ORIGIN" for the folder of the program, or a name that
  /// the linker searches for. Throws LibraryError with the reason for the last one.
  SharedLibrary(const std::string& what, std::initializer_list<const char*> files);

  /// The address of a function or variable. Throws LibraryError.
  void* symbol(const char* name) const;
  /// Same as symbol(), but null if it does not exist.
  void* find(const char* name) const;

 private:
  std::string what_;
  void* handle_;
};

}  // namespace conddp
