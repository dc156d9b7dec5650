#pragma once

#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// Summary of a solve as text. `certificate` may be null; `colour`: print the status in green or
/// yellow; `notes`: number of hidden notes about the input. In the form of terminal_text.
std::string summary_text(const Solution& solution, const SolutionCertificate* certificate,
                         const std::vector<std::string>& written, bool colour, int notes);

}  // namespace conddp
