#include "base/shared_library.hpp"

#include <atomic>

#include <dlfcn.h>

#include <fmt/format.h>

namespace conddp {
namespace {

std::atomic<bool> g_allowed = false;

/// Returns `found`; throws with the linker's message if it is null.
void* checked(void* found, const std::string& what) {
  if (found == nullptr) throw LibraryError(fmt::format("{} cannot be loaded: {}", what, dlerror()));
  return found;
}

}  // namespace

SharedLibrary::SharedLibrary(const std::string& what, std::initializer_list<const char*> files)
    : what_(what), handle_(nullptr) {
  for (const char* file : files)
    if (handle_ == nullptr) handle_ = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  checked(handle_, what);
}

void* SharedLibrary::symbol(const char* name) const { return checked(find(name), what_); }

void* SharedLibrary::find(const char* name) const { return dlsym(handle_, name); }

bool code_is_allowed() { return g_allowed; }
void allow_code() { g_allowed = true; }

}  // namespace conddp
