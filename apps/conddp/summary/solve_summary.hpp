#pragma once

#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"
#include "output/solution/solution.hpp"

namespace conddp {

/// How a solve ended, for people. `certificate` may be null; `colour`: the status in green or
/// yellow; `notes`: how many notes about the input were not shown. In the form of terminal_text.
std::string summary_text(const Solution& solution, const SolutionCertificate* certificate,
                         const std::vector<std::string>& written, bool colour, int notes);

}  // namespace conddp
