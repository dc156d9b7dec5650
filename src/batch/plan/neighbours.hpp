#pragma once

#include "batch/plan/manifest.hpp"

namespace conddp {

/// Items of one block may start from one another, and are solved by one process.
inline constexpr int kNeighbourBlock = 32;

/// Names the parent of each item of a plan with warm starts: of the items before it in its block
/// whose problems have the same shape, the one whose varied values are nearest. Distances of
/// numbers, also of those in lists and mappings, are relative to their range over the whole plan;
/// values of other kinds are the same or one apart. The first of equal distance counts. Items of a
/// block have one problem file and one solver. `shapes`: a number for each item, the same where
/// shape_of() is.
void find_parents(Manifest& manifest, const std::vector<int>& shapes);

/// Items with all that start from them, or from one that does. Both are numbers in their order.
std::vector<std::size_t> with_descendants(const Manifest& manifest,
                                          const std::vector<std::size_t>& items);

/// The block of an item by its number. Without warm starts every item is one.
std::size_t block_of(const Manifest& manifest, std::size_t item);

}  // namespace conddp
