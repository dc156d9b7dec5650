#pragma once

#include <map>
#include <string>
#include <vector>

#include "batch/results/collect.hpp"

namespace conddp {

/// Items of a run that stand out in one respect, by index.
struct StandOut {
  std::string title;
  std::vector<std::size_t> items;
};

/// The slowest items, the solved items with the lowest and with the highest cost, and items with a
/// result that are not solved. Each list contains at most `most` items, the most extreme first.
std::vector<StandOut> items_that_stand_out(const Manifest& manifest, const StoredResults& results,
                                           std::size_t most);

/// Files of items relative to the page, by item index.
using ItemLinks = std::map<std::size_t, std::vector<std::string>>;

/// Data of a run for its report page: counts by status and rows of items for maps and
/// distributions; for large runs only one of `every` items. Also the items that stand out, and
/// overlaid trajectories of one shape.
OrderedJson batch_report(const Manifest& manifest, const StoredResults& results,
                         const std::vector<StandOut>& stand_out, const ItemLinks& links);

}  // namespace conddp
