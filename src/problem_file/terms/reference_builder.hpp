#pragma once

#include "problem_file/data/data_table.hpp"
#include "problem_file/data/time_series.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// The reference of a cost over time, in the numbers that its residual takes as parameters.
/// `times` are those of the nodes, for way-points given by knots.
std::optional<TimeSeries> build_reference(const CostSpec& cost, const CostResidual& residual,
                                          const Plant& plant, const StateBuilder& states,
                                          const std::vector<double>& times, Diagnostics& out);

/// Its value at a time: between way-points, or held where the residual's references are.
std::vector<double> reference_at(const CostSpec& cost, const TimeSeries& reference, double time);

/// Columns of a file's table as a series on a manifold; quaternions must have length 1. Rows with
/// an empty cell in one of the columns are left out. A missing column is reported.
std::optional<TimeSeries> series_of(const DataFileSpec& file, const DataTable& table,
                                    const std::vector<std::string>& columns,
                                    const StateManifold& manifold, Diagnostics& out);

}  // namespace conddp
