#pragma once

#include <map>
#include <string>
#include <vector>

#include "batch/results/collect.hpp"

namespace conddp {

/// Items of a run that stand out in one way, by their numbers.
struct StandOut {
  std::string title;
  std::vector<std::size_t> items;
};

/// The slowest items, those of least and of greatest cost among the solved ones, and items that
/// have a result and are not solved: at most `most` each, the foremost first.
std::vector<StandOut> items_that_stand_out(const Manifest& manifest, const StoredResults& results,
                                           std::size_t most);

/// Files of items as seen from the page, by the items' numbers.
using ItemLinks = std::map<std::size_t, std::vector<std::string>>;

/// What the page of a report shows of a run: counts by status, rows of items for maps and
/// distributions (of large runs one item of several, `every`), the items that stand out, and
/// trajectories of one shape over each other.
OrderedJson batch_report(const Manifest& manifest, const StoredResults& results,
                         const std::vector<StandOut>& stand_out, const ItemLinks& links);

}  // namespace conddp
