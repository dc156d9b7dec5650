#pragma once

#include <filesystem>
#include <string>

#include "base/text/diagnostic.hpp"
#include "problem_file/model/spec_collision.hpp"

namespace conddp {

/// A convex body around the mesh of a file, whose coordinates are multiplied by `scale`. It is the
/// hull of some vertices, expanded so that it contains all: by at most half a percent of the
/// largest distance along an axis. The file, and those that it names, become data files of the
/// problem. A file without a body sets `defect`.
HullSpec mesh_hull(const std::filesystem::path& file, const Vector3<double>& scale,
                   std::string& defect, Diagnostics& out);

}  // namespace conddp
