// Which conddp this is and how it was built.
#pragma once

#include <span>
#include <string_view>

namespace conddp {

struct LibraryVersion {
  std::string_view name;
  std::string_view version;
};

/// Facts about the running program, fixed when it was built.
struct BuildInfo {
  std::string_view version;          ///< "0.1.0"
  std::string_view revision;         ///< abbreviated git revision, or "unknown" outside a clone
  bool dirty;                        ///< tracked files differed from that revision
  std::string_view compiler;         ///< name and version
  std::string_view build_type;       ///< "Release", "Debug", "Sanitize", ...
  std::string_view flags;            ///< the build type's compiler flags
  std::string_view march;            ///< argument of -march, empty for the compiler's default
  std::string_view instruction_set;  ///< widest vector instructions compiled for
  std::span<const LibraryVersion> libraries;
};

const BuildInfo& build_info();

}  // namespace conddp
