#pragma once

#include <filesystem>

#include "batch/results/collect.hpp"

namespace conddp {

/// Writes dataset.h5: a group for each shape of problem (columns, knots, contacts), `shape_1` and
/// so on in the order of the items, with arrays whose first index is the item: t, x, u, contact
/// forces, gains, multipliers, parameters (what was varied), cost, status. Names and units are
/// attributes. Only items whose solution is kept are in it; numbers that an item has not are NaN.
/// Returns how many there are; without one, no file is written, and a former one is removed. Throws
/// OutputError.
std::size_t write_dataset(const Manifest& manifest, const StoredResults& results,
                          const std::filesystem::path& file);

}  // namespace conddp
