#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "output/mpc/loop_task.hpp"

namespace conddp {

/// What was found out about a closed loop.
struct LoopCertificate {
  Certificate checks;
  std::vector<std::string> missing;  ///< files beside mpc.json that could not be checked
  double time_s = 0;                 ///< that it took
};

/// Judges an mpc.json against its loop, with the files beside it in `folder`: moves the plant from
/// each row of closed_loop.csv to the next with the control there, without the controller; sums
/// cost and violation over the rows; simulates the loop again, with the same ticks late. The same
/// build has the same bytes, another one the same numbers to 10⁻⁶. Throws MalformedSolution where
/// the document lacks keys.
LoopCertificate certify_loop(const OrderedJson& document, const std::filesystem::path& folder,
                             const LoopTask& task);

/// One line: "replayed (31 checks)", or the first check that does not hold.
std::string certificate_line(const LoopCertificate& certificate);

/// The verdict and all checks, for `verify --json`.
OrderedJson certificate_json(const LoopCertificate& certificate);

}  // namespace conddp
