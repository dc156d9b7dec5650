#pragma once

#include "batch/plan/manifest.hpp"

namespace conddp {

/// Size of a block. Items of one block may start from one another, and are solved by one process.
inline constexpr int kNeighbourBlock = 32;

/// Sets the parent of each item in a plan with warm starts. The parent is an earlier item of the
/// block with the same problem shape, whose varied values are nearest. Distances of numbers,
/// including those in lists and mappings, are relative to their range over the whole plan. Other
/// values have a distance of 0 if equal, else 1. Ties go to the first item. Items of a block share
/// the problem file and the solver. `shapes`: a number for each item, equal for equal shape_of().
void find_parents(Manifest& manifest, const std::vector<int>& shapes);

/// Items with all of their descendants, the items that start from them directly or indirectly. Both
/// lists are ascending indices.
std::vector<std::size_t> with_descendants(const Manifest& manifest,
                                          const std::vector<std::size_t>& items);

/// The block of an item, given by index. Without warm starts every item is a block.
std::size_t block_of(const Manifest& manifest, std::size_t item);

}  // namespace conddp
