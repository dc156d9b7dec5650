#pragma once

#include <filesystem>

#include "batch/results/collect.hpp"

namespace conddp {

/// What became of the solutions that are kept.
struct DatasetCount {
  std::size_t solutions = 0;   ///< in the file
  std::size_t unreadable = 0;  ///< damaged since they were written, and left out
};

/// Writes dataset.h5 of a run: a group for each shape of problem (columns, knots, contacts,
/// constraints), `shape_1` and so on in the order of the items, with arrays whose first index is
/// the item: t, x, u, contact forces, gains, multipliers, parameters (what was varied, lists number
/// by number), cost, status, solver, problem file. Names and units are attributes; those of tangent
/// vectors only where the problem files are what they were. Only items whose solution is kept are
/// in it; numbers that an item has not are NaN. Without one no file is written; a former one is
/// removed if all items have results and keep none. Throws OutputError.
DatasetCount write_dataset(const std::filesystem::path& run, const Manifest& manifest,
                           const StoredResults& results);

}  // namespace conddp
