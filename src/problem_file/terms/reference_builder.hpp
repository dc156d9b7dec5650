#pragma once

#include "problem_file/data/data_table.hpp"
#include "problem_file/data/time_series.hpp"
#include "problem_file/motion/state_builder.hpp"
#include "problem_file/residuals/cost_residual.hpp"

namespace conddp {

/// The reference of a cost over time, as parameters of its residual. `times`: times of the nodes,
/// for way-points given by knots.
std::optional<TimeSeries> build_reference(const CostSpec& cost, const CostResidual& residual,
                                          const Plant& plant, const StateBuilder& states,
                                          const std::vector<double>& times, Diagnostics& out);

/// Its value at a time: interpolated between way-points, or held if its form says so.
std::vector<double> reference_at(const CostSpec& cost, const TimeSeries& reference, double time);

/// Columns of a file's table as a series on a manifold; quaternions must have unit length. Rows
/// with an empty cell in one of the columns are skipped. A missing column is reported.
std::optional<TimeSeries> series_of(const DataFileSpec& file, const DataTable& table,
                                    const std::vector<std::string>& columns,
                                    const StateManifold& manifold, Diagnostics& out);

}  // namespace conddp
