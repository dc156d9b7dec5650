#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "output/mpc/loop_task.hpp"

namespace conddp {

/// Result of checking a closed loop.
struct LoopCertificate {
  Certificate checks;
  std::vector<std::string> missing;  ///< files next to mpc.json that could not be checked
  double time_s = 0;                 ///< duration of the check
};

/// Checks an mpc.json against its loop, using the files next to it in `folder`. Steps the plant
/// from each row of closed_loop.csv to the next with the row's control, without the controller.
/// Sums cost and violation over the rows. Simulates the loop again, with the same late ticks. The
/// same build must reproduce the files byte for byte, another build the numbers to 10⁻⁶. Throws
/// MalformedSolution if the document lacks keys.
LoopCertificate certify_loop(const OrderedJson& document, const std::filesystem::path& folder,
                             const LoopTask& task);

/// One line: "replayed (31 checks)", or the first failed check.
std::string certificate_line(const LoopCertificate& certificate);

/// The verdict and all checks, for `verify --json`.
OrderedJson certificate_json(const LoopCertificate& certificate);

}  // namespace conddp
