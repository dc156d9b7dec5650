#pragma once

#include <filesystem>
#include <string>

#include "base/text/diagnostic.hpp"
#include "problem_file/model/spec_collision.hpp"

namespace conddp {

/// A convex body around the mesh of an STL or OBJ file, its coordinates times `scale`: the hull of
/// some of its vertices, expanded so that it contains all, by at most half a percent of the largest
/// distance along an axis. `defect` says why a file has no body. A file that has one is noted as a
/// data file.
HullSpec mesh_hull(const std::filesystem::path& file, const Vector3<double>& scale,
                   std::string& defect, Diagnostics& out);

}  // namespace conddp
