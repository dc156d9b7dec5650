#pragma once

#include <filesystem>

#include "batch/results/collect.hpp"

namespace conddp {

/// Counts of the stored solutions.
struct DatasetCount {
  std::size_t solutions = 0;   ///< number in the file
  std::size_t unreadable = 0;  ///< damaged since they were written, and omitted
};

/// Writes dataset.h5 of a run, with a group for each problem shape (columns, knots, contacts,
/// constraints). Groups are named `shape_1` and so on in the order of the items. The first index of
/// each array is the item: t, x, u, contact forces, gains, multipliers, parameters (varied values,
/// lists number by number), cost, status, solver, problem file. Names and units are attributes;
/// those of tangent vectors are included only if the problem files are unchanged. Includes only
/// items with a stored solution; numbers that an item lacks are NaN. Without any solution the file
/// is not written. An existing one is removed if all items have results and none is stored. Throws
/// OutputError.
DatasetCount write_dataset(const std::filesystem::path& run, const Manifest& manifest,
                           const StoredResults& results);

}  // namespace conddp
